#include "tools/load/scene_texts.h"
#include "tools/temp_folder.h"

namespace occlude::tools {
namespace {

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

    // glTF has one alpha mode that blends.
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
    // A grid of large triangles, 4000 units long: too large for a scene in metres.
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
