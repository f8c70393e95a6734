#include "tools/load/scene_texts.h"
#include "tools/temp_folder.h"

namespace occlude::tools {
namespace {

TEST(BrokenFiles, NamesAFileThatIsMissing)
{
    expect_error("/nowhere/none.glb", ErrorCode::not_found, "no such file");
}

TEST(BrokenFiles, NamesAFileThatIsEmptyOrNoScene)
{
    const TempFolder folder;
    expect_error(folder.write("empty.glb", ""), ErrorCode::bad_data, "empty");
    expect_error(folder.write("empty.obj", ""), ErrorCode::bad_data, "empty");
    expect_error(folder.write("text.txt", "hello, scene"), ErrorCode::bad_data, "cannot be read");
    expect_error(folder.write("text.glb", "hello, scene"), ErrorCode::bad_data, "cannot be read");
    expect_error(folder.write("text.gltf", "{\"a\":"), ErrorCode::bad_data, "cannot be read");
    expect_error(folder.path(""), ErrorCode::bad_data, "is not a file");
}

TEST(BrokenFiles, NamesASceneWithoutTriangles)
{
    const TempFolder folder;
    const std::string points = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                               "property float y\nproperty float z\nend_header\n0 0 0\n1 1 1\n";
    const auto model = load_scene(folder.write("points.ply", points));
    ASSERT_FALSE(model);
    EXPECT_NE(model.error().message.find("triangles"), std::string::npos) << model.error().message;
}

TEST(BrokenFiles, ACutOffFileIsAnErrorWhereverItEnds)
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

TEST(BrokenFiles, ABufferThatIsTooShortOrMissingIsAnErrorOrAtLeastNoCrash)
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

TEST(BrokenFiles, IndicesBeyondTheVerticesAreAnErrorOrAtLeastNoCrash)
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

TEST(BrokenFiles, JsonThatNestsTooDeeplyIsRefused)
{
    constexpr size_t kDepth = 300000; // one stack frame for each would overflow the stack
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
    // Less deeply nested files are read, and brackets in strings do not count.
    std::string gltf = two_instances_gltf("");
    gltf.insert(1, "\"extras\":" + std::string(200, '[') + "\"\\\"" + std::string(300, '[') + '"' +
                       std::string(200, ']') + ',');
    expect_two_instances(load_scene(folder.write("two.glb", glb_of(gltf, triangle_buffer()))));
}

TEST(BrokenFiles, NodesThatNestTooDeeplyAreRefused)
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
    for (const size_t count : {1001u, 100000u}) {
        const std::string nodes = chain_of_nodes(count);
        expect_error(gltf_file(nodes), ErrorCode::bad_data, says);
        const std::string glb = glb_of(gltf_with_nodes(nodes, ""), triangle_buffer());
        expect_error(folder.write("nodes.glb", glb), ErrorCode::bad_data, says);
    }
    expect_error(gltf_file(R"([{"children":[1]},{"mesh":0,"children":[0]}])"), ErrorCode::bad_data,
                 "in a circle");
    expect_error(folder.write("named.gltf", R"({"asset":{"version":"1.0"},"scene":"s",
                     "scenes":{"s":{"nodes":["a"]}},"nodes":{"a":{"children":["a"]}}})"),
                 ErrorCode::bad_data, "it nests too deeply, refers to itself or is damaged");
}

TEST(BrokenFiles, NodesThatAreManyByHavingSeveralParentsAreRefused)
{
    const TempFolder folder;
    folder.write("tri.bin", triangle_buffer());
    const auto gltf_file = [&](size_t levels) {
        return folder.write("nodes.gltf",
                            gltf_with_nodes(chain_of_nodes(levels + 1, 2), R"(,"uri":"tri.bin")"));
    };
    const auto model = load_scene(gltf_file(5));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->file_triangles, 32u);
    EXPECT_EQ(model->instances.size(), 1u) << "all of them stand in the same place";
    expect_error(gltf_file(20), ErrorCode::bad_data, "nodes have several parents");
}

/// A Collada file whose node is its own child: only Assimp reads that.
TEST(BrokenFiles, AFileThatCrashesAssimpIsRefusedWithASentence)
{
    const TempFolder folder;
    const std::string file = folder.write("ring.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_visual_scenes>
<visual_scene id="s"><node id="n"><instance_node url="#n"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)");
    expect_error(file, ErrorCode::bad_data, "export it again");
}

} // namespace
} // namespace occlude::tools
