// What the alpha mask of a material leaves of a triangle.
#pragma once

#include "load/gltf_accessors.h"

#include <glm/vec2.hpp>

#include <cstdint>
#include <vector>

namespace occlude::tools {

enum class Coverage : uint8_t {
    all,  ///< every texel that the triangle can show is kept: it hides what it covers
    none, ///< every one is cut away: it shows nothing
    some, ///< both, or nothing is known
};

/// The texels of a base colour texture that an alpha test cuts away, summed up so that any
/// rectangle is answered at once.
class AlphaMask {
public:
    /// Decodes the texture of a material with "alphaMode": "MASK". A mask without a texture answers
    /// for all triangles alike. Throws GltfError if the texture cannot be read.
    AlphaMask(GltfDocument& document, GltfAccessors& accessors, const nlohmann::json& material);

    bool has_texture() const { return width_ > 0; }
    /// The set of texture coordinates that is used, N of TEXCOORD_N.
    uint32_t texcoord() const { return texcoord_; }

    /// What is left of a triangle with these texture coordinates. Errs toward `some`: it looks at
    /// the rectangle around the triangle, a texel larger for filtering.
    Coverage coverage(const glm::vec2& a, const glm::vec2& b, const glm::vec2& c) const;

private:
    void read_texture(GltfDocument& document, GltfAccessors& accessors,
                      const nlohmann::json& texture_info, float factor, float cutoff);
    void sum_up(const uint8_t* rgba, float factor, float cutoff);
    uint64_t cut_texels(int64_t x_begin, int64_t x_end, int64_t y_begin, int64_t y_end) const;
    glm::vec2 placed(const glm::vec2& uv) const;

    int64_t width_ = 0; ///< 0: no texture
    int64_t height_ = 0;
    Coverage constant_ = Coverage::some; ///< without a texture
    std::vector<uint32_t> sums_;         ///< of texels that are cut away, above and left
    bool repeats_u_ = true;
    bool repeats_v_ = true;
    uint32_t texcoord_ = 0;
    glm::vec2 offset_{0.0f}; ///< KHR_texture_transform
    glm::vec2 scale_{1.0f};
    float rotation_ = 0.0f; ///< radians
};

} // namespace occlude::tools
