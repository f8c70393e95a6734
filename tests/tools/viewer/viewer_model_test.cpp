#include "tools/temp_folder.h"
#include "tools/tiny_scenes.h"
#include "viewer/explain.h"
#include "viewer/fly_camera.h"
#include "viewer/keys.h"
#include "viewer/overlays.h"
#include "viewer/report_words.h"
#include "viewer/script.h"
#include "viewer/settings.h"

#include <glm/geometric.hpp>

#include <gtest/gtest.h>

#include <fstream>
#include <set>

namespace occlude::tools::viewer {

namespace {

constexpr glm::vec3 kUp{0.0f, 1.0f, 0.0f};

void expect_near(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-4f)
{
    EXPECT_LT(glm::length(a - b), tolerance)
        << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

TEST(FlyCamera, StandsAndLooksAsTheCameraItWasMadeFrom)
{
    for (const glm::vec3& up : {kUp, glm::vec3{0.0f, 0.0f, 1.0f}, glm::vec3{1.0f, 0.0f, 0.0f}}) {
        const Camera camera{.eye = {1, 2, 3}, .target = {4, 1, 7}, .up = up, .fov_y = 50.0f};
        const Camera made = FlyCamera{camera, up}.camera();
        expect_near(made.eye, camera.eye);
        expect_near(made.target - made.eye, glm::normalize(camera.target - camera.eye));
        EXPECT_EQ(made.fov_y, 50.0f);
    }
}

TEST(FlyCamera, TurnsRightAndUpAndStopsShortOfTheZenith)
{
    FlyCamera camera{{.eye = {0, 0, 0}, .target = {0, 0, -1}}, kUp};
    camera.look(1.5707963f, 0.0f);
    expect_near(camera.forward(), {1.0f, 0.0f, 0.0f});
    camera.look(0.0f, 10.0f);
    EXPECT_GT(camera.forward().y, 0.99f);
    EXPECT_GT(camera.forward().x, 0.0f) << "the heading would be lost straight up";
}

TEST(FlyCamera, FliesAlongItsOwnDirectionsAndRisesAlongTheScenesUp)
{
    FlyCamera camera{{.eye = {0, 0, 0}, .target = {1, 1, 0}}, kUp};
    camera.fly({0.0f, 2.0f, 0.0f});
    expect_near(camera.eye(), {0.0f, 2.0f, 0.0f});
    camera.fly({1.0f, 0.0f, 0.0f});
    expect_near(camera.eye(), {0.0f, 2.0f, 1.0f});
}

TEST(FlyCamera, OrbitingKeepsThePivotsDistanceAndPlaceInThePicture)
{
    FlyCamera camera{{.eye = {0, 0, 10}, .target = {1, 0, 0}}, kUp};
    const glm::vec3 pivot{0.0f};
    const float before = glm::dot(pivot - camera.eye(), camera.forward());
    camera.orbit(pivot, 0.7f, 0.2f);
    EXPECT_NEAR(glm::length(camera.eye()), 10.0f, 1e-3f);
    EXPECT_NEAR(glm::dot(pivot - camera.eye(), camera.forward()), before, 1e-3f);
}

TEST(Keys, EveryBindingIsReachedByItsKeyAndNoTwoShareOne)
{
    std::set<std::pair<int, bool>> used;
    for (const KeyBinding& binding : key_bindings()) {
        EXPECT_TRUE(used.insert({binding.code, binding.control}).second) << binding.shown;
        EXPECT_EQ(command_of(binding.code, binding.control), binding.command) << binding.shown;
        EXPECT_FALSE(binding.description.empty());
    }
    EXPECT_FALSE(command_of('F', true) == command_of('F', false));
    EXPECT_FALSE(command_of('Z', false).has_value());
}

TEST(Keys, FlyingKeysAreNotCommandsToo)
{
    const FlyKeys& fly = fly_keys();
    for (const int code : {fly.forward, fly.back, fly.left, fly.right, fly.up, fly.down}) {
        EXPECT_FALSE(command_of(code, false).has_value()) << code;
    }
}

TEST(Keys, NamesGiveTheCodesOfGlfw)
{
    EXPECT_EQ(key_code("w"), 'W');
    EXPECT_EQ(key_code("F12"), 301);
    EXPECT_EQ(key_code("Page Down"), 267);
    EXPECT_FALSE(key_code("F13").has_value());
    EXPECT_FALSE(key_code("").has_value());
}

TEST(Script, ReadsEveryKindOfInput)
{
    const auto steps =
        parse_script("# a comment\n\nwait 3\nkey ctrl+F\nhold w 10\nmove 1 2\n"
                     "click 3 4\nclick \"step\"\ndrag right 1 2 3 4\nscroll -2\n"
                     "type two words\ndrop a b.glb\nresize 900x600\nwait-loaded\n"
                     "wait-text here\nassert-text Drawn: now\nassert-no-text x\nscreenshot a.png\n",
                     "s");
    ASSERT_TRUE(steps) << steps.error().message;
    ASSERT_EQ(steps->size(), 16u);
    EXPECT_EQ((*steps)[0].line, 3);
    EXPECT_TRUE((*steps)[1].control);
    EXPECT_EQ((*steps)[2].count, 10);
    EXPECT_EQ((*steps)[5].kind, ScriptStep::Kind::click_label);
    EXPECT_EQ((*steps)[6].button, 1);
    EXPECT_EQ((*steps)[7].count, -2);
    EXPECT_EQ((*steps)[9].text, "a b.glb");
    EXPECT_EQ((*steps)[13].text, "Drawn: now");
}

TEST(Script, ErrorsNameTheLineAndWhatItMustLookLike)
{
    const auto unknown = parse_script("wait 1\njump 3\n", "walk.txt");
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("walk.txt: line 2"), std::string::npos);
    for (const char* bad : {"wait", "wait 0", "key nokey", "hold W", "click one two", "drag 1 2 3",
                            "resize big", "assert-text", "screenshot", "wait-loaded 3"}) {
        const auto steps = parse_script(bad, "s");
        ASSERT_FALSE(steps) << bad;
        EXPECT_NE(steps.error().message.find("write "), std::string::npos) << bad;
    }
}

TEST(Settings, WhatIsSavedIsLoadedAgain)
{
    const TempFolder folder;
    const auto file = std::filesystem::path{folder.path("deep")} / "viewer.json";
    Settings settings;
    settings.window_size = {900, 600};
    settings.scale = 1.5f;
    settings.timeline = true;
    settings.algorithms = {"adaptive", "chc"};
    settings.options[0]["adaptive"]["method"] = "raster";
    settings.bookmarks["castle"].push_back({.eye = {1, 2, 3}, .target = {4, 5, 6}});
    const auto saved = save_settings(file, settings);
    ASSERT_TRUE(saved) << saved.error().message;
    const Settings loaded = load_settings(file);
    EXPECT_EQ(loaded.window_size, settings.window_size);
    EXPECT_EQ(loaded.scale, 1.5f);
    EXPECT_TRUE(loaded.timeline);
    EXPECT_EQ(loaded.algorithms, settings.algorithms);
    EXPECT_EQ(loaded.options, settings.options);
    ASSERT_EQ(loaded.bookmarks.at("castle").size(), 1u);
    EXPECT_EQ(loaded.bookmarks.at("castle")[0].target, glm::vec3(4, 5, 6));
}

TEST(Settings, ABrokenFileGivesDefaultsWhereItIsBroken)
{
    const TempFolder folder;
    const auto file = folder.path("viewer.json");
    std::ofstream{file} << R"({"window_size":[1,"x"],"scale":99,"algorithms":["no","chc"],)"
                           R"("timeline":true,"bookmarks":{"a":[{"eye":3}]}})";
    const Settings loaded = load_settings(file);
    EXPECT_EQ(loaded.window_size, Settings{}.window_size);
    EXPECT_EQ(loaded.scale, 4.0f);
    EXPECT_EQ(loaded.algorithms[0], Settings{}.algorithms[0]);
    EXPECT_EQ(loaded.algorithms[1], "chc");
    EXPECT_TRUE(loaded.timeline);
    std::ofstream{file} << "not json";
    EXPECT_EQ(load_settings(file).algorithms, Settings{}.algorithms);
    EXPECT_EQ(load_settings(folder.path("none.json")).speed, 1.0f);
}

// stop_and_wait on the wall: items in front are drawn; items behind are tested and hidden.
class OnTheWall : public testing::Test {
protected:
    OnTheWall()
        : stage_(test::wall_model())
        , pane_("stop_and_wait", steady_seconds_clock())
    {
        for (uint64_t frame = 1; frame <= 3; ++frame) {
            pane_.cull(stage_.stage(), view_, stage_.renderer->device(), frame);
        }
    }

    View view_ = test::look_along_z();
    test::TinyStage stage_;
    Pane pane_;
};

TEST_F(OnTheWall, AHiddenItemIsExplainedByTheTestThatFoundNothing)
{
    const ItemExplanation why = explain(pane_, ItemId{1u});
    EXPECT_EQ(why.decision, Decision::hidden);
    EXPECT_NE(why.rule.find("no sample"), std::string::npos) << why.rule;
    ASSERT_TRUE(why.last_test);
    EXPECT_EQ(why.last_test->frames_ago, 0u);
    EXPECT_EQ(why.last_test->samples, 0u);
    ASSERT_FALSE(why.chain.empty());
    EXPECT_EQ(why.chain.front().node, pane_.culler()->hierarchy().root());
    EXPECT_EQ(why.chain.back().node, leaf_of(pane_.culler()->hierarchy(), ItemId{1u}));
    EXPECT_EQ(why.recent.size(), 3u);
}

TEST_F(OnTheWall, ADrawnItemAndOneOutsideAreExplainedToo)
{
    EXPECT_TRUE(is_drawn(explain(pane_, ItemId{0u}).decision));
    const ItemExplanation outside = explain(pane_, ItemId{5u});
    EXPECT_EQ(outside.decision, Decision::outside);
    EXPECT_NE(outside.rule.find("frustum"), std::string::npos);
}

TEST_F(OnTheWall, TheTraceHasEveryVerbInOrderWithItsTests)
{
    const FrameTrace& trace = pane_.trace();
    ASSERT_GE(trace.calls.size(), 4u);
    EXPECT_EQ(trace.calls.front().verb, DeviceVerb::begin_frame);
    EXPECT_EQ(trace.calls.back().verb, DeviceVerb::end_frame);
    EXPECT_EQ(trace.tests.size(), pane_.report().counters.queries);
    for (size_t i = 1; i < trace.calls.size(); ++i) {
        EXPECT_GE(trace.calls[i].begin_s, trace.calls[i - 1].end_s);
    }
    for (const TracedTest& test : trace.tests) {
        EXPECT_EQ(test.state, AnswerState::ready);
        EXPECT_FALSE(test.subjects.empty());
    }
}

TEST_F(OnTheWall, OccludersAreCountedInPixelsOfTheHiddenObject)
{
    const std::vector<uint32_t> instance_of{0, 1, 2, 3, 4, 5};
    const Stage stage = stage_.stage();
    const std::vector<ItemId> hidden{ItemId{1u}};
    const std::vector<ItemId> all = items_in_frustum(view_, stage.item_bounds);
    const Coverage found = coverage(stage.renderer.render_ids(view_, hidden),
                                    stage.renderer.render_ids(view_, all), instance_of, 1);
    EXPECT_GT(found.pixels, 0u);
    EXPECT_EQ(found.visible_pixels, 0u);
    ASSERT_FALSE(found.occluders.empty());
    uint64_t sum = 0;
    for (const Occluder& occluder : found.occluders) {
        EXPECT_TRUE(occluder.instance == 0 || occluder.instance == 3) << occluder.instance;
        sum += occluder.pixels;
    }
    EXPECT_EQ(sum, found.pixels);
}

TEST_F(OnTheWall, EveryOverlayThatDrawsHasALineInTheLegend)
{
    for (size_t i = 0; i < kOverlayCount; ++i) {
        OverlaySettings settings;
        settings.on[i] = true;
        settings.level = 1;
        const std::vector<float> depth(48 * 32, 0.5f);
        const OverlayPicture picture =
            make_overlays(settings, pane_, stage_.hierarchy.shapes(), {48, 32}, depth);
        const auto lines = legend(Fill::visible, settings, pane_);
        EXPECT_FALSE(lines.empty()) << kOverlayNames[i];
        if (static_cast<Overlay>(i) == Overlay::decided_boxes) {
            for (const WorldLines& drawn : picture.lines) {
                EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [&](const LegendLine& line) {
                    return line.color == drawn.color;
                })) << kOverlayNames[i];
            }
        }
    }
    EXPECT_TRUE(legend(Fill::visible, {}, pane_).empty());
}

TEST_F(OnTheWall, ChoosingAnotherAlgorithmOrOptionMakesAnotherCuller)
{
    const Culler* before = pane_.culler();
    pane_.choose_algorithm("chc");
    EXPECT_EQ(pane_.culler(), nullptr);
    pane_.set_option("threshold", "20");
    EXPECT_TRUE(pane_.cull(stage_.stage(), view_, stage_.renderer->device(), 4));
    EXPECT_NE(pane_.culler(), before);
    pane_.set_option("threshold", "nonsense");
    EXPECT_FALSE(pane_.cull(stage_.stage(), view_, stage_.renderer->device(), 5));
    EXPECT_NE(pane_.problem().find("threshold"), std::string::npos);
}

TEST(ReportWords, SayWhatTheFrameIsAndCost)
{
    FrameReport report;
    report.guarantee = Guarantee::latent(1);
    report.counters.items_drawn = 1;
    report.counters.queries = 1234;
    report.counters.waits = 2;
    std::string all;
    for (const std::string& line : report_in_words(report)) {
        all += line + "\n";
    }
    EXPECT_NE(all.find("may be drawn 1 frame late"), std::string::npos) << all;
    EXPECT_NE(all.find("1 item with"), std::string::npos) << all;
    EXPECT_NE(all.find("1,234 tests"), std::string::npos) << all;
    EXPECT_NE(all.find("waited for 2 answers"), std::string::npos) << all;
    EXPECT_TRUE(plan_in_words({}).empty());
    EXPECT_FALSE(plan_in_words({.kind = FramePlan::Kind::raster}).empty());
}

TEST(Palette, EveryDecisionHasAColourOfItsOwnInTheOrderOfTheEnum)
{
    for (size_t i = 0; i < kStateColors.size(); ++i) {
        EXPECT_EQ(static_cast<size_t>(kStateColors[i].decision), i);
        for (size_t j = 0; j < i; ++j) {
            EXPECT_GT(glm::length(kStateColors[i].color.color - kStateColors[j].color.color), 0.2f);
        }
    }
}

} // namespace

} // namespace occlude::tools::viewer
