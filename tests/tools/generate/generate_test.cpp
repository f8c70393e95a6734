#include "commands/cli.h"
#include "commands/commands.h"
#include "load/glb_writer.h"
#include "tools/scene_checks.h"
#include "tools/temp_folder.h"

#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

namespace occlude::tools {
namespace {

using namespace test;

using Corner = std::tuple<float, float, float>;

/// The boxes of all objects, in any order.
std::map<std::pair<Corner, Corner>, int> boxes_of(const SceneModel& model)
{
    std::map<std::pair<Corner, Corner>, int> boxes;
    for (const Instance& instance : model.instances) {
        Aabb box;
        for (const glm::vec3& p : model.meshes[instance.mesh].positions) {
            const glm::vec3 at{instance.world_from_mesh * glm::vec4{p, 1.0f}};
            box = merge(box, {at, at});
        }
        ++boxes[{{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}}];
    }
    return boxes;
}

size_t used_meshes(const SceneModel& model)
{
    std::set<uint32_t> used;
    for (const Instance& instance : model.instances) {
        used.insert(instance.mesh);
    }
    return used.size();
}

TEST(Generate, WhatIsWrittenIsReadAgain)
{
    const TempFolder folder;
    const std::string file = folder.path("scene.glb");
    for (const char* source : {"boxcity:count=300", "teapots:count=20,triangles=576",
                               "city:blocks=1,triangles=20k", "forest:triangles=20k,trees=9"}) {
        const SceneModel model = loaded(source);
        const auto bytes = to_glb(model);
        ASSERT_TRUE(bytes);
        std::ofstream(file, std::ios::binary) << *bytes;
        const SceneModel again = loaded(file);
        EXPECT_EQ(again.instances.size(), model.instances.size()) << source;
        EXPECT_EQ(again.meshes.size(), used_meshes(model)) << source;
        EXPECT_EQ(drawn_triangles(again), drawn_triangles(model)) << source;
        EXPECT_EQ(boxes_of(again), boxes_of(model)) << source;
    }
}

int run(const std::vector<const char*>& arguments, std::string& out, std::string& err)
{
    std::ostringstream out_stream;
    std::ostringstream err_stream;
    const int code =
        run_program(static_cast<int>(arguments.size()), arguments.data(), {out_stream, err_stream});
    out = out_stream.str();
    err = err_stream.str();
    return code;
}

TEST(Generate, IsACommand)
{
    const TempFolder folder;
    const std::string file = folder.path("boxes.glb");
    std::string out;
    std::string err;
    EXPECT_EQ(run({"occlude", "generate", "boxes:count=20", "--out", file.c_str()}, out, err),
              kDone)
        << err;
    EXPECT_NE(out.find("20 objects of 1 meshes, 240 triangles"), std::string::npos) << out;
    EXPECT_EQ(loaded(file).instances.size(), 20u);
}

TEST(Generate, SaysWhatIsWrong)
{
    std::string out;
    std::string err;
    EXPECT_EQ(run({"occlude", "generate", "village", "--out", "x.glb"}, out, err), kFailed);
    EXPECT_NE(err.find("'village'"), std::string::npos) << err;
    EXPECT_NE(err.find("boxcity"), std::string::npos) << err;
    EXPECT_EQ(run({"occlude", "generate", "boxes", "--out", "x.obj"}, out, err), kFailed);
    EXPECT_NE(err.find(".glb"), std::string::npos) << err;
    EXPECT_EQ(run({"occlude", "generate", "boxes:n=3", "--out", "/tmp/occlude_x.glb"}, out, err),
              kFailed);
    EXPECT_NE(err.find("count"), std::string::npos) << err;
    EXPECT_FALSE(std::filesystem::exists("/tmp/occlude_x.glb"));
    EXPECT_EQ(run({"occlude", "generate", "boxes", "--out", "/nowhere/x.glb"}, out, err), kFailed);
    EXPECT_NE(err.find("/nowhere"), std::string::npos) << err;
}

} // namespace
} // namespace occlude::tools
