// The whole viewer without a window: panels, input and pictures.
// Long because: every behaviour of the application is tested through one fixture with one scene.
#ifdef OCCLUDE_HAS_VIEWER

#include "support/source_dir.h"
#include "tools/temp_folder.h"
#include "viewer/ui/app.h"
#include "viewer/ui/run_viewer.h"

#include <occlude/core/rng.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace occlude::tools::viewer {

namespace {

constexpr const char* kScene = "city:blocks=4,triangles=60k,seed=3";

// An app without a window, its scene loaded.
class InTheApp : public testing::Test {
protected:
    void SetUp() override
    {
        ImGui::CreateContext();
        auto window = open_headless_window({800, 480});
        ASSERT_TRUE(window) << window.error().message;
        StageOptions options;
        options.frames = 40;
        app_ = std::make_unique<App>(std::move(*window), options, Settings{}, 0.0f);
    }
    void TearDown() override
    {
        app_.reset();
        ImGui::DestroyContext();
    }
    void open(const std::string& scene)
    {
        app_->viewer().open(scene);
        while (app_->viewer().loader().loading()) {
            frames(1);
            std::this_thread::sleep_for(std::chrono::milliseconds{1});
        }
        ASSERT_NE(app_->viewer().session(), nullptr) << app_->viewer().state().message;
    }
    void frames(int count)
    {
        for (int i = 0; i < count; ++i) {
            app_->frame(1.0 / 60.0);
        }
    }
    void press(int code, bool control = false)
    {
        for (const bool down : {true, false}) {
            app_->window().feed(
                {.kind = InputEvent::Kind::key, .code = code, .down = down, .control = control});
            frames(1);
        }
    }

    std::unique_ptr<App> app_;
};

// Switches one thing at random.
void switch_something(Viewer& viewer, Rng& rng)
{
    const auto pick = [&](size_t count) { return rng.below(static_cast<uint32_t>(count)); };
    ViewerState& state = viewer.state();
    switch (pick(12)) {
    case 0:
    case 1:
        viewer.choose_algorithm(pick(2), algorithms()[pick(algorithms().size())].name);
        break;
    case 2: {
        Pane& pane = viewer.pane(0);
        const auto& options = find_algorithm(pane.algorithm())->options;
        if (!options.empty()) { // the values that every kind of option takes
            const OptionInfo& option = options[pick(options.size())];
            const bool flag = option.default_value == "true" || option.default_value == "false";
            pane.set_option(option.name,
                            flag ? (pick(2) == 0 ? "true" : "false") : option.default_value);
        }
        break;
    }
    case 3:
        viewer.choose_hierarchy(
            std::string{hierarchy_kinds()[pick(hierarchy_kinds().size())].name});
        break;
    case 4:
        viewer.choose_test(std::array{"queries", "raster", "pyramid"}[pick(3)]);
        break;
    case 5:
        state.picture.fill = static_cast<Fill>(pick(kFillNames.size()));
        break;
    case 6: {
        const size_t overlay = pick(kOverlayCount);
        state.picture.overlays.on[overlay] = !state.picture.overlays.on[overlay];
        break;
    }
    case 7:
        viewer.pick({static_cast<int>(pick(400)), static_cast<int>(pick(400))});
        break;
    default: {
        const auto bindings = key_bindings();
        const Command command = bindings[pick(bindings.size())].command;
        const bool writes_files = command == Command::screenshot || command == Command::quit ||
                                  command == Command::toggle_trace_recording ||
                                  command == Command::toggle_path_recording;
        if (!writes_files) {
            viewer.execute(command);
        }
    }
    }
}

TEST_F(InTheApp, ARandomWalkOverEverythingNeverFailsAndStaysExact)
{
    // A long walk by hand: OCCLUDE_WALK_FRAMES=2000 test_tools --gtest_filter='*ARandomWalk*'
    const char* wanted = std::getenv("OCCLUDE_WALK_FRAMES");
    const int kFrames = wanted != nullptr ? std::max(std::atoi(wanted), 100) : 400;
    constexpr uint64_t kSeed = 20;
    SCOPED_TRACE(testing::Message() << "seed " << kSeed);
    open(kScene);
    screen_notes().reading = true; // the panels are made in every frame
    Rng rng{kSeed};
    Viewer& viewer = app_->viewer();
    std::set<std::string> seen;
    for (int i = 0; i < kFrames; ++i) {
        switch_something(viewer, rng);
        if (i % 100 == 99) {
            viewer.choose_device(viewer.session()->device_name() == "gl" ? "cpu_fast" : "gl");
        }
        if (i % 50 == 0) {
            viewer.state().time.paused = false;
            viewer.state().picture.flare = false; // the tests of flares do not change the image
            viewer.execute(Command::check_exactness);
        }
        viewer.look({0.02f, 0.0f}, false);
        frames(1);
        seen.insert(viewer.pane(0).algorithm());
        ASSERT_EQ(app_->gl_errors(), 0u) << "frame " << i << ", " << viewer.pane(0).algorithm();
    }
    screen_notes().reading = false;
    // The walk may need more.
    EXPECT_GE(viewer.state().checked_frames, static_cast<uint64_t>(kFrames) / 50);
    EXPECT_EQ(viewer.state().wrong_frames, 0u) << viewer.state().message;
    EXPECT_GE(seen.size(), 6u) << "the walk must meet many algorithms to prove anything";
}

TEST_F(InTheApp, FreezingKeepsTheCullingCameraWhileTheObserverWalks)
{
    open(kScene);
    frames(2);
    Viewer& viewer = app_->viewer();
    press('F');
    const glm::mat4 frozen = viewer.culling_view().clip_from_world();
    app_->window().feed({.kind = InputEvent::Kind::key, .code = 'W', .down = true});
    frames(5);
    app_->window().feed({.kind = InputEvent::Kind::key, .code = 'W', .down = false});
    frames(1);
    EXPECT_EQ(viewer.culling_view().clip_from_world(), frozen);
    EXPECT_NE(viewer.shown_view().clip_from_world(), frozen);
    press('F');
    EXPECT_EQ(viewer.culling_view().clip_from_world(), viewer.shown_view().clip_from_world());
}

TEST_F(InTheApp, AKeyChangesThePictureInTheSameFrame)
{
    open(kScene);
    frames(3);
    const Image before = app_->screenshot();
    app_->window().feed({.kind = InputEvent::Kind::key, .code = 262, .down = true}); // right
    frames(1);
    uint64_t changed = 0;
    const Image after = app_->screenshot();
    for (int y = 100; y < 400; ++y) { // of the picture's own pixels
        for (int x = 310; x < 440; ++x) {
            const auto at = static_cast<size_t>(y) * 800 + static_cast<size_t>(x);
            changed += before.pixels[at] != after.pixels[at] ? 1 : 0;
        }
    }
    EXPECT_GT(changed, 100u);
}

TEST_F(InTheApp, AKeyChangesThePanelsWithinTwoFrames)
{
    open(kScene);
    frames(5);
    const Image before = app_->screenshot();
    app_->window().feed({.kind = InputEvent::Kind::key, .code = 293, .down = true}); // F4
    frames(2);
    const Image after = app_->screenshot();
    uint64_t changed = 0;
    for (int y = 20; y < 140; ++y) { // rows from the bottom, where the time line is now
        for (int x = 320; x < 780; ++x) {
            const auto at = static_cast<size_t>(y) * 800 + static_cast<size_t>(x);
            changed += before.pixels[at] != after.pixels[at] ? 1 : 0;
        }
    }
    EXPECT_GT(changed, 10000u);
}

TEST_F(InTheApp, PanelsAreMadeSeldomWhileNothingHappensToThem)
{
    open(kScene);
    frames(5);
    const uint64_t made = app_->timing().panel_frames;
    const uint64_t shown = app_->timing().frames;
    frames(60); // one second of the tests' time
    EXPECT_EQ(app_->timing().frames, shown + 60);
    EXPECT_LE(app_->timing().panel_frames, made + 10);
    app_->window().feed({.kind = InputEvent::Kind::move, .at = {100.0f, 100.0f}}); // on a panel
    frames(1);
    const uint64_t after_input = app_->timing().panel_frames;
    app_->window().feed({.kind = InputEvent::Kind::move, .at = {100.0f, 120.0f}});
    frames(1);
    EXPECT_EQ(app_->timing().panel_frames, after_input + 1);
}

TEST_F(InTheApp, TheLegendStandsBelowThePictureAndFitsItsWidth)
{
    open(kScene);
    frames(2);
    const std::vector<LegendLine> lines =
        legend(Fill::states, {.on = {true, true, true, true, true, true, true, true}},
               app_->viewer().pane(0));
    for (const ImVec2 window : {ImVec2{1280, 720}, ImVec2{900, 600}}) {
        const Layout without = make_layout({}, window);
        const Layout with = make_layout({}, window, lines);
        EXPECT_GT(with.legend_height, 0.0f);
        EXPECT_FLOAT_EQ(with.picture_max.y + with.legend_height, without.picture_max.y);
        EXPECT_GE(with.picture_size().y, 0.5f * window.y);
        for (const LegendLine& line : with.legend) {
            EXPECT_LT(ImGui::CalcTextSize(line.text.c_str()).x, with.picture_size().x - 30.0f)
                << line.text;
        }
    }
}

TEST_F(InTheApp, ANarrowWindowShowsThePanelThatWasAskedForLast)
{
    app_->window().feed({.kind = InputEvent::Kind::resize, .at = {900.0f, 600.0f}});
    open(kScene);
    frames(2);
    PanelState& panels = app_->viewer().state().panels;
    const auto shown = [&] { return make_layout(panels, {900.0f, 600.0f}); };
    EXPECT_TRUE(panels.narrow);
    EXPECT_TRUE(shown().controls && !shown().inspector);
    app_->viewer().select(0u);
    EXPECT_TRUE(shown().inspector && !shown().controls) << "why? must be seen";
    press(291); // F2
    EXPECT_TRUE(shown().controls && !shown().inspector);
    press(292); // F3
    EXPECT_TRUE(shown().inspector && !shown().controls);
    press(292);
    EXPECT_TRUE(shown().controls && !shown().inspector);
}

TEST_F(InTheApp, WhileFrozenAnInsetShowsWhatLiesOnTheCullingCamerasScreen)
{
    open(kScene);
    Viewer& viewer = app_->viewer();
    viewer.choose_algorithm(0, "lazy_grid");
    OverlaySettings& overlays = viewer.state().picture.overlays;
    overlays.on[static_cast<size_t>(Overlay::grid_cells)] = true;
    frames(4);
    EXPECT_TRUE(viewer.eye().empty()) << "the whole picture is the culling camera's";
    press('F');
    frames(2);
    ASSERT_FALSE(viewer.eye().empty());
    EXPECT_FALSE(viewer.marks().empty());
    viewer.state().picture.fill = Fill::visible;
    frames(2);
    EXPECT_EQ(viewer.eye().read().pixels.size(), viewer.canvas(0).read().pixels.size());
    const Image with = app_->screenshot();
    overlays.on[static_cast<size_t>(Overlay::grid_cells)] = false;
    frames(2);
    EXPECT_TRUE(viewer.eye().empty());
    EXPECT_NE(with.pixels, app_->screenshot().pixels);
}

TEST_F(InTheApp, EveryDeviceOfTheProgramCanBeChosenAndStaysExact)
{
    open(kScene);
    Viewer& viewer = app_->viewer();
    viewer.choose_test("raster");
    uint64_t checked = 0;
    for (const char* device : {"cpu_fast", "cpu", "gl"}) {
        viewer.choose_device(device);
        frames(3);
        EXPECT_EQ(viewer.session()->device_name(), device);
        EXPECT_FALSE(viewer.state().message_is_error) << viewer.state().message;
        viewer.execute(Command::check_exactness);
        frames(1);
        EXPECT_EQ(viewer.state().checked_frames, ++checked) << device;
        EXPECT_EQ(viewer.state().wrong_frames, 0u) << device;
    }
}

TEST_F(InTheApp, LoadingTellsWhatItDoesAndTheShareThatIsDone)
{
    Viewer& viewer = app_->viewer();
    viewer.open(source_dir() + "/assets/bunny/bunny.glb");
    std::set<std::string> phases;
    double largest = -1.0;
    while (viewer.loader().loading()) {
        phases.insert(viewer.loader().phase());
        const double share = viewer.loader().share();
        if (share >= 0.0) {
            EXPECT_LE(share, 1.0);
            largest = std::max(largest, share);
        }
        frames(1);
    }
    EXPECT_GT(largest, 0.0) << "a glTF file tells how much of it is read";
    EXPECT_EQ(phases.count("reading"), 1u);
}

TEST_F(InTheApp, TwoExactAlgorithmsDifferNowhere)
{
    open(kScene);
    Viewer& viewer = app_->viewer();
    viewer.choose_algorithm(0, "chc_plus_plus");
    viewer.choose_algorithm(1, "frustum");
    viewer.state().picture.difference = true;
    frames(4);
    const Image difference = viewer.difference().read();
    const Image left = viewer.canvas(0).read();
    ASSERT_FALSE(difference.pixels.empty());
    EXPECT_EQ(left.pixels, viewer.canvas(1).read().pixels);
    for (const uint32_t pixel : difference.pixels) { // grey where both agree
        const uint32_t red = pixel & 0xffu;
        const uint32_t green = (pixel >> 8) & 0xffu;
        ASSERT_EQ(red, green);
    }
}

TEST_F(InTheApp, AnObjectIsDeletedBroughtBackAndCopied)
{
    open(kScene);
    frames(2);
    Viewer& viewer = app_->viewer();
    const auto found = viewer.find_by_name("house");
    ASSERT_TRUE(found) << "the city has houses";
    viewer.select(found);
    frames(1);
    const size_t objects = viewer.session()->scene().scene.object_count();
    viewer.execute(Command::delete_object);
    frames(2);
    EXPECT_EQ(viewer.session()->scene().scene.object_count(), objects - 1);
    viewer.execute(Command::delete_object);
    frames(2);
    EXPECT_EQ(viewer.session()->scene().scene.object_count(), objects);
    viewer.execute(Command::duplicate_object);
    frames(2);
    EXPECT_EQ(viewer.session()->scene().scene.object_count(), objects + 1);
    viewer.execute(Command::check_exactness);
    frames(1);
    EXPECT_EQ(viewer.state().wrong_frames, 0u);
    EXPECT_EQ(viewer.state().checked_frames, 1u);
}

TEST_F(InTheApp, AFileThatCannotBeReadLeavesTheOldScene)
{
    open(kScene);
    app_->window().feed({.kind = InputEvent::Kind::drop, .text = "/nowhere/none.glb"});
    frames(1);
    while (app_->viewer().loader().loading()) {
        frames(1);
        std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    frames(1);
    EXPECT_NE(app_->viewer().session(), nullptr);
    EXPECT_TRUE(app_->viewer().state().message_is_error);
    EXPECT_NE(app_->viewer().state().message.find("none.glb"), std::string::npos);
}

TEST_F(InTheApp, LoadingCanBeCancelled)
{
    open(kScene);
    const Session* before = app_->viewer().session();
    app_->viewer().open("city:blocks=8,triangles=400k");
    frames(1);
    app_->viewer().loader().cancel();
    frames(3);
    EXPECT_FALSE(app_->viewer().loader().loading());
    EXPECT_EQ(app_->viewer().session(), before);
}

// Plays a script from a file of the tests' temporary folder.
Result<bool> play(const std::string& script, glm::ivec2 size, std::string* out = nullptr)
{
    const TempFolder folder;
    const std::string file = folder.path("script.txt");
    std::ofstream{file} << script;
    ViewOptions options;
    options.scene = kScene;
    options.headless = true;
    options.size = size;
    options.script = file;
    std::ostringstream stream;
    auto result = run_viewer(options, stream);
    if (out != nullptr) {
        *out = stream.str();
    }
    return result;
}

TEST(ViewScript, KeysAndClicksReachPanelsAndPicture)
{
    std::string out;
    const auto played = play("wait-loaded\nwait 3\n"
                             "assert-text F1 lists the keys\n"
                             "key F1\nwait 2\nassert-text list the keys\n"
                             "key escape\nwait 2\nassert-no-text list the keys\n"
                             "click \"Report\"\nwait 3\nassert-text Exact: every pixel\n"
                             "key F\nwait 2\nassert-text culling camera frozen\n"
                             "click \"pause\"\nwait 2\nassert-text paused\n"
                             "key T\nwait 2\nassert-text frustum\n"
                             "key ctrl+F\nwait 2\ntype house\nkey enter\nwait 3\n"
                             "assert-text Chain of nodes\n",
                             {1280, 720}, &out);
    EXPECT_TRUE(played) << played.error().message;
    EXPECT_NE(out.find("frames"), std::string::npos);
}

TEST(ViewScript, AnAssertionThatDoesNotHoldNamesItsLineAndWhatIsShown)
{
    const auto played = play("wait-loaded\nwait 2\nassert-text no such words\n", {900, 600});
    ASSERT_FALSE(played);
    EXPECT_NE(played.error().message.find("line 3"), std::string::npos);
    EXPECT_NE(played.error().message.find("algorithm"), std::string::npos)
        << played.error().message;
}

} // namespace

} // namespace occlude::tools::viewer

#endif
