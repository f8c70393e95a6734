// Numbers of a glTF file: accessors, plain, quantised, sparse and compressed by meshoptimizer.
#pragma once

#include "load/gltf_document.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <map>
#include <memory>

namespace occlude::tools {

/// One accessor, ready to be read. Valid as long as the GltfAccessors that opened it.
class AccessorView {
public:
    size_t count() const { return count_; }
    int components() const { return components_; }

    /// A component as the accessor means it: normalised integers become fractions. Precondition:
    /// element < count(), component < components().
    float number(size_t element, int component) const;
    /// A component of unsigned integers as it is.
    uint32_t whole(size_t element, int component) const;
    glm::vec3 vec3(size_t element) const;
    glm::vec4 vec4(size_t element) const;
    /// Column-major. Precondition: 16 components.
    glm::dmat4 mat4(size_t element) const;

private:
    friend class GltfAccessors;
    const uint8_t* at(size_t element, int component) const
    {
        return data_ + element * stride_ + static_cast<size_t>(component) * component_size_;
    }

    const uint8_t* data_ = nullptr;
    size_t count_ = 0;
    size_t stride_ = 0;
    size_t component_size_ = 0;
    int components_ = 0;
    uint32_t component_type_ = 0;
    bool normalized_ = false;
};

class GltfAccessors {
public:
    /// `document` outlives it.
    explicit GltfAccessors(GltfDocument& document)
        : document_(document)
    {
    }

    /// Throws GltfError for an accessor that is broken or lies outside of its buffer.
    const AccessorView& open(size_t index);
    /// The same, and it must have this "type", such as "VEC3".
    const AccessorView& open(size_t index, const char* type);

    /// The bytes of a buffer view, decompressed.
    Bytes buffer_view(size_t index);

private:
    AccessorView make(size_t index);
    void overlay(AccessorView& view, const nlohmann::json& sparse);
    Bytes decompressed(const nlohmann::json& compression);
    uint8_t* allocate(uint64_t bytes);

    GltfDocument& document_;
    std::map<size_t, AccessorView> accessors_;
    std::map<size_t, Bytes> views_;
    std::vector<std::vector<uint8_t>> owned_;
};

} // namespace occlude::tools
