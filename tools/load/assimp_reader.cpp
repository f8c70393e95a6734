#include "load/assimp_reader.h"

#include "load/assimp_files.h"
#include "load/scene_cache.h"
#include "model/mesh_tools.h"

#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/ProgressHandler.hpp>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <fmt/format.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string_view>

namespace occlude::tools {
namespace {

Error bad_file(const std::filesystem::path& file, const std::string& what)
{
    return {ErrorCode::bad_data, fmt::format("{}: {}", file.string(), what)};
}

Error no_reader(const std::filesystem::path& file)
{
    return bad_file(file,
                    fmt::format("cannot be read as a scene: Assimp, as it was built here, has "
                                "no reader for files that end in '{}'; export it as GLB",
                                file.extension().string()));
}

glm::vec3 to_glm(const aiVector3D& v)
{
    return {v.x, v.y, v.z};
}

glm::dmat4 to_glm(const aiMatrix4x4& m)
{
    return glm::dmat4{glm::mat4{m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2, m.a3, m.b3, m.c3,
                                m.d3, m.a4, m.b4, m.c4, m.d4}};
}

/// Everything after this trusts the scene. (Assimp's own checks would abort over some.)
std::optional<std::string> broken_part(const aiScene& scene)
{
    if ((scene.mNumMeshes > 0 && scene.mMeshes == nullptr) ||
        (scene.mNumMaterials > 0 && scene.mMaterials == nullptr)) {
        return "its list of meshes or materials is missing";
    }
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        if (scene.mMeshes[m] == nullptr) {
            return fmt::format("mesh {} is missing", m);
        }
        const aiMesh& mesh = *scene.mMeshes[m];
        if (mesh.mNumVertices > 0 && mesh.mVertices == nullptr) {
            return fmt::format("mesh {} '{}' has no positions", m, mesh.mName.C_Str());
        }
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            for (unsigned i = 0; i < face.mNumIndices; ++i) {
                if (face.mIndices[i] >= mesh.mNumVertices) {
                    return fmt::format("face {} of mesh {} '{}' names vertex {} of {}", f, m,
                                       mesh.mName.C_Str(), face.mIndices[i], mesh.mNumVertices);
                }
            }
        }
    }
    return std::nullopt;
}

LoadedMaterial convert_material(const aiMaterial& source)
{
    LoadedMaterial material;
    aiString name;
    material.name = source.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS ? name.C_Str() : "";
    aiColor4D color;
    if (source.Get(AI_MATKEY_BASE_COLOR, color) == aiReturn_SUCCESS ||
        source.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS) {
        material.color = glm::vec3{color.r, color.g, color.b};
    }
    aiString mode;
    float opacity = 1.0f;
    if (source.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) == aiReturn_SUCCESS) { // glTF of version 1
        const bool blended = std::string_view{mode.C_Str()} == "BLEND";
        opacity = blended && material.color ? color.a : 1.0f;
        material.surface = blended ? Surface::blended : Surface::opaque;
    } else {
        source.Get(AI_MATKEY_OPACITY, opacity);
        // Exporters write 0 where nobody thought of it: what is not there is not exported.
        material.surface = opacity > 0.0f && opacity < 1.0f ? Surface::blended : Surface::opaque;
    }
    material.opacity = material.surface == Surface::blended ? opacity : 1.0f;
    if (material.surface == Surface::opaque && source.GetTextureCount(aiTextureType_OPACITY) > 0) {
        material.surface = Surface::masked;
    }
    return material;
}

LoadedMesh convert_mesh(const aiMesh& source)
{
    LoadedMesh mesh;
    mesh.name = source.mName.C_Str();
    mesh.material = source.mMaterialIndex;
    mesh.positions.reserve(source.mNumVertices);
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
        mesh.positions.push_back(to_glm(source.mVertices[i]));
    }
    for (unsigned i = 0; source.HasNormals() && i < source.mNumVertices; ++i) {
        mesh.normals.push_back(to_glm(source.mNormals[i]));
    }
    for (unsigned f = 0; f < source.mNumFaces; ++f) {
        const aiFace& face = source.mFaces[f];
        mesh.left_out.points += face.mNumIndices == 1 ? 1 : 0;
        mesh.left_out.lines += face.mNumIndices == 2 ? 1 : 0;
        triangulate(mesh.positions, {face.mIndices, face.mNumIndices}, mesh.indices);
    }
    if (source.mNumFaces == 0) { // a cloud
        mesh.left_out.points += source.mNumVertices;
    }
    return mesh;
}

/// Walks the node tree, one instance per mesh of a node.
void add_instances(const aiScene& scene, const glm::dvec3& offset, LoadedScene& out)
{
    struct Place {
        const aiNode* node;
        glm::dmat4 world_from_parent;
    };
    std::vector<Place> open{{scene.mRootNode, glm::dmat4{1.0}}};
    while (!open.empty()) {
        const Place place = open.back();
        open.pop_back();
        const aiNode& node = *place.node;
        const glm::dmat4 world = place.world_from_parent * to_glm(node.mTransformation);
        for (unsigned i = 0; i < node.mNumMeshes; ++i) {
            if (node.mMeshes[i] < out.meshes.size()) {
                out.instances.push_back(
                    {node.mName.C_Str(), node.mMeshes[i], glm::translate(world, offset)});
            }
        }
        for (unsigned i = node.mNumChildren; i-- > 0;) {
            if (node.mChildren[i] != nullptr) {
                open.push_back({node.mChildren[i], world});
            }
        }
    }
}

/// Some of Assimp's readers hang a mesh from no node: it stands where the file has it.
void place_forgotten_meshes(const glm::dvec3& offset, LoadedScene& out)
{
    std::vector<bool> placed(out.meshes.size(), false);
    for (const LoadedInstance& instance : out.instances) {
        placed[instance.mesh] = true;
    }
    for (uint32_t mesh = 0; mesh < placed.size(); ++mesh) {
        if (!placed[mesh]) {
            out.instances.push_back(
                {out.meshes[mesh].name, mesh, glm::translate(glm::dmat4{1.0}, offset)});
        }
    }
}

class AssimpProgress : public Assimp::ProgressHandler {
public:
    explicit AssimpProgress(std::function<void(double)> tell)
        : tell_(std::move(tell))
    {
    }
    bool Update(float /*share*/) override { return true; } // of post-processing, which is not done
    void UpdateFileRead(int step, int steps) override
    {
        if (tell_ && steps > 0) {
            tell_(static_cast<double>(step) / steps);
        }
    }

private:
    std::function<void(double)> tell_;
};

bool holds_nothing(const LoadedScene& scene)
{
    return std::all_of(scene.meshes.begin(), scene.meshes.end(), [](const LoadedMesh& mesh) {
        return mesh.indices.empty() && mesh.left_out.all() == 0;
    });
}

/// FBX says how many centimetres a unit is, and which axis is up.
void read_metadata(const aiMetadata* data, LoadedScene& out)
{
    if (data == nullptr) {
        return;
    }
    float factor = 0.0f;
    double factor_double = 0.0;
    if (!data->Get("UnitScaleFactor", factor) && data->Get("UnitScaleFactor", factor_double)) {
        factor = static_cast<float>(factor_double);
    }
    if (factor > 1e-6f && factor < 1e6f) {
        out.units_per_metre = 100.0f / factor;
    }
    int32_t axis = 0;
    int32_t sign = 1;
    if (data->Get("UpAxis", axis) && axis >= 0 && axis < 3) {
        data->Get("UpAxisSign", sign);
        glm::vec3 up{0.0f};
        up[axis] = sign < 0 ? -1.0f : 1.0f;
        out.up = up;
    }
}

std::string extension_of_file(const std::filesystem::path& file)
{
    std::string extension = file.extension().string();
    for (char& c : extension) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return extension;
}

/// What formats define, or Assimp makes of them.
void apply_format_rules(const std::string& extension, LoadedScene& out)
{
    constexpr std::array kMetric = {".dae", ".gltf", ".glb", ".x3d", ".wrl", ".ifc"};
    constexpr std::array kUpIsY = {".dae", ".gltf", ".glb", ".x3d", ".wrl",
                                   ".ifc", ".3ds",  ".ase", ".lwo", ".b3d"};
    out.format_is_metric = std::find(kMetric.begin(), kMetric.end(), extension) != kMetric.end();
    if (!out.up && std::find(kUpIsY.begin(), kUpIsY.end(), extension) != kUpIsY.end()) {
        out.up = glm::vec3{0.0f, 1.0f, 0.0f};
    }
}

/// Says how much of far coordinates single precision has left, unless they are few: a marker.
void note_precision(LoadedScene& out)
{
    constexpr float kNoticed = 4096.0f; // times the extent
    constexpr size_t kFewShare = 20;    // one vertex in this many
    struct Placed {
        float away;
        size_t vertices;
    };
    std::vector<Placed> placed;
    float extent = 0.0f;
    size_t vertices = 0;
    for (const LoadedMesh& mesh : out.meshes) {
        glm::vec3 low{1e30f};
        glm::vec3 high{-1e30f};
        for (const glm::vec3& p : mesh.positions) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        if (!mesh.positions.empty() && low.x <= high.x) {
            const glm::vec3 middle = glm::abs(0.5f * (low + high));
            const glm::vec3 size = high - low;
            placed.push_back({std::max({middle.x, middle.y, middle.z}), mesh.positions.size()});
            vertices += mesh.positions.size();
            extent = std::max({extent, size.x, size.y, size.z});
        }
    }
    float farthest = 0.0f;
    size_t far = 0;
    for (const Placed& mesh : placed) {
        if (mesh.away > kNoticed * extent) {
            farthest = std::max(farthest, mesh.away);
            far += mesh.vertices;
        }
    }
    if (extent > 0.0f && far * kFewShare > vertices) {
        out.notes.push_back(fmt::format(
            "lies {:.3g} units from its origin, where the single precision in which Assimp reads "
            "coordinates tells apart only {:.2g} units; export it nearer to its origin, or as OBJ "
            "or glTF",
            farthest, farthest * 0x1p-23f));
    }
}

} // namespace

Result<LoadedScene> read_with_assimp(const std::filesystem::path& file,
                                     const std::function<void(double share)>& progress)
{
    Assimp::Importer importer;
    importer.SetProgressHandler(new AssimpProgress(progress)); // the importer owns it
    auto* files = new AssimpFiles(file.string());
    importer.SetIOHandler(files); // the importer owns it
    const aiScene* scene = importer.ReadFile(file.string(), 0);
    if (scene == nullptr || scene->mRootNode == nullptr) {
        std::string reason = importer.GetErrorString();
        if (reason.find("bad_alloc") != std::string::npos) {
            throw std::bad_alloc{};
        }
        return importer.IsExtensionSupported(file.extension().string())
                   ? bad_file(file, fmt::format("cannot be read as a scene by Assimp ({}); export "
                                                "it again, best as GLB",
                                                reason.empty() ? "it holds no nodes" : reason))
                   : no_reader(file);
    }
    if (const auto problem = broken_part(*scene)) {
        return bad_file(file, *problem + "; the file is broken, export it again");
    }
    LoadedScene out;
    for (unsigned i = 0; i < scene->mNumMaterials; ++i) {
        out.materials.push_back(scene->mMaterials[i] != nullptr
                                    ? convert_material(*scene->mMaterials[i])
                                    : LoadedMaterial{});
    }
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        out.meshes.push_back(convert_mesh(*scene->mMeshes[i]));
        uint32_t& material = out.meshes.back().material;
        material = material < out.materials.size() ? material : kNoMaterial;
    }
    if (holds_nothing(out)) {
        // Some reader may have taken a file that is not of its kind.
        return importer.IsExtensionSupported(file.extension().string())
                   ? bad_file(file, "has no triangles to draw, as far as Assimp can read it; if "
                                    "there are some, export it as GLB")
                   : no_reader(file);
    }
    out.sources.push_back({file.string(), content_hash(file)});
    for (const std::string& other : files->opened()) {
        const auto is_it = [&](const SourceFile& source) { return source.path == other; };
        if (std::none_of(out.sources.begin(), out.sources.end(), is_it)) {
            out.sources.push_back({other, content_hash(other)});
        }
    }
    add_instances(*scene, files->offset(), out);
    place_forgotten_meshes(files->offset(), out);
    read_metadata(scene->mMetaData, out);
    apply_format_rules(extension_of_file(file), out);
    note_precision(out);
    if (scene->mNumAnimations > 0) {
        out.notes.emplace_back("holds animations, which are not played");
    }
    return out;
}

} // namespace occlude::tools
