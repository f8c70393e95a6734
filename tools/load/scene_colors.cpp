#include "load/scene_colors.h"

#include "load/clean_mesh.h"

#include <occlude/core/rng.h>

#include <glm/common.hpp>

#include <algorithm>

namespace occlude::tools {
namespace {

/// A muted colour, different for different hashes.
glm::vec3 pleasant_color(uint64_t hash)
{
    const float value = 0.45f + 0.35f * uniform01(mix64(hash));
    const float warm = uniform01(mix64(hash + 1));
    const float green = uniform01(mix64(hash + 2));
    const glm::vec3 tint{0.85f + 0.15f * warm, 0.82f + 0.18f * green, 1.0f - 0.3f * warm};
    return value * tint;
}

uint64_t hash_text(std::string_view text)
{
    uint64_t hash = 0;
    for (const char c : text) {
        hash = hash64(hash, static_cast<unsigned char>(c));
    }
    return hash;
}

} // namespace

glm::vec3 color_of(const LoadedScene& scene, uint32_t material_index, std::string_view mesh_name)
{
    uint64_t identity = hash_text(mesh_name);
    if (material_index < scene.materials.size()) {
        const LoadedMaterial& material = scene.materials[material_index];
        const glm::vec3 rgb = material.color.value_or(glm::vec3{1.0f});
        const float least = std::min({rgb.r, rgb.g, rgb.b});
        const float most = std::max({rgb.r, rgb.g, rgb.b});
        // Written so that NaN answers false.
        if (least >= 0.0f && least < 0.99f && most > 0.02f && most <= kLargestCoordinate) {
            return glm::min(rgb, glm::vec3{1.0f});
        }
        if (scene.materials.size() > 1) {
            identity = hash64(hash_text(material.name), material_index);
        }
    }
    return pleasant_color(identity);
}

} // namespace occlude::tools
