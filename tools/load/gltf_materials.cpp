#include "load/gltf_materials.h"

namespace occlude::tools {
namespace {

using nlohmann::json;

/// The base colour and its alpha; nothing where the file gives none.
std::optional<glm::vec4> base_color(const json& material)
{
    const json* found = nullptr;
    if (const auto pbr = material.find("pbrMetallicRoughness");
        pbr != material.end() && pbr->is_object() && pbr->contains("baseColorFactor")) {
        found = &(*pbr)["baseColorFactor"];
    } else if (const json* older = extension_of(material, "KHR_materials_pbrSpecularGlossiness");
               older != nullptr && older->contains("diffuseFactor")) {
        found = &(*older)["diffuseFactor"];
    }
    if (found == nullptr || !found->is_array() || found->size() != 4) {
        return std::nullopt;
    }
    glm::vec4 color{0.0f};
    for (int i = 0; i < 4; ++i) {
        const json& component = (*found)[static_cast<size_t>(i)];
        color[i] = component.is_number() ? component.get<float>() : 0.0f;
    }
    return color;
}

Surface surface_of(const json& material)
{
    const std::string mode = text_of(material, "alphaMode");
    if (mode == "BLEND") {
        return Surface::blended;
    }
    const json* transmission = extension_of(material, "KHR_materials_transmission");
    if (transmission != nullptr && number_or(*transmission, "transmissionFactor", 0.0) > 0.0) {
        return Surface::transmissive;
    }
    return mode == "MASK" ? Surface::masked : Surface::opaque;
}

} // namespace

std::vector<LoadedMaterial> read_materials(const GltfDocument& document)
{
    std::vector<LoadedMaterial> materials;
    const size_t count = document.list("materials").size();
    for (size_t i = 0; i < count; ++i) {
        const json& source = document.entry("materials", i);
        const std::optional<glm::vec4> color = base_color(source);
        LoadedMaterial material{.name = text_of(source, "name"), .surface = surface_of(source)};
        if (color) {
            material.color = glm::vec3{*color};
            material.opacity = material.surface == Surface::blended ? color->a : 1.0f;
        }
        if (material.surface == Surface::transmissive) {
            const json& transmission = *extension_of(source, "KHR_materials_transmission");
            material.opacity =
                1.0f - static_cast<float>(number_or(transmission, "transmissionFactor", 0.0));
        }
        materials.push_back(std::move(material));
    }
    return materials;
}

} // namespace occlude::tools
