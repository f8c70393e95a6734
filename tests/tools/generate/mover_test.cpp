#include "commands/cli.h"
#include "commands/commands.h"
#include "measure/motion_player.h"
#include "measure/moving_tree.h"
#include "render/cpu_renderer.h"
#include "support/loose_boxes.h"
#include "tools/scene_checks.h"
#include "tools/temp_folder.h"
#include "walk/paths.h"

#include <glm/gtc/matrix_transform.hpp>

#include <sstream>

namespace occlude::tools {
namespace {

using namespace test;

constexpr const char* kFrames = R"("version":1,"frames":[{"eye":[0,0,90],"target":[0,0,0]},
    {"eye":[0,0,90],"target":[0,0,0]},{"eye":[0,0,90],"target":[0,0,0]},
    {"eye":[0,0,90],"target":[0,0,0]},{"eye":[0,0,90],"target":[0,0,0]}])";

std::string with_movers(const std::string& movers)
{
    return std::string{"{"} + kFrames + ",\"movers\":" + movers + "}";
}

glm::mat4 placed(const SceneModel& model, size_t instance, size_t frame)
{
    return moved(model.motion.instances.at(instance), model.motion.box,
                 model.instances[instance].world_from_mesh, frame);
}

TEST(Movers, GoFromKeyToKey)
{
    const TempFolder folder;
    const std::string file = folder.write(
        "path.json", with_movers(R"([{"object":"box 3","keyframes":[{"frame":2,"position":[1,2,3]},
            {"frame":4,"position":[3,2,1],"rotation":{"axis":[0,2,0],"degrees":90}},
            {"frame":6,"position":[3,9,1]}]},
            {"object":1,"visible":{"from":1,"to":2}}])"));
    SceneModel model = loaded("boxes:count=5");
    const auto count = read_movers(file, model);
    ASSERT_TRUE(count) << count.error().message;
    EXPECT_EQ(*count, 2u);
    for (const size_t frame : {0u, 1u, 2u}) { // it stands where the first key puts it
        EXPECT_EQ(glm::vec3{placed(model, 3, frame)[3]}, glm::vec3(1.0f, 2.0f, 3.0f));
    }
    EXPECT_EQ(glm::vec3{placed(model, 3, 3)[3]}, glm::vec3(2.0f, 2.0f, 2.0f));
    const glm::mat3 first{model.instances[3].world_from_mesh};
    for (const auto& [frame, degrees] : {std::pair{3u, 45.0f}, {4u, 90.0f}, {5u, 90.0f}}) {
        const glm::mat3 turn{
            glm::rotate(glm::mat4{1.0f}, glm::radians(degrees), glm::vec3{0.0f, 1.0f, 0.0f})};
        const glm::mat3 expected = turn * first;
        const glm::mat4 now = placed(model, 3, frame);
        for (int column = 0; column < 3; ++column) {
            EXPECT_LT(glm::distance(glm::vec3{now[column]}, expected[column]), 1e-4f) << frame;
        }
    }
    EXPECT_EQ(glm::vec3{placed(model, 3, 100)[3]}, glm::vec3(3.0f, 9.0f, 1.0f));
    // The other objects stay; one appears and disappears.
    EXPECT_EQ(placed(model, 0, 9), model.instances[0].world_from_mesh);
    for (const auto& [frame, there] : {std::pair{0u, false}, {1u, true}, {2u, true}, {3u, false}}) {
        EXPECT_EQ(exists(model.motion.instances[1], frame), there) << frame;
    }
}

TEST(Movers, WidenTheBoundsOfTheScene)
{
    const TempFolder folder;
    const std::string file = folder.write(
        "path.json",
        with_movers(R"([{"object":0,"keyframes":[{"frame":0,"position":[900,0,0]}]}])"));
    SceneModel model = loaded("boxes:count=5");
    ASSERT_TRUE(read_movers(file, model));
    EXPECT_GE(world_bounds(model).max.x, 900.0f);
    EXPECT_LT(world_bounds(model).min.x, 0.0f);
}

TEST(Movers, AreWhatTheFileHasAndNoMore)
{
    const TempFolder folder;
    SceneModel model = loaded("boxes:count=5");
    const auto none =
        read_movers(folder.write("path.json", std::string{"{"} + kFrames + "}"), model);
    ASSERT_TRUE(none);
    EXPECT_EQ(*none, 0u);
    EXPECT_TRUE(model.motion.empty());
}

void expect_error(const std::string& movers, const std::string& part)
{
    const TempFolder folder;
    const std::string file = folder.write("path.json", with_movers(movers));
    SceneModel model = loaded("boxes:count=5");
    model.instances[4].name = model.instances[0].name;
    const auto count = read_movers(file, model);
    ASSERT_FALSE(count) << movers;
    EXPECT_NE(count.error().message.find(file), std::string::npos) << count.error().message;
    EXPECT_NE(count.error().message.find(part), std::string::npos) << count.error().message;
    EXPECT_TRUE(model.motion.empty());
}

TEST(Movers, ErrorsNameTheFileAndThePlace)
{
    expect_error("7", "\"movers\" must be a list");
    expect_error("[7]", "movers[0] must be an object");
    expect_error("[{}]", "movers[0] has no \"object\"");
    expect_error(R"([{"object":"gate"}])", "movers[0].object: no object");
    expect_error(R"([{"object":5}])", "0 to 4");
    expect_error(R"([{"object":-1}])", "0 to 4");
    expect_error(R"([{"object":"box 0","visible":{}}])", "2 objects are called");
    expect_error(R"([{"object":1}])", "neither");
    expect_error(R"([{"object":1,"keyframes":[]}])", "movers[0].keyframes");
    expect_error(R"([{"object":1,"keyframes":[{"position":[0,0,0]}]}])",
                 "movers[0].keyframes[0] has no \"frame\"");
    expect_error(R"([{"object":1,"keyframes":[{"frame":1.5}]}])", "keyframes[0].frame");
    expect_error(R"([{"object":1,"keyframes":[{"frame":3},{"frame":3}]}])",
                 "keyframes[1].frame must be later");
    expect_error(R"([{"object":1,"keyframes":[{"frame":3,"position":[1,2]}]}])",
                 "keyframes[0].position");
    expect_error(R"([{"object":1,"keyframes":[{"frame":3,"rotation":[1,2]}]}])",
                 "keyframes[0].rotation must be an object");
    expect_error(
        R"([{"object":1,"keyframes":[{"frame":3,"rotation":{"axis":[0,0,0],"degrees":1}}]}])",
        "axis has no direction");
    expect_error(R"([{"object":1,"visible":{"from":3,"to":2}}])", "movers[0].visible.to");
    expect_error(R"([{"object":1,"visible":{"from":3}},{"object":1,"visible":{}}])",
                 "movers[1].object");
}

TEST(Movers, LeaveTightBoxesBehindOnceTheyHaveBeenQuiet)
{
    const TempFolder folder;
    const std::string file = folder.write(
        "path.json", with_movers(R"([{"object":2,"keyframes":[{"frame":0,"position":[0,0,80]},
            {"frame":4,"position":[0,0,-40]}]}])"));
    SceneModel model = loaded("boxes:count=60");
    ASSERT_TRUE(read_movers(file, model));
    CullScene scene = make_cull_scene(model);
    const TwoLevelOptions options{.leaf_triangles = 0, .quiet_frames = 3};
    TwoLevelScene tree{options};
    RelinkedTree relinked{tree, options};
    auto renderer = make_cpu_renderer(model, scene.items, {32, 24});
    ASSERT_TRUE(renderer);
    MotionPlayer player{model, scene, relinked, **renderer};
    for (size_t frame = 0; frame < 12; ++frame) {
        player.go_to(frame);
        const size_t loose = occlude::test::loose_boxes(tree.hierarchy());
        if (frame <= 4 + 2) { // moved in frame 4 for the last time
            EXPECT_GT(loose, 0u) << frame;
        } else {
            EXPECT_EQ(loose, 0u) << frame;
        }
    }
}

TEST(Movers, ArePlayedByVerifyAndTheImagesStayExact)
{
    const TempFolder folder;
    const std::string file = folder.write(
        "path.json", with_movers(R"([{"object":2,"keyframes":[{"frame":0,"position":[0,0,80]},
            {"frame":4,"position":[0,0,-40],"rotation":{"axis":[1,1,0],"degrees":170}}]},
            {"object":3,"visible":{"from":2}}])"));
    std::ostringstream out;
    std::ostringstream err;
    const std::vector<const char*> arguments{"occlude",
                                             "verify",
                                             "boxes:count=60",
                                             "--path",
                                             file.c_str(),
                                             "--device",
                                             "cpu",
                                             "--size",
                                             "96x64",
                                             "--algorithms",
                                             "chc,two_level,two_phase"};
    EXPECT_EQ(run_program(static_cast<int>(arguments.size()), arguments.data(), {out, err}), kDone)
        << out.str() << err.str();
    EXPECT_NE(out.str().find("5 frames"), std::string::npos) << out.str();
}

} // namespace
} // namespace occlude::tools
