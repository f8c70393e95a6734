#include "load/assimp_loader.h"

#include "load/crash_guard.h"
#include "load/unreadable_files.h"
#include "model/mesh_tools.h"
#include "model/scene_options.h"

#include <occlude/core/rng.h>

#include <assimp/DefaultIOStream.h>
#include <assimp/DefaultIOSystem.h>
#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

namespace occlude::tools {
namespace {

namespace fs = std::filesystem;

/// Coordinates beyond this are taken for damage: their squares would not fit a float.
constexpr float kLargestCoordinate = 1e15f;
constexpr uint32_t kNoMesh = 0xffffffffu;

/// A file that takes itself off the list of open ones.
class ListedFile : public Assimp::DefaultIOStream {
public:
    ListedFile(FILE* file, const std::string& name, std::vector<ListedFile*>& open)
        : DefaultIOStream(file, name)
        , open_(open)
    {
        open_.push_back(this);
    }
    ~ListedFile() override { std::erase(open_, this); }

private:
    std::vector<ListedFile*>& open_;
};

/// Assimp's files, closed at last where an importer that fails forgets to.
class ListedFiles : public Assimp::DefaultIOSystem {
public:
    ~ListedFiles() override
    {
        while (!open_.empty()) {
            delete open_.back();
        }
    }
    Assimp::IOStream* Open(const char* name, const char* mode) override
    {
        FILE* file = std::fopen(name, mode);
        return file != nullptr ? new ListedFile(file, name, open_) : nullptr;
    }

private:
    std::vector<ListedFile*> open_;
};

Error bad_file(const std::string& file, const std::string& what)
{
    return {ErrorCode::bad_data, fmt::format("{}: {}", file, what)};
}

bool usable(const glm::vec3& v)
{
    // Written so that NaN answers false.
    return std::abs(v.x) <= kLargestCoordinate && std::abs(v.y) <= kLargestCoordinate &&
           std::abs(v.z) <= kLargestCoordinate;
}

glm::vec3 to_glm(const aiVector3D& v)
{
    return {v.x, v.y, v.z};
}

glm::mat4 to_glm(const aiMatrix4x4& m)
{
    return {m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2,
            m.a3, m.b3, m.c3, m.d3, m.a4, m.b4, m.c4, m.d4};
}

std::optional<Error> check_file(const std::string& file)
{
    std::error_code failed;
    if (!fs::exists(file, failed)) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: no such file; give the path of a scene file, or a generated "
                                 "scene such as city:blocks=16,seed=1",
                                 file)};
    }
    if (!fs::is_regular_file(file, failed)) {
        return bad_file(file, "is not a file; give a scene file such as scene.glb");
    }
    if (!std::ifstream(file, std::ios::binary)) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: cannot be read; check its permissions", file)};
    }
    const uintmax_t size = fs::file_size(file, failed);
    if (failed || size == 0) {
        return bad_file(file, "is empty; export or download it again");
    }
    if (const auto problem = unreadable_by_assimp(file, size)) {
        return bad_file(file, *problem);
    }
    return std::nullopt;
}

/// Everything after this trusts the indices. (Assimp's own steps would, too, or abort: none is
/// run.)
std::optional<std::string> broken_indices(const aiScene& scene)
{
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
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

/// A muted colour, different for different hashes.
glm::vec3 pleasant_color(uint64_t hash)
{
    const float value = 0.45f + 0.35f * uniform01(mix64(hash));
    const float warm = uniform01(mix64(hash + 1));
    const float green = uniform01(mix64(hash + 2));
    const glm::vec3 tint{0.85f + 0.15f * warm, 0.82f + 0.18f * green, 1.0f - 0.3f * warm};
    return value * tint;
}

uint64_t hash_text(const char* text)
{
    uint64_t hash = 0;
    for (; *text != '\0'; ++text) {
        hash = hash64(hash, static_cast<unsigned char>(*text));
    }
    return hash;
}

glm::vec3 color_of(const aiScene& scene, const aiMesh& mesh)
{
    uint64_t identity = hash_text(mesh.mName.C_Str());
    if (mesh.mMaterialIndex < scene.mNumMaterials) {
        const aiMaterial& material = *scene.mMaterials[mesh.mMaterialIndex];
        aiColor4D color;
        const bool found = material.Get(AI_MATKEY_BASE_COLOR, color) == aiReturn_SUCCESS ||
                           material.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS;
        const glm::vec3 rgb{color.r, color.g, color.b};
        const float least = std::min({rgb.r, rgb.g, rgb.b});
        const float most = std::max({rgb.r, rgb.g, rgb.b});
        const bool is_white = least >= 0.99f;
        if (found && usable(rgb) && !is_white && least >= 0.0f && most > 0.02f) {
            return glm::min(rgb, glm::vec3{1.0f});
        }
        if (scene.mNumMaterials > 1) {
            identity = hash64(hash_text(material.GetName().C_Str()), mesh.mMaterialIndex);
        }
    }
    return pleasant_color(identity);
}

/// Below 1 for materials that are blended. glTF says so in a mode; other formats just give a
/// number, and of those 0 means that nobody thought of it: a material that is not there is not
/// exported.
float opacity_of(const aiScene& scene, const aiMesh& mesh)
{
    if (mesh.mMaterialIndex >= scene.mNumMaterials) {
        return 1.0f;
    }
    const aiMaterial& material = *scene.mMaterials[mesh.mMaterialIndex];
    float opacity = 1.0f;
    aiString mode;
    if (material.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) == aiReturn_SUCCESS) {
        aiColor4D color;
        const bool blended = std::string_view{mode.C_Str()} == "BLEND" &&
                             material.Get(AI_MATKEY_BASE_COLOR, color) == aiReturn_SUCCESS;
        opacity = blended ? color.a : 1.0f;
    } else {
        material.Get(AI_MATKEY_OPACITY, opacity);
    }
    return opacity > 0.0f && opacity < 1.0f ? opacity : 1.0f;
}

/// The triangles of one Assimp mesh; without triangles if it has none that can be drawn.
Mesh convert_mesh(const aiMesh& source)
{
    Mesh mesh;
    mesh.name = source.mName.C_Str();
    mesh.positions.reserve(source.mNumVertices);
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
        mesh.positions.push_back(to_glm(source.mVertices[i]));
    }
    std::vector<uint32_t> triangles;
    for (unsigned f = 0; f < source.mNumFaces; ++f) { // points and lines give none
        const aiFace& face = source.mFaces[f];
        triangulate(mesh.positions, {face.mIndices, face.mNumIndices}, triangles);
    }
    for (size_t i = 0; i < triangles.size(); i += 3) {
        const glm::vec3& a = mesh.positions[triangles[i]];
        const glm::vec3& b = mesh.positions[triangles[i + 1]];
        const glm::vec3& c = mesh.positions[triangles[i + 2]];
        if (usable(a) && usable(b) && usable(c) && a != b && b != c && c != a) {
            const auto corners = triangles.begin() + static_cast<std::ptrdiff_t>(i);
            mesh.indices.insert(mesh.indices.end(), corners, corners + 3);
        }
    }
    if (mesh.indices.empty()) {
        return mesh;
    }

    if (!source.HasNormals()) {
        make_normals(mesh);
        return mesh;
    }
    mesh.normals.reserve(source.mNumVertices);
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
        const glm::vec3 normal = to_glm(source.mNormals[i]);
        const float length = glm::length(normal);
        const bool has_direction = length > 0.0f && length <= kLargestCoordinate;
        mesh.normals.push_back(has_direction ? normal / length : glm::vec3{0.0f, 1.0f, 0.0f});
    }
    const bool every_corner_alone = mesh.positions.size() >= mesh.indices.size();
    if (every_corner_alone || mesh.indices.size() < triangles.size()) {
        weld(mesh); // also drops vertices that only dropped triangles used
    }
    return mesh;
}

/// Walks the node tree, one instance per mesh of a node.
void add_instances(const aiScene& scene, const std::vector<uint32_t>& mesh_of, SceneModel& model)
{
    struct Place {
        const aiNode* node;
        glm::mat4 world_from_parent;
    };
    std::vector<Place> open{{scene.mRootNode, glm::mat4{1.0f}}};
    while (!open.empty()) {
        const Place place = open.back();
        open.pop_back();
        const aiNode& node = *place.node;
        const glm::mat4 world_from_node = place.world_from_parent * to_glm(node.mTransformation);
        for (unsigned i = 0; i < node.mNumMeshes; ++i) {
            const unsigned source = node.mMeshes[i];
            if (source >= mesh_of.size() || mesh_of[source] == kNoMesh) {
                continue;
            }
            Instance instance{.name = node.mName.C_Str(),
                              .mesh = mesh_of[source],
                              .world_from_mesh = world_from_node,
                              .color = color_of(scene, *scene.mMeshes[source]),
                              .opacity = opacity_of(scene, *scene.mMeshes[source])};
            Aabb box;
            for (const MeshPart& part : model.meshes[instance.mesh].parts) {
                box = merge(box, transformed(world_from_node, part.box));
            }
            if (usable(box.min) && usable(box.max)) {
                model.instances.push_back(std::move(instance));
            }
        }
        for (unsigned i = node.mNumChildren; i-- > 0;) {
            open.push_back({node.mChildren[i], world_from_node});
        }
    }
}

/// FBX says how many centimetres a unit is.
std::optional<float> unit_in_file(const aiScene& scene)
{
    if (scene.mMetaData == nullptr) {
        return std::nullopt;
    }
    float factor = 0.0f;
    double factor_double = 0.0;
    if (!scene.mMetaData->Get("UnitScaleFactor", factor) &&
        scene.mMetaData->Get("UnitScaleFactor", factor_double)) {
        factor = static_cast<float>(factor_double);
    }
    return factor > 1e-6f && factor < 1e6f ? std::optional<float>{100.0f / factor} : std::nullopt;
}

/// Which formats are in metres by their definition, or made so by Assimp.
UnitSource unit_source(const std::string& file)
{
    std::string extension = fs::path(file).extension().string();
    for (char& c : extension) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    const bool says_metres = extension == ".glb" || extension == ".gltf" || extension == ".dae";
    return says_metres ? UnitSource::metres : UnitSource::unknown;
}

SceneModel convert(const aiScene& scene, const std::string& file, const SceneOptions& options)
{
    SceneModel model;
    model.name = fs::path(file).stem().string();
    std::vector<uint32_t> mesh_of(scene.mNumMeshes, kNoMesh);
    for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
        Mesh mesh = convert_mesh(*scene.mMeshes[i]);
        if (!mesh.indices.empty()) {
            partition_mesh(mesh, std::max(options.item_triangles, 1u));
            mesh_of[i] = static_cast<uint32_t>(model.meshes.size());
            model.meshes.push_back(std::move(mesh));
        }
    }
    add_instances(scene, mesh_of, model);
    if (const auto unit = unit_in_file(scene)) {
        model.unit = *unit;
    } else {
        model.unit = guess_unit(model, unit_source(file));
    }
    return model;
}

Result<SceneModel> load(const std::string& file, const SceneOptions& options)
{
    Assimp::Importer importer;
    importer.SetIOHandler(new ListedFiles); // the importer owns it
    const aiScene* scene = nullptr;
    {
        const CrashGuard guard(fmt::format(
            "occlude: {}: reading it crashed Assimp: it nests too deeply, refers to itself or is "
            "damaged; export it again with fewer levels, or as GLB\n",
            file));
        scene = importer.ReadFile(file, 0);
    }
    if (scene == nullptr || scene->mRootNode == nullptr) {
        const std::string reason = importer.GetErrorString();
        return bad_file(file, fmt::format("cannot be read as a scene ({}); give a whole glTF, GLB, "
                                          "OBJ, PLY, Collada, FBX or other file that Assimp reads",
                                          reason.empty() ? "it holds no nodes" : reason));
    }
    if (const auto problem = broken_indices(*scene)) {
        return bad_file(file, *problem + "; the file is broken, export it again");
    }
    SceneModel model = convert(*scene, file, options);
    if (model.instances.empty()) {
        return bad_file(file, "has no triangles to draw; points, lines and triangles without area "
                              "do not count, so export it with its surfaces");
    }
    return model;
}

} // namespace

float guess_unit(const SceneModel& model, UnitSource source)
{
    // A metre is not believed where ...
    constexpr float kLargestScene = 20000.0f; // ... a scene would be longer than this,
    constexpr float kLongShortEdge = 20.0f;   // ... or nine edges of ten were longer than this.
    constexpr float kLargeUnsaid = 1000.0f;   // Where nobody said metres, less is suspicious:
    constexpr float kLongEdge = 8.0f;         // a large scene with a long median edge.
    constexpr float kTypicalEdge = 2.0f;      // metres
    constexpr uint64_t kSamples = 100000;

    const uint64_t stride = drawn_triangles(model) / kSamples + 1;
    uint64_t triangle = 0;
    std::vector<float> edges;
    for (const Instance& instance : model.instances) {
        const Mesh& mesh = model.meshes[instance.mesh];
        const uint64_t count = mesh.indices.size() / 3;
        for (uint64_t i = (stride - triangle % stride) % stride; i < count; i += stride) {
            glm::vec3 corners[3];
            for (uint64_t k = 0; k < 3; ++k) {
                const glm::vec3& p = mesh.positions[mesh.indices[3 * i + k]];
                corners[k] = glm::vec3{instance.world_from_mesh * glm::vec4{p, 1.0f}};
            }
            edges.push_back(std::max({glm::distance(corners[0], corners[1]),
                                      glm::distance(corners[1], corners[2]),
                                      glm::distance(corners[2], corners[0])}));
        }
        triangle += count;
    }
    if (edges.empty()) {
        return 1.0f;
    }
    std::sort(edges.begin(), edges.end());
    const float short_edge = edges[edges.size() / 10];
    const float median = edges[edges.size() / 2];
    const float size = glm::length(world_bounds(model).extent());
    const bool absurd = size > kLargestScene || short_edge > kLongShortEdge;
    const bool suspicious =
        source == UnitSource::unknown && size > kLargeUnsaid && median > kLongEdge;
    return absurd || suspicious ? std::exp2(std::round(std::log2(median / kTypicalEdge))) : 1.0f;
}

Result<SceneModel> load_with_assimp(const std::string& file, const SceneOptions& options)
{
    if (const auto problem = check_file(file)) {
        return *problem;
    }
    // Assimp reports through return values, but not everything below it does.
    try {
        return load(file, options);
    } catch (const std::exception& error) {
        return bad_file(file, fmt::format("reading it failed ({}); export it again, smaller or in "
                                          "another format",
                                          error.what()));
    }
}

} // namespace occlude::tools
