#include "generate/scene_source.h"
#include "support/source_dir.h"
#include "tools/temp_folder.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

namespace occlude::tools {
namespace {

const std::string kCastle = source_dir() + "/assets/castle/castle.glb";

const std::string kQuadObj = "mtllib none.mtl\n"
                             "o quad\n"
                             "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                             "f 1 2 3 4\n";

/// Two nodes, one of them turned and moved, that share a mesh of one triangle.
std::string two_instances_gltf(const std::string& buffer_uri)
{
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"name":"a","mesh":0},{"name":"b","mesh":0,"translation":[10,0,0],"scale":[2,2,2]}],
"meshes":[{"name":"tri","primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1]}}],
"buffers":[{"byteLength":42)" +
           buffer_uri + R"(}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})";
}

std::string triangle_buffer()
{
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint16_t indices[3] = {0, 1, 2};
    std::string bytes(42, '\0');
    std::memcpy(bytes.data(), positions, 36);
    std::memcpy(bytes.data() + 36, indices, 6);
    return bytes;
}

std::string little_endian(size_t value)
{
    std::string bytes;
    for (int i = 0; i < 4; ++i) {
        bytes.push_back(static_cast<char>((value >> (8 * i)) & 0xff));
    }
    return bytes;
}

std::string glb_of(std::string json, std::string binary)
{
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    return "glTF" + little_endian(2) + little_endian(28 + json.size() + binary.size()) +
           little_endian(json.size()) + "JSON" + json + little_endian(binary.size()) +
           std::string("BIN\0", 4) + binary;
}

std::string two_instances_glb()
{
    return glb_of(two_instances_gltf(""), triangle_buffer());
}

std::string repeated(const std::string& text, size_t times)
{
    std::string all;
    for (size_t i = 0; i < times; ++i) {
        all += text;
    }
    return all;
}

/// The scene of two_instances_gltf(), with other nodes of which the first is its root.
std::string gltf_with_nodes(const std::string& nodes, const std::string& buffer_uri)
{
    std::string gltf = two_instances_gltf(buffer_uri);
    const size_t begin = gltf.find("\"nodes\":[{");
    gltf.replace(begin, gltf.find("\"meshes\"") - begin, "\"nodes\":" + nodes + ",\n");
    return gltf.replace(gltf.find("[0,1]"), 5, "[0]");
}

/// Nodes of which each but the last has the next as a child, `times` times.
std::string chain_of_nodes(size_t count, size_t times = 1)
{
    std::string nodes = "[";
    for (size_t next = 1; next < count; ++next) {
        const std::string child = std::to_string(next);
        nodes += "{\"children\":[" + child + repeated("," + child, times - 1) + "]},";
    }
    return nodes + "{\"mesh\":0}]";
}

std::string contents(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void expect_two_instances(const Result<SceneModel>& model)
{
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_EQ(model->meshes.size(), 1u);
    ASSERT_EQ(model->instances.size(), 2u);
    EXPECT_EQ(model->instances[0].mesh, model->instances[1].mesh);
    EXPECT_EQ(model->instances[0].name, "a");
    EXPECT_EQ(drawn_triangles(*model), 2u);
    const Aabb bounds = world_bounds(*model);
    EXPECT_NEAR(bounds.min.x, 0.0f, 1e-4f);
    EXPECT_NEAR(bounds.max.x, 12.0f, 1e-4f);
    EXPECT_NEAR(bounds.max.y, 2.0f, 1e-4f);
    EXPECT_NEAR(model->instances[0].color.g, 0.25f, 1e-3f);
    EXPECT_EQ(model->unit, 1.0f);
}

/// What renderers rely on.
void expect_sound(const SceneModel& model)
{
    ASSERT_FALSE(model.instances.empty());
    for (const Instance& instance : model.instances) {
        ASSERT_LT(instance.mesh, model.meshes.size());
    }
    for (const Mesh& mesh : model.meshes) {
        ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
        ASSERT_FALSE(mesh.parts.empty());
        uint32_t next = 0;
        for (const MeshPart& part : mesh.parts) {
            ASSERT_EQ(part.first_index, next);
            next += part.index_count;
            ASSERT_TRUE(part.box.is_bounded());
        }
        ASSERT_EQ(next, mesh.indices.size());
        for (uint32_t index : mesh.indices) {
            ASSERT_LT(index, mesh.positions.size());
            ASSERT_NEAR(glm::length(mesh.normals[index]), 1.0f, 1e-3f);
        }
    }
}

TEST(Loader, ReadsObjAndCutsPolygonsIntoTriangles)
{
    const TempFolder folder;
    const auto model = load_scene(folder.write("quad.obj", kQuadObj));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 2u);
    expect_sound(*model);
    EXPECT_EQ(model->name, "quad");
    EXPECT_EQ(model->meshes[0].positions.size(), 4u) << "equal vertices should have been joined";
    EXPECT_NEAR(std::abs(model->meshes[0].normals[0].z), 1.0f, 1e-5f);
}

TEST(Loader, ReadsPly)
{
    const TempFolder folder;
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 1\n"
                            "property list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n4 0 0\n0 0 4\n3 0 1 2\n";
    const auto model = load_scene(folder.write("triangle.ply", ply));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 1u);
    expect_sound(*model);
    EXPECT_NEAR(world_bounds(*model).max.z, 4.0f, 1e-4f);
}

TEST(Loader, KeepsInstancesOfGltfAsOneMesh)
{
    const TempFolder folder;
    folder.write("tri.bin", triangle_buffer());
    expect_two_instances(
        load_scene(folder.write("two.gltf", two_instances_gltf(R"(,"uri":"tri.bin")"))));
}

TEST(Loader, TakesOpacityFromMaterials)
{
    const TempFolder folder;
    folder.write("none.mtl", "newmtl glass\nKd 0.2 0.4 0.8\nd 0.4\n");
    std::string obj = kQuadObj;
    obj.insert(obj.find("f 1"), "usemtl glass\n");
    const auto quad = load_scene(folder.write("quad.obj", obj));
    ASSERT_TRUE(quad) << quad.error().message;
    EXPECT_FLOAT_EQ(quad->instances[0].opacity, 0.4f);
    EXPECT_TRUE(
        has_flag(make_cull_scene(*quad).scene.item_flags(ItemId{0u}), ItemFlags::translucent));

    // glTF blends only in one of its modes.
    folder.write("tri.bin", triangle_buffer());
    std::string gltf = two_instances_gltf(R"(,"uri":"tri.bin")");
    gltf.replace(gltf.find("0.125,1]"), 8, "0.125,0.3]");
    const auto solid = load_scene(folder.write("solid.gltf", gltf));
    ASSERT_TRUE(solid) << solid.error().message;
    EXPECT_EQ(solid->instances[0].opacity, 1.0f);
    gltf.replace(gltf.find("\"materials\":[{"), 14, "\"materials\":[{\"alphaMode\":\"BLEND\",");
    const auto glass = load_scene(folder.write("glass.gltf", gltf));
    ASSERT_TRUE(glass) << glass.error().message;
    EXPECT_FLOAT_EQ(glass->instances[0].opacity, 0.3f);
}

TEST(Loader, KeepsInstancesOfGlbAsOneMesh)
{
    const TempFolder folder;
    expect_two_instances(load_scene(folder.write("two.glb", two_instances_glb())));
}

TEST(Loader, ReadsTheBundledCastleWithAllItsInstances)
{
    const auto model = load_scene(kCastle, {.item_triangles = 512});
    ASSERT_TRUE(model) << model.error().message;
    expect_sound(*model);
    EXPECT_EQ(model->instances.size(), 2114u);
    EXPECT_EQ(model->meshes.size(), 437u);
    EXPECT_EQ(drawn_triangles(*model), 1070891u);
    size_t split = 0;
    for (const Mesh& mesh : model->meshes) {
        split += mesh.parts.size() > 1;
        for (const MeshPart& part : mesh.parts) {
            ASSERT_LE(part.index_count, 3u * 512u);
        }
    }
    EXPECT_GT(split, 5u);

    const CullScene cull = make_cull_scene(*model);
    EXPECT_EQ(cull.objects.size(), model->instances.size());
    EXPECT_EQ(cull.scene.triangle_count(), drawn_triangles(*model));
    ASSERT_EQ(cull.scene.item_bounds().size(), cull.items.size());
    for (uint32_t i = 0; i < cull.items.size(); ++i) {
        const Instance& instance = model->instances[cull.items[i].instance];
        const MeshPart& part = model->meshes[instance.mesh].parts[cull.items[i].part];
        ASSERT_EQ(cull.scene.item_bounds()[i].triangles, part.index_count / 3);
        ASSERT_EQ(cull.scene.object_of(ItemId{i}), cull.objects[cull.items[i].instance]);
    }
}

TEST(Loader, LeavesOutTrianglesThatCannotBeDrawn)
{
    const TempFolder folder;
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 4\n"
                            "property list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n4 0 0\n0 0 4\nnan 0 0\n1e30 0 0\n"
                            "3 0 1 2\n3 0 1 3\n3 0 0 1\n3 0 4 1\n";
    const auto model = load_scene(folder.write("bad.ply", ply));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 1u);
    expect_sound(*model);
    EXPECT_TRUE(world_bounds(*model).is_bounded());
}

TEST(Loader, MakesSharpNormalsAtSharpEdgesAndSmoothOnesElsewhere)
{
    // Three quads in a row: the first two nearly in one plane, the third upright.
    const std::string obj = "v 0 0 0\nv 0 0 1\nv 1 0.05 0\nv 1 0.05 1\nv 2 0 0\nv 2 0 1\n"
                            "v 2 5 0\nv 2 5 1\n"
                            "f 1 2 4 3\nf 3 4 6 5\nf 5 6 8 7\n";
    const TempFolder folder;
    const auto model = load_scene(folder.write("folded.obj", obj));
    ASSERT_TRUE(model) << model.error().message;
    const Mesh& mesh = model->meshes[0];
    size_t at_ridge = 0;
    size_t at_corner = 0;
    for (const glm::vec3& p : mesh.positions) {
        at_ridge += p.x == 1.0f;
        at_corner += p.x == 2.0f && p.y == 0.0f;
    }
    EXPECT_EQ(at_ridge, 2u) << "one smooth vertex per corner of the ridge";
    EXPECT_EQ(at_corner, 4u) << "two vertices per corner of the sharp edge";
}

TEST(Loader, TakesLevelsInGameUnitsForWhatTheyAre)
{
    // A grid of large triangles, 4000 units long: no scene in metres looks like that.
    std::string obj;
    for (int i = 0; i < 40; ++i) {
        for (int j = 0; j < 2; ++j) {
            obj += "v " + std::to_string(100 * i) + " 0 " + std::to_string(64 * j) + "\n";
        }
    }
    for (int i = 0; i < 39; ++i) {
        const int a = 2 * i + 1;
        obj += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " +
               std::to_string(a + 3) + " " + std::to_string(a + 2) + "\n";
    }
    const TempFolder folder;
    const auto level = load_scene(folder.write("level.obj", obj));
    ASSERT_TRUE(level) << level.error().message;
    EXPECT_NEAR(level->unit, 39.37f, 0.01f) << "inches, as Quake's levels nearly are";
    const auto small = load_scene(folder.write("quad.obj", kQuadObj));
    ASSERT_TRUE(small);
    EXPECT_EQ(small->unit, 1.0f);
}

void expect_error(const std::string& file, ErrorCode code, const std::string& part)
{
    const auto model = load_scene(file);
    ASSERT_FALSE(model) << file;
    EXPECT_EQ(model.error().code, code) << model.error().message;
    EXPECT_NE(model.error().message.find(file), std::string::npos) << model.error().message;
    EXPECT_NE(model.error().message.find(part), std::string::npos) << model.error().message;
}

TEST(Loader, KeepsHollowCornersOfPolygonsHollow)
{
    // An L of 3 square metres, and the square metre that it leaves out is not covered.
    const std::string obj = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
    const TempFolder folder;
    for (const char* face : {"f 1 2 3 4 5 6\n", "f 4 5 6 1 2 3\n", "f 6 5 4 3 2 1\n"}) {
        const auto model = load_scene(folder.write("l.obj", obj + face));
        ASSERT_TRUE(model) << model.error().message;
        EXPECT_EQ(drawn_triangles(*model), 4u);
        const Mesh& mesh = model->meshes[0];
        float area = 0.0f;
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const glm::vec3& a = mesh.positions[mesh.indices[i]];
            const glm::vec3& b = mesh.positions[mesh.indices[i + 1]];
            const glm::vec3& c = mesh.positions[mesh.indices[i + 2]];
            area += 0.5f * glm::length(glm::cross(b - a, c - a));
            const glm::vec3 middle = (a + b + c) / 3.0f;
            EXPECT_FALSE(middle.x > 1.0f && middle.y > 1.0f);
        }
        EXPECT_NEAR(area, 3.0f, 1e-4f);
    }
}

TEST(Loader, NamesAFileThatIsMissing)
{
    expect_error("/nowhere/none.glb", ErrorCode::not_found, "no such file");
}

TEST(Loader, NamesAFileThatIsEmptyOrNoScene)
{
    const TempFolder folder;
    expect_error(folder.write("empty.glb", ""), ErrorCode::bad_data, "empty");
    expect_error(folder.write("empty.obj", ""), ErrorCode::bad_data, "empty");
    expect_error(folder.write("text.txt", "hello, scene"), ErrorCode::bad_data, "cannot be read");
    expect_error(folder.write("text.glb", "hello, scene"), ErrorCode::bad_data, "cannot be read");
    expect_error(folder.write("text.gltf", "{\"a\":"), ErrorCode::bad_data, "cannot be read");
    expect_error(folder.path(""), ErrorCode::bad_data, "is not a file");
}

TEST(Loader, NamesASceneWithoutTriangles)
{
    const TempFolder folder;
    const std::string points = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                               "property float y\nproperty float z\nend_header\n0 0 0\n1 1 1\n";
    const auto model = load_scene(folder.write("points.ply", points));
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("triangles"), std::string::npos) << model.error().message;
}

TEST(Loader, ACutOffFileIsAnErrorWhereverItEnds)
{
    const TempFolder folder;
    const std::string whole = two_instances_glb();
    for (size_t size = 1; size < whole.size(); size += 7) {
        const auto model = load_scene(folder.write("cut.glb", whole.substr(0, size)));
        EXPECT_FALSE(model) << "cut to " << size << " bytes";
    }
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 2\n"
                            "property list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n";
    for (size_t size = 1; size < ply.size(); size += 3) {
        const auto model = load_scene(folder.write("cut.ply", ply.substr(0, size)));
        if (model) {
            expect_sound(*model);
        }
        EXPECT_FALSE(size < ply.find("0 0 0") && model) << "cut to " << size << " bytes";
    }
    const std::string castle = contents(kCastle);
    ASSERT_GT(castle.size(), 1000000u);
    expect_error(folder.write("castle.glb", castle.substr(0, castle.size() / 2)),
                 ErrorCode::bad_data, "cut off");
}

TEST(Loader, ABufferThatIsTooShortOrMissingIsAnErrorOrAtLeastNoCrash)
{
    const TempFolder folder;
    const std::string gltf = two_instances_gltf(R"(,"uri":"tri.bin")");
    const std::string file = folder.write("two.gltf", gltf);
    EXPECT_FALSE(load_scene(file)) << "without its buffer";
    folder.write("tri.bin", triangle_buffer().substr(0, 20));
    const auto model = load_scene(file);
    if (model) {
        expect_sound(*model);
    }
}

TEST(Loader, IndicesBeyondTheVerticesAreAnErrorOrAtLeastNoCrash)
{
    const TempFolder folder;
    std::string buffer = triangle_buffer();
    buffer[40] = 99;
    folder.write("tri.bin", buffer);
    const auto gltf =
        load_scene(folder.write("two.gltf", two_instances_gltf(R"(,"uri":"tri.bin")")));
    EXPECT_FALSE(gltf);
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 1\n"
                            "property list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n4 0 0\n0 0 4\n4 0 1 2 77\n";
    EXPECT_FALSE(load_scene(folder.write("bad.ply", ply)));
    EXPECT_FALSE(load_scene(folder.write("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9 12\n")));
}

TEST(Loader, JsonThatNestsTooDeeplyIsRefused)
{
    constexpr size_t kDepth = 300000; // a stack frame each would be more than there is
    const TempFolder folder;
    const std::string list = repeated("[", kDepth) + std::string(kDepth, ']');
    const std::string object = repeated("{\"a\":", kDepth) + "1" + std::string(kDepth, '}');
    for (const std::string& deep : {list, object}) {
        std::string gltf = two_instances_gltf("");
        gltf.insert(1, "\"extras\":" + deep + ',');
        const std::string says = "its JSON is nested more than 256 deep";
        expect_error(folder.write("deep.gltf", gltf), ErrorCode::bad_data, says);
        expect_error(folder.write("deep", "\xEF\xBB\xBF" + gltf), ErrorCode::bad_data, says);
        expect_error(folder.write("deep.glb", glb_of(gltf, triangle_buffer())), ErrorCode::bad_data,
                     says);
        expect_error(folder.write("only.gltf", deep), ErrorCode::bad_data, says);
    }
    // What nests less is read, and brackets in strings are none.
    std::string gltf = two_instances_gltf("");
    gltf.insert(1, "\"extras\":" + std::string(200, '[') + "\"\\\"" + std::string(300, '[') + '"' +
                       std::string(200, ']') + ',');
    expect_two_instances(load_scene(folder.write("two.glb", glb_of(gltf, triangle_buffer()))));
}

TEST(Loader, NodesThatNestTooDeeplyAreRefused)
{
    const TempFolder folder;
    const auto gltf_file = [&](const std::string& nodes) {
        return folder.write("nodes.gltf", gltf_with_nodes(nodes, R"(,"uri":"tri.bin")"));
    };
    folder.write("tri.bin", triangle_buffer());
    const auto model = load_scene(gltf_file(chain_of_nodes(1000)));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(drawn_triangles(*model), 1u);
    const std::string says = "node 1000 lies more than 1000 nodes deep";
    for (const size_t count : {1001, 100000}) {
        const std::string nodes = chain_of_nodes(count);
        expect_error(gltf_file(nodes), ErrorCode::bad_data, says);
        const std::string glb = glb_of(gltf_with_nodes(nodes, ""), triangle_buffer());
        expect_error(folder.write("nodes.glb", glb), ErrorCode::bad_data, says);
    }
    expect_error(gltf_file(R"([{"children":[1]},{"mesh":0,"children":[0]}])"), ErrorCode::bad_data,
                 "or in itself");
    expect_error(folder.write("named.gltf", R"({"asset":{"version":"1.0"},"scene":"s",
                     "scenes":{"s":{"nodes":["a"]}},"nodes":{"a":{"children":["a"]}}})"),
                 ErrorCode::bad_data, "it nests too deeply, refers to itself or is damaged");
}

TEST(Loader, NodesThatAreManyByHavingSeveralParentsAreRefused)
{
    const TempFolder folder;
    folder.write("tri.bin", triangle_buffer());
    const auto gltf_file = [&](size_t levels) {
        return folder.write("nodes.gltf",
                            gltf_with_nodes(chain_of_nodes(levels + 1, 2), R"(,"uri":"tri.bin")"));
    };
    const auto model = load_scene(gltf_file(5));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->instances.size(), 32u);
    expect_error(gltf_file(20), ErrorCode::bad_data, "nodes have several parents");
}

/// A Collada file whose node is its own child: nothing but Assimp looks at that.
TEST(Loader, AFileThatCrashesAssimpIsRefusedWithASentence)
{
    const TempFolder folder;
    const std::string file = folder.write("ring.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_visual_scenes>
<visual_scene id="s"><node id="n"><instance_node url="#n"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)");
    expect_error(file, ErrorCode::bad_data, "export it again");
}

TEST(Loader, IsTheSameEveryTime)
{
    const auto first = load_scene(kCastle);
    const auto second = load_scene(kCastle);
    ASSERT_TRUE(first && second);
    for (size_t i = 0; i < first->instances.size(); ++i) {
        ASSERT_EQ(first->instances[i].world_from_mesh, second->instances[i].world_from_mesh);
        ASSERT_EQ(first->instances[i].color, second->instances[i].color);
    }
    for (size_t i = 0; i < first->meshes.size(); ++i) {
        ASSERT_EQ(first->meshes[i].indices, second->meshes[i].indices);
        ASSERT_EQ(first->meshes[i].positions, second->meshes[i].positions);
    }
}

} // namespace
} // namespace occlude::tools
