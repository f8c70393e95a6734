#include "load/gltf_accessors.h"

#include <fmt/format.h>

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>
#include <string_view>

namespace occlude::tools {
namespace {

using nlohmann::json;

enum ComponentType : uint32_t {
    kByte = 5120,
    kUnsignedByte = 5121,
    kShort = 5122,
    kUnsignedShort = 5123,
    kUnsignedInt = 5125,
    kFloat = 5126,
};

size_t size_of(uint32_t component_type)
{
    switch (component_type) {
    case kByte:
    case kUnsignedByte:
        return 1;
    case kShort:
    case kUnsignedShort:
        return 2;
    case kUnsignedInt:
    case kFloat:
        return 4;
    default:
        throw GltfError{fmt::format("an accessor has the component type {}, which glTF does not "
                                    "know; export it again",
                                    component_type)};
    }
}

int components_of(const std::string& type)
{
    constexpr std::pair<std::string_view, int> kTypes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3},
                                                           {"VEC4", 4},   {"MAT2", 4}, {"MAT3", 9},
                                                           {"MAT4", 16}};
    for (const auto& [name, components] : kTypes) {
        if (name == type) {
            return components;
        }
    }
    throw GltfError{
        fmt::format("an accessor has the type '{}', which glTF does not know; export it "
                    "again",
                    type)};
}

template <class T>
T value_at(const uint8_t* bytes)
{
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/// A part of `bytes`. Throws GltfError if it is not inside.
Bytes part_of(Bytes bytes, uint64_t offset, uint64_t size, const char* what)
{
    if (offset > bytes.size() || size > bytes.size() - offset) {
        throw GltfError{fmt::format("{} reaches beyond its buffer ({} bytes from {}, of {}); the "
                                    "file is broken, export it again",
                                    what, size, offset, bytes.size())};
    }
    return bytes.subspan(offset, size);
}

} // namespace

float AccessorView::number(size_t element, int component) const
{
    const uint8_t* bytes = at(element, component);
    const auto signed_share = [&](float value, float most) {
        return normalized_ ? std::max(value / most, -1.0f) : value;
    };
    switch (component_type_) {
    case kByte:
        return signed_share(value_at<int8_t>(bytes), 127.0f);
    case kUnsignedByte:
        return signed_share(*bytes, 255.0f);
    case kShort:
        return signed_share(value_at<int16_t>(bytes), 32767.0f);
    case kUnsignedShort:
        return signed_share(value_at<uint16_t>(bytes), 65535.0f);
    case kUnsignedInt:
        return static_cast<float>(value_at<uint32_t>(bytes));
    default:
        return value_at<float>(bytes);
    }
}

uint32_t AccessorView::whole(size_t element, int component) const
{
    const uint8_t* bytes = at(element, component);
    switch (component_type_) {
    case kUnsignedByte:
        return *bytes;
    case kUnsignedShort:
        return value_at<uint16_t>(bytes);
    case kUnsignedInt:
        return value_at<uint32_t>(bytes);
    default:
        throw GltfError{"an accessor of indices or joints holds no unsigned integers; the file is "
                        "broken, export it again"};
    }
}

glm::vec3 AccessorView::vec3(size_t element) const
{
    return {number(element, 0), number(element, 1), number(element, 2)};
}

glm::vec4 AccessorView::vec4(size_t element) const
{
    return {vec3(element), number(element, 3)};
}

glm::dmat4 AccessorView::mat4(size_t element) const
{
    glm::dmat4 matrix;
    for (int i = 0; i < 16; ++i) {
        matrix[i / 4][i % 4] = number(element, i);
    }
    return matrix;
}

const AccessorView& GltfAccessors::open(size_t index)
{
    const auto found = accessors_.find(index);
    return found != accessors_.end() ? found->second
                                     : accessors_.emplace(index, make(index)).first->second;
}

const AccessorView& GltfAccessors::open(size_t index, const char* type)
{
    const std::string actual = text_of(document_.entry("accessors", index), "type");
    if (actual != type) {
        throw GltfError{fmt::format("accessor {} is of type '{}' where {} is needed; the file is "
                                    "broken, export it again",
                                    index, actual, type)};
    }
    return open(index);
}

uint8_t* GltfAccessors::allocate(uint64_t bytes)
{
    document_.charge(bytes);
    return owned_.emplace_back(bytes).data();
}

AccessorView GltfAccessors::make(size_t index)
{
    const json& description = document_.entry("accessors", index);
    AccessorView view;
    view.component_type_ = index_of(description, "componentType");
    view.component_size_ = size_of(view.component_type_);
    view.components_ = components_of(text_of(description, "type"));
    view.count_ = index_of(description, "count");
    view.normalized_ = description.value("normalized", false);
    const size_t element = view.component_size_ * static_cast<size_t>(view.components_);
    view.stride_ = element;
    const bool is_sparse = description.contains("sparse");
    if (!description.contains("bufferView")) {
        view.data_ = allocate(uint64_t{view.count_} * element); // zeros, by definition
    } else {
        const uint32_t source = index_of(description, "bufferView");
        view.stride_ = index_or(document_.entry("bufferViews", source), "byteStride",
                                static_cast<uint32_t>(element));
        const uint64_t offset = index_or(description, "byteOffset", 0);
        const uint64_t size =
            view.count_ == 0 ? 0 : uint64_t{view.count_ - 1} * view.stride_ + element;
        const std::string what = fmt::format("accessor {}", index);
        view.data_ = part_of(buffer_view(source), offset, size, what.c_str()).data();
    }
    if (is_sparse) {
        overlay(view, description["sparse"]);
    }
    return view;
}

// Replaces the elements that a sparse accessor lists.
void GltfAccessors::overlay(AccessorView& view, const json& sparse)
{
    const size_t element = view.component_size_ * static_cast<size_t>(view.components_);
    uint8_t* dense = allocate(uint64_t{view.count_} * element);
    for (size_t i = 0; i < view.count_; ++i) {
        std::memcpy(dense + i * element, view.at(i, 0), element);
    }
    const size_t count = index_of(sparse, "count");
    const json& indices = sparse.at("indices");
    const json& values = sparse.at("values");
    AccessorView where;
    where.component_type_ = index_of(indices, "componentType");
    where.component_size_ = size_of(where.component_type_);
    where.stride_ = where.component_size_;
    where.data_ =
        part_of(buffer_view(index_of(indices, "bufferView")), index_or(indices, "byteOffset", 0),
                uint64_t{count} * where.stride_, "a list of sparse indices")
            .data();
    const Bytes what =
        part_of(buffer_view(index_of(values, "bufferView")), index_or(values, "byteOffset", 0),
                uint64_t{count} * element, "a list of sparse values");
    for (size_t i = 0; i < count; ++i) {
        const size_t target = where.whole(i, 0);
        if (target >= view.count_) {
            throw GltfError{fmt::format("a sparse accessor replaces element {} of {}; the file is "
                                        "broken, export it again",
                                        target, view.count_)};
        }
        std::memcpy(dense + target * element, what.data() + i * element, element);
    }
    view.data_ = dense;
    view.stride_ = element;
}

Bytes GltfAccessors::buffer_view(size_t index)
{
    if (const auto found = views_.find(index); found != views_.end()) {
        return found->second;
    }
    const json& description = document_.entry("bufferViews", index);
    Bytes bytes;
    if (const json* compression = extension_of(description, "EXT_meshopt_compression")) {
        bytes = decompressed(*compression);
    } else {
        const std::string what = fmt::format("buffer view {}", index);
        bytes = part_of(document_.buffer(index_of(description, "buffer")),
                        index_or(description, "byteOffset", 0), index_of(description, "byteLength"),
                        what.c_str());
    }
    return views_.emplace(index, bytes).first->second;
}

Bytes GltfAccessors::decompressed(const json& compression)
{
    const Bytes source = part_of(document_.buffer(index_of(compression, "buffer")),
                                 index_or(compression, "byteOffset", 0),
                                 index_of(compression, "byteLength"), "a compressed buffer view");
    const size_t count = index_of(compression, "count");
    const size_t stride = index_of(compression, "byteStride");
    const std::string mode = text_of(compression, "mode");
    const std::string filter = text_of(compression, "filter");
    const bool is_vertices = mode == "ATTRIBUTES";
    const bool is_index = mode == "TRIANGLES" || mode == "INDICES";
    if ((!is_vertices && !is_index) || (is_index && stride != 2 && stride != 4) ||
        (is_vertices && (stride == 0 || stride > 256 || stride % 4 != 0)) ||
        (mode == "TRIANGLES" && count % 3 != 0)) {
        throw GltfError{fmt::format("a buffer view is compressed in the mode '{}' with a stride of "
                                    "{}, which EXT_meshopt_compression does not know; export it "
                                    "again",
                                    mode, stride)};
    }
    uint8_t* out = allocate(uint64_t{count} * stride);
    const int failed =
        is_vertices ? meshopt_decodeVertexBuffer(out, count, stride, source.data(), source.size())
        : mode == "INDICES"
            ? meshopt_decodeIndexSequence(out, count, stride, source.data(), source.size())
            : meshopt_decodeIndexBuffer(out, count, stride, source.data(), source.size());
    if (failed != 0) {
        throw GltfError{"a buffer view cannot be decompressed (EXT_meshopt_compression); the file "
                        "is broken, export it again"};
    }
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
        meshopt_decodeFilterOct(out, count, stride);
    } else if (filter == "QUATERNION" && stride == 8) {
        meshopt_decodeFilterQuat(out, count, stride);
    } else if (filter == "EXPONENTIAL") {
        meshopt_decodeFilterExp(out, count, stride);
    } else if (!filter.empty() && filter != "NONE") {
        throw GltfError{fmt::format("a buffer view is filtered by '{}' with a stride of {}, which "
                                    "EXT_meshopt_compression does not know; export it again",
                                    filter, stride)};
    }
    return {out, count * stride};
}

} // namespace occlude::tools
