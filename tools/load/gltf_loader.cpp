#include "load/gltf_loader.h"

#include "load/alpha_mask.h"
#include "load/gltf_materials.h"
#include "load/gltf_primitive.h"
#include "load/gltf_scene.h"
#include "load/load_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <new>
#include <optional>
#include <tuple>

namespace occlude::tools {
namespace {

using nlohmann::json;

constexpr std::string_view kGeometryExtensions[] = {
    "KHR_mesh_quantization",   "EXT_mesh_gpu_instancing", "KHR_draco_mesh_compression",
    "EXT_meshopt_compression", "KHR_node_visibility",
};
/// Extensions that change neither shapes nor places, by the start of their names.
constexpr std::string_view kShadingExtensions[] = {
    "KHR_materials_",         "EXT_materials_",      "KHR_texture_",         "EXT_texture_",
    "MSFT_texture_",          "KHR_lights_punctual", "EXT_lights_",          "KHR_xmp",
    "KHR_animation_",         "KHR_audio",           "KHR_techniques_webgl", "KHR_technique_webgl",
    "EXT_lights_image_based", "AGI_stk_metadata",    "EXT_structural_",      "EXT_mesh_features",
    "EXT_instance_features",
};

bool is_known(std::string_view extension)
{
    return std::find(std::begin(kGeometryExtensions), std::end(kGeometryExtensions), extension) !=
               std::end(kGeometryExtensions) ||
           std::any_of(std::begin(kShadingExtensions), std::end(kShadingExtensions),
                       [&](std::string_view start) { return extension.starts_with(start); });
}

/// The unknown ones of a list of extensions.
std::vector<std::string> unknown_extensions(const GltfDocument& document, const char* list)
{
    std::vector<std::string> unknown;
    for (const json& name : document.list(list)) {
        if (name.is_string() && !is_known(name.get<std::string>())) {
            unknown.push_back(name.get<std::string>());
        }
    }
    return unknown;
}

/// Corners of the triangles of a primitive, as its accessors say; 0 for a broken one.
uint64_t corners_of(const GltfDocument& document, const json& primitive)
{
    const auto attributes = primitive.find("attributes");
    const json* source = primitive.contains("indices") ? &primitive["indices"]
                         : attributes != primitive.end() && attributes->contains("POSITION")
                             ? &(*attributes)["POSITION"]
                             : nullptr;
    const json& accessors = document.list("accessors");
    if (source == nullptr || !source->is_number_unsigned() ||
        source->get<size_t>() >= accessors.size()) {
        return 0;
    }
    return static_cast<uint64_t>(
        std::max(number_or(accessors[source->get<size_t>()], "count", 0.0), 0.0));
}

uint64_t corners_of_all(const GltfDocument& document)
{
    uint64_t corners = 0;
    for (const json& mesh : document.list("meshes")) {
        const auto primitives = mesh.find("primitives");
        const bool is_list = primitives != mesh.end() && primitives->is_array();
        for (size_t i = 0; is_list && i < primitives->size(); ++i) {
            corners += (*primitives)[i].is_object() ? corners_of(document, (*primitives)[i]) : 0;
        }
    }
    return corners;
}

class Reader {
public:
    Reader(const std::filesystem::path& file, uint64_t memory_budget,
           const std::function<void(double)>& progress)
        : document_(file, memory_budget)
        , accessors_(document_)
        , progress_(progress, 0.0, 1.0, corners_of_all(document_))
    {
    }

    LoadedScene read();

private:
    // A mesh as some node shows it: its own weights and skin make it another one.
    struct Shown {
        std::vector<uint32_t> meshes;   ///< of scene_, one per primitive
        std::vector<glm::dvec3> pivots; ///< per primitive: where its origin is, if it has a skin
    };

    void check_extensions();
    void note_what_is_not_shown();
    void add_node(const PlacedNode& placed);
    const Shown& shown_mesh(const json& node, size_t mesh);
    Shown build(const json& node, size_t mesh);
    void build_primitive(const json& primitive, const VertexMotion& motion, Shown& shown);
    void keep(const json& primitive, const GltfPrimitive& data, const VertexMotion& motion,
              uint32_t material, Shown& shown);
    const AlphaMask* mask_of(uint32_t material);
    uint32_t opaque_part_of(uint32_t material);

    GltfDocument document_;
    GltfAccessors accessors_;
    LoadProgress progress_; ///< in corners of triangles
    LoadedScene scene_;
    std::vector<glm::dmat4> worlds_; ///< empty until a skin asks
    std::map<std::tuple<size_t, uint32_t, std::string>, Shown> shown_;
    std::map<uint32_t, std::optional<AlphaMask>> masks_; ///< by material
    std::map<uint32_t, uint32_t> opaque_parts_;          ///< of masked materials
    std::string mesh_name_;                              ///< of the mesh that is built
    size_t morphed_ = 0;
    size_t skinned_ = 0;
};

void Reader::check_extensions()
{
    if (const auto required = unknown_extensions(document_, "extensionsRequired");
        !required.empty()) {
        throw GltfError{fmt::format("requires the glTF extension {}, which this program does not "
                                    "know; export it without",
                                    fmt::join(required, ", "))};
    }
    for (const std::string& used : unknown_extensions(document_, "extensionsUsed")) {
        scene_.notes.push_back(fmt::format(
            "uses the glTF extension {}, which this program does not know: it is ignored", used));
    }
}

void Reader::note_what_is_not_shown()
{
    const size_t scenes = document_.list("scenes").size();
    if (scenes > 1) {
        scene_.notes.push_back(fmt::format("holds {} scenes; scene {} is shown, its default",
                                           scenes, index_or(document_.root(), "scene", 0)));
    }
    if (!document_.list("animations").empty()) {
        scene_.notes.push_back("holds animations, which are not played");
    }
    if (morphed_ > 0) {
        scene_.notes.push_back(fmt::format(
            "{} meshes have morph targets; they are shown with their default weights", morphed_));
    }
    if (skinned_ > 0) {
        scene_.notes.push_back(fmt::format(
            "{} meshes have skins; they are shown as their joints stand in the file", skinned_));
    }
}

Reader::Shown Reader::build(const json& node, size_t mesh_index)
{
    const json& mesh = document_.entry("meshes", mesh_index);
    VertexMotion motion;
    const json& weights = node.contains("weights")   ? node["weights"]
                          : mesh.contains("weights") ? mesh["weights"]
                                                     : document_.list("no weights");
    for (const json& weight : weights) {
        motion.morph_weights.push_back(weight.is_number() ? weight.get<double>() : 0.0);
    }
    if (node.contains("skin")) {
        if (worlds_.empty()) {
            worlds_ = node_worlds(document_);
        }
        motion.joints = joint_matrices(document_, accessors_, index_of(node, "skin"), worlds_);
        ++skinned_;
    }
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end() || !primitives->is_array()) {
        throw GltfError{fmt::format(
            "mesh {} has no primitives; the file is broken, export it again", mesh_index)};
    }
    Shown shown;
    bool has_targets = false;
    mesh_name_ = text_of(mesh, "name");
    for (const json& primitive : *primitives) {
        build_primitive(primitive, motion, shown);
        progress_.advance(corners_of(document_, primitive));
        has_targets = has_targets || primitive.contains("targets");
    }
    morphed_ += has_targets ? 1 : 0;
    return shown;
}

// One mesh; of a masked material two, if its mask leaves some triangles whole.
void Reader::build_primitive(const json& primitive, const VertexMotion& motion, Shown& shown)
{
    GltfPrimitive data = read_primitive(document_, accessors_, primitive);
    const uint32_t material = index_or(primitive, "material", kNoMaterial);
    const AlphaMask* mask = mask_of(material);
    const GltfAttribute* texcoords =
        mask != nullptr ? data.find(fmt::format("TEXCOORD_{}", mask->texcoord())) : nullptr;
    if (mask == nullptr || (texcoords == nullptr && mask->has_texture())) {
        keep(primitive, data, motion, material, shown);
        return;
    }
    const auto uv = [&](uint32_t vertex) {
        return texcoords != nullptr ? glm::vec2{texcoords->at(vertex)} : glm::vec2{0.0f};
    };
    const std::vector<uint32_t> corners = std::move(data.corners);
    std::vector<uint32_t> whole;
    std::vector<uint32_t> partly;
    for (size_t i = 0; i < corners.size(); i += 3) {
        const Coverage coverage =
            mask->coverage(uv(corners[i]), uv(corners[i + 1]), uv(corners[i + 2]));
        if (coverage == Coverage::none) {
            ++data.left_out.masked_away;
            continue;
        }
        std::vector<uint32_t>& out = coverage == Coverage::all ? whole : partly;
        out.insert(out.end(), corners.begin() + static_cast<std::ptrdiff_t>(i),
                   corners.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    }
    data.corners = std::move(partly);
    keep(primitive, data, motion, material, shown);
    if (!whole.empty()) {
        data.left_out = {};
        data.corners = std::move(whole);
        keep(primitive, data, motion, opaque_part_of(material), shown);
    }
}

void Reader::keep(const json& primitive, const GltfPrimitive& data, const VertexMotion& motion,
                  uint32_t material, Shown& shown)
{
    glm::dvec3 pivot{0.0};
    LoadedMesh built = build_mesh(accessors_, primitive, data, motion, pivot);
    document_.charge(built.positions.size() * 2 * sizeof(glm::vec3));
    built.name = mesh_name_;
    built.material = material;
    shown.meshes.push_back(static_cast<uint32_t>(scene_.meshes.size()));
    shown.pivots.push_back(pivot);
    scene_.meshes.push_back(std::move(built));
}

// The mask of a masked material; null for others, and where its texture cannot be read.
const AlphaMask* Reader::mask_of(uint32_t material)
{
    if (material >= scene_.materials.size() ||
        scene_.materials[material].surface != Surface::masked) {
        return nullptr;
    }
    const auto [known, is_new] = masks_.try_emplace(material);
    if (is_new) {
        try {
            known->second.emplace(document_, accessors_, document_.entry("materials", material));
        } catch (const GltfError& error) {
            scene_.notes.push_back(
                fmt::format("the alpha mask of material {} '{}' cannot be used: {}; what has it is "
                            "taken to hide nothing",
                            material, scene_.materials[material].name, error.what()));
        }
    }
    return known->second ? &*known->second : nullptr;
}

uint32_t Reader::opaque_part_of(uint32_t material)
{
    const auto [known, is_new] =
        opaque_parts_.try_emplace(material, static_cast<uint32_t>(scene_.materials.size()));
    if (is_new) {
        LoadedMaterial whole = scene_.materials[material];
        whole.surface = Surface::opaque;
        scene_.materials.push_back(std::move(whole));
    }
    return known->second;
}

const Reader::Shown& Reader::shown_mesh(const json& node, size_t mesh)
{
    const uint32_t skin = index_or(node, "skin", UINT32_MAX);
    std::string weights = node.contains("weights") ? node["weights"].dump() : std::string{};
    const auto key = std::make_tuple(mesh, skin, std::move(weights));
    const auto found = shown_.find(key);
    return found != shown_.end() ? found->second
                                 : shown_.emplace(key, build(node, mesh)).first->second;
}

void Reader::add_node(const PlacedNode& placed)
{
    const json& node = document_.entry("nodes", placed.index);
    if (node.contains("camera")) {
        if (auto camera = camera_of(document_, node, placed.world_from_node)) {
            scene_.cameras.push_back(std::move(*camera));
        } else {
            scene_.notes.push_back("holds a camera that is orthographic, or looks nowhere; it is "
                                   "not offered as a path");
        }
    }
    if (!node.contains("mesh")) {
        return;
    }
    const Shown& shown = shown_mesh(node, index_of(node, "mesh"));
    const bool skinned = node.contains("skin");
    for (const glm::dmat4& node_from_instance : instance_transforms(accessors_, node)) {
        for (size_t i = 0; i < shown.meshes.size(); ++i) {
            // By the rules of glTF the joints alone place a skinned mesh.
            glm::dmat4 world =
                skinned ? glm::dmat4{1.0} : placed.world_from_node * node_from_instance;
            if (skinned) {
                world[3] = glm::dvec4{shown.pivots[i], 1.0};
            }
            document_.charge(sizeof(LoadedInstance));
            scene_.instances.push_back({text_of(node, "name"), shown.meshes[i], world});
        }
    }
}

LoadedScene Reader::read()
{
    check_extensions();
    scene_.materials = read_materials(document_);
    scene_.up = glm::vec3{0.0f, 1.0f, 0.0f};
    scene_.format_is_metric = true;
    for (const PlacedNode& placed : placed_nodes(document_)) {
        add_node(placed);
    }
    for (LoadedMesh& mesh : scene_.meshes) {
        if (mesh.material != kNoMaterial && mesh.material >= scene_.materials.size()) {
            throw GltfError{
                fmt::format("a mesh names material {} of {}; the file is broken, export "
                            "it again",
                            mesh.material, scene_.materials.size())};
        }
    }
    note_what_is_not_shown();
    return std::move(scene_);
}

} // namespace

Result<LoadedScene> load_gltf(const std::filesystem::path& file, uint64_t memory_budget,
                              const std::function<void(double share)>& progress)
{
    const auto failed = [&](ErrorCode code, const std::string& what) {
        return Error{code, fmt::format("{}: {}", file.string(), what)};
    };
    try {
        return Reader{file, memory_budget, progress}.read();
    } catch (const GltfVersion1& error) {
        return failed(ErrorCode::unsupported, error.what());
    } catch (const GltfError& error) {
        return failed(ErrorCode::bad_data, error.what());
    } catch (const json::exception& error) {
        return failed(ErrorCode::bad_data,
                      fmt::format("is no valid glTF ({}); export it again", error.what()));
    } catch (const std::bad_alloc&) {
        return failed(ErrorCode::bad_data, "needs more memory than there is; give a smaller scene");
    }
}

bool gltf_needs_guard(const std::filesystem::path& file)
{
    const auto mapped = MappedFile::open(file);
    if (!mapped) {
        return false;
    }
    Bytes bytes = mapped->bytes();
    if (bytes.size() > 20 && bytes[0] == 'g') { // only the JSON of a binary file is text
        uint32_t json_size = 0;
        std::memcpy(&json_size, bytes.data() + 12, sizeof json_size);
        bytes = bytes.subspan(20, std::min<size_t>(json_size, bytes.size() - 20));
    }
    const auto names = [&](std::string_view text) {
        return ::memmem(bytes.data(), bytes.size(), text.data(), text.size()) != nullptr;
    };
    return names("KHR_draco_mesh_compression") || names("\"MASK\"");
}

} // namespace occlude::tools
