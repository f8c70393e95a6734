// The reader of glTF 2.0, feature by feature, on files of a few vertices.
#include "generate/scene_source.h"
#include "load/gltf_loader.h"
#include "tools/temp_folder.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include <glm/geometric.hpp>

#include <cstring>

namespace occlude::tools {
namespace {

using nlohmann::json;

/// 8 x 8 texels, opaque in the upper half (v < 0.5) and cut away in the lower one.
constexpr const char* kHalfMask = "data:image/"
                                  "png;base64,"
                                  "iVBORw0KGgoAAAANSUhEUgAAAAgAAAAICAYAAADED76LAAAAFklEQVR42mOIWmDz"
                                  "Hx9moI8CvJgOCgCgeG1hIFTN2QAAAABJRU5ErkJggg==";

/// Collects what a glTF file consists of; one mesh, one node, until a test says otherwise.
class Builder {
public:
    Builder()
    {
        root_["asset"] = {{"version", "2.0"}};
        root_["nodes"] = json::array({{{"mesh", 0}}});
        root_["scenes"] = json::array({{{"nodes", {0}}}});
    }

    template <class T>
    size_t view(const std::vector<T>& values)
    {
        bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
        const size_t begin = bytes_.size();
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        root_["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", bytes_.size() - begin}});
        return root_["bufferViews"].size() - 1;
    }
    template <class T>
    size_t accessor(const std::vector<T>& values, int component, const char* type,
                    size_t per_element)
    {
        root_["accessors"].push_back({{"bufferView", view(values)},
                                      {"componentType", component},
                                      {"count", values.size() / per_element},
                                      {"type", type}});
        return root_["accessors"].size() - 1;
    }
    size_t positions(const std::vector<float>& values) { return accessor(values, 5126, "VEC3", 3); }
    size_t indices(const std::vector<uint16_t>& values)
    {
        return accessor(values, 5123, "SCALAR", 1);
    }
    void primitive(const json& value)
    {
        root_["meshes"] = json::array({{{"primitives", json::array({value})}}});
    }
    json& root() { return root_; }

    std::string write(const TempFolder& folder)
    {
        root_["buffers"] = json::array({{{"byteLength", bytes_.size()}, {"uri", "data.bin"}}});
        folder.write("data.bin", bytes_);
        return folder.write("scene.gltf", root_.dump());
    }

private:
    json root_;
    std::string bytes_;
};

const std::vector<float> kStripOfQuads = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0, 2, 1, 0};

TEST(Gltf, StripsAndFansAreTriangles)
{
    const TempFolder folder;
    Builder strip;
    strip.primitive({{"attributes", {{"POSITION", strip.positions(kStripOfQuads)}}}, {"mode", 5}});
    const auto model = load_scene(strip.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 4u);
    float facing = 0.0f; // all triangles of a strip wind the same way
    const Mesh& mesh = model->meshes[0];
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::vec3& a = mesh.positions[mesh.indices[i]];
        facing += glm::cross(mesh.positions[mesh.indices[i + 1]] - a,
                             mesh.positions[mesh.indices[i + 2]] - a)
                      .z;
    }
    EXPECT_NEAR(std::abs(facing), 4.0f, 1e-5f);

    Builder fan;
    fan.primitive({{"attributes",
                    {{"POSITION", fan.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 1, 0})}}},
                   {"mode", 6}});
    const auto fanned = load_scene(fan.write(folder));
    ASSERT_TRUE(fanned) << fanned.error().message;
    EXPECT_EQ(drawn_triangles(*fanned), 3u);
}

TEST(Gltf, SparseAccessorsReplaceWhatTheyList)
{
    const TempFolder folder;
    Builder builder;
    const size_t positions = builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const size_t where = builder.view(std::vector<uint16_t>{2});
    const size_t what = builder.view(std::vector<float>{0, 7, 0});
    builder.root()["accessors"][positions]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", where}, {"componentType", 5123}}},
        {"values", {{"bufferView", what}}}};
    builder.primitive({{"attributes", {{"POSITION", positions}}}});
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_NEAR(world_bounds(*model).max.y, 7.0f, 1e-4f);

    // Without a buffer view, the other values are zeros.
    builder.root()["accessors"][positions].erase("bufferView");
    builder.root()["accessors"][positions]["sparse"]["count"] = 1;
    const auto flat = load_scene(builder.write(folder));
    EXPECT_FALSE(flat) << "two corners at the origin make no triangle";
}

TEST(Gltf, SparseAccessorsThatReachTooFarAreRefused)
{
    const TempFolder folder;
    Builder builder;
    const size_t positions = builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    builder.root()["accessors"][positions]["sparse"] = {
        {"count", 1},
        {"indices",
         {{"bufferView", builder.view(std::vector<uint16_t>{3})}, {"componentType", 5123}}},
        {"values", {{"bufferView", builder.view(std::vector<float>{0, 7, 0})}}}};
    builder.primitive({{"attributes", {{"POSITION", positions}}}});
    const auto model = load_scene(builder.write(folder));
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("element 3 of 3"), std::string::npos)
        << model.error().message;
}

TEST(Gltf, MorphTargetsAreShownWithTheirDefaultWeights)
{
    const TempFolder folder;
    Builder builder;
    const size_t positions = builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const size_t moved = builder.positions({0, 0, 0, 0, 0, 0, 0, 4, 0});
    builder.primitive({{"attributes", {{"POSITION", positions}}},
                       {"targets", json::array({{{"POSITION", moved}}})}});
    const auto rest = load_scene(builder.write(folder));
    ASSERT_TRUE(rest) << rest.error().message;
    EXPECT_NEAR(world_bounds(*rest).max.y, 1.0f, 1e-4f);
    builder.root()["meshes"][0]["weights"] = {0.5};
    const auto weighted = load_scene(builder.write(folder));
    ASSERT_TRUE(weighted);
    EXPECT_NEAR(world_bounds(*weighted).max.y, 3.0f, 1e-4f);
    builder.root()["nodes"][0]["weights"] = {1.0};
    const auto by_node = load_scene(builder.write(folder));
    ASSERT_TRUE(by_node);
    EXPECT_NEAR(world_bounds(*by_node).max.y, 5.0f, 1e-4f);
}

TEST(Gltf, OnlyTheDefaultSceneIsShownAndTheOthersAreNoted)
{
    const TempFolder folder;
    Builder builder;
    builder.primitive(
        {{"attributes", {{"POSITION", builder.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}}}});
    builder.root()["nodes"] =
        json::array({{{"mesh", 0}}, {{"mesh", 0}, {"translation", {9, 0, 0}}}});
    builder.root()["scenes"] = json::array({{{"nodes", {0}}}, {{"nodes", {1}}}});
    builder.root()["scene"] = 1;
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_EQ(model->instances.size(), 1u);
    EXPECT_NEAR(world_bounds(*model).min.x, 9.0f, 1e-4f);
    bool noted = false;
    for (const std::string& note : model->load_notes) {
        noted = noted || note.find("2 scenes") != std::string::npos;
    }
    EXPECT_TRUE(noted);
}

/// Three triangles: in the opaque half of the mask, in the half that is cut away, and across.
Builder masked_triangles()
{
    Builder builder;
    const size_t positions = builder.positions(
        {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 2, 1, 0, 2, 0, 1, 2, 0, 0, 4, 1, 0, 4, 0, 1, 4});
    const size_t texcoords = builder.accessor(
        std::vector<float>{0.2f, 0.15f, 0.3f, 0.2f, 0.25f, 0.3f, 0.2f, 0.7f, 0.3f, 0.75f, 0.25f,
                           0.8f, 0.2f, 0.2f, 0.3f, 0.8f, 0.25f, 0.5f},
        5126, "VEC2", 2);
    builder.primitive(
        {{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", texcoords}}}, {"material", 0}});
    builder.root()["materials"] =
        json::array({{{"alphaMode", "MASK"},
                      {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
    builder.root()["textures"] = json::array({{{"source", 0}}});
    builder.root()["images"] = json::array({{{"uri", kHalfMask}}});
    return builder;
}

TEST(Gltf, AMaskHidesWhatItsTextureLeaves)
{
    const TempFolder folder;
    Builder builder = masked_triangles();
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->file_triangles, 3u);
    ASSERT_EQ(model->instances.size(), 2u);
    for (const Instance& instance : model->instances) {
        const bool is_whole = model->meshes[instance.mesh].parts[0].box.min.z == 0.0f;
        EXPECT_EQ(instance.translucent(), !is_whole);
        EXPECT_EQ(model->meshes[instance.mesh].parts[0].box.min.z, is_whole ? 0.0f : 4.0f);
    }
    ASSERT_EQ(model->load_losses.size(), 1u);
    EXPECT_NE(model->load_losses[0].find("alpha mask"), std::string::npos);
}

TEST(Gltf, ATextureTransformMovesTheMask)
{
    const TempFolder folder;
    Builder builder = masked_triangles();
    builder.root()["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {
        {"KHR_texture_transform", {{"offset", {0.0, 0.15}}, {"scale", {1.0, 0.2}}}}};
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 3u);
    EXPECT_EQ(model->instances.size(), 1u) << "all of them lie in the opaque half now";
    EXPECT_FALSE(model->instances[0].translucent());
}

TEST(Gltf, AMaskThatCannotBeReadHidesNothingAndIsNoted)
{
    const TempFolder folder;
    Builder builder = masked_triangles();
    builder.root()["images"] = json::array({{{"uri", "missing.png"}}});
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_EQ(model->instances.size(), 1u);
    EXPECT_TRUE(model->instances[0].translucent());
    bool noted = false;
    for (const std::string& note : model->load_notes) {
        noted = noted || note.find("missing.png") != std::string::npos;
    }
    EXPECT_TRUE(noted);
}

TEST(Gltf, DracoMeshesAreDecoded)
{
    draco::TriangleSoupMeshBuilder soup;
    soup.Start(2);
    const int position =
        soup.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const float corners[6][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 5}, {1, 0, 5}, {0, 1, 5}};
    for (uint32_t face = 0; face < 2; ++face) {
        soup.SetAttributeValuesForFace(position, draco::FaceIndex(face), corners[3 * face],
                                       corners[3 * face + 1], corners[3 * face + 2]);
    }
    const auto mesh = soup.Finalize();
    draco::EncoderBuffer encoded;
    ASSERT_TRUE(draco::Encoder{}.EncodeMeshToBuffer(*mesh, &encoded).ok());
    const TempFolder folder;
    Builder builder;
    const size_t view =
        builder.view(std::vector<char>(encoded.data(), encoded.data() + encoded.size()));
    builder.root()["accessors"] =
        json::array({{{"componentType", 5126}, {"count", 6}, {"type", "VEC3"}},
                     {{"componentType", 5125}, {"count", 6}, {"type", "SCALAR"}}});
    builder.primitive(
        {{"attributes", {{"POSITION", 0}}},
         {"indices", 1},
         {"extensions",
          {{"KHR_draco_mesh_compression",
            {{"bufferView", view},
             {"attributes", {{"POSITION", mesh->attribute(position)->unique_id()}}}}}}}});
    builder.root()["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 2u);
    EXPECT_NEAR(world_bounds(*model).max.z, 5.0f, 1e-2f);
}

TEST(Gltf, BufferViewsOfMeshoptimizerAreDecompressed)
{
    const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 6};
    const std::vector<uint32_t> indices = {0, 1, 2, 2, 1, 3};
    std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(4, 12));
    vertices.resize(
        meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), positions.data(), 4, 12));
    std::vector<unsigned char> triangles(meshopt_encodeIndexBufferBound(6, 4));
    triangles.resize(
        meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), 6));
    const TempFolder folder;
    Builder builder;
    const auto compressed = [&](const std::vector<unsigned char>& bytes, size_t count,
                                size_t stride, const char* mode) {
        const size_t view = builder.view(bytes);
        json& description = builder.root()["bufferViews"][view];
        const json extension{{"buffer", 0},
                             {"byteOffset", description["byteOffset"]},
                             {"byteLength", description["byteLength"]},
                             {"byteStride", stride},
                             {"count", count},
                             {"mode", mode}};
        // The fallback buffer has no bytes at all.
        description = {{"buffer", 1},
                       {"byteLength", count * stride},
                       {"extensions", {{"EXT_meshopt_compression", extension}}}};
        return view;
    };
    const size_t vertex_view = compressed(vertices, 4, 12, "ATTRIBUTES");
    const size_t index_view = compressed(triangles, 6, 4, "TRIANGLES");
    builder.root()["accessors"] = json::array(
        {{{"bufferView", vertex_view}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
         {{"bufferView", index_view}, {"componentType", 5125}, {"count", 6}, {"type", "SCALAR"}}});
    builder.primitive({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
    builder.root()["extensionsRequired"] = {"EXT_meshopt_compression"};
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 2u);
    EXPECT_NEAR(world_bounds(*model).max.z, 6.0f, 1e-4f);
}

TEST(Gltf, MemoryBeyondTheBudgetIsRefusedBeforeItIsTaken)
{
    const TempFolder folder;
    Builder builder;
    builder.root()["accessors"] = json::array(
        {{{"componentType", 5126}, {"count", 400000000}, {"type", "VEC3"}}}); // zeros, 4.8 GB
    builder.primitive({{"attributes", {{"POSITION", 0}}}});
    builder.view(std::vector<float>{0.0f});
    const auto model = load_scene(builder.write(folder), {.load_memory_mib = 512});
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("--load-memory"), std::string::npos)
        << model.error().message;
}

/// Many primitives share one array of vertices. Each mesh keeps only the vertices that it uses.
TEST(Gltf, MeshesKeepOnlyTheVerticesThatTheyUse)
{
    constexpr size_t kTriangles = 500;
    const TempFolder folder;
    Builder builder;
    std::vector<float> vertices;
    for (size_t i = 0; i < 3 * kTriangles; ++i) {
        vertices.insert(vertices.end(), {static_cast<float>(i / 3), i % 3 == 1 ? 1.0f : 0.0f,
                                         i % 3 == 2 ? 1.0f : 0.0f});
    }
    const size_t positions = builder.positions(vertices);
    json primitives = json::array();
    for (size_t i = 0; i < kTriangles; ++i) {
        const auto first = static_cast<uint16_t>(3 * i);
        primitives.push_back({{"attributes", {{"POSITION", positions}}},
                              {"indices", builder.indices({first, static_cast<uint16_t>(first + 1),
                                                           static_cast<uint16_t>(first + 2)})}});
    }
    builder.root()["meshes"] = json::array({{{"primitives", primitives}}});
    const auto model = load_scene(builder.write(folder));
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_EQ(model->meshes.size(), kTriangles);
    for (const Mesh& mesh : model->meshes) {
        ASSERT_EQ(mesh.positions.size(), 3u);
    }
}

} // namespace
} // namespace occlude::tools
