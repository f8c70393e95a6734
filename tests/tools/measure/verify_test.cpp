#include "measure/verify.h"

#include "tools/tiny_scenes.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace occlude::tools {

using namespace test;

namespace {

// A renderer whose target is one row of pixels and whose items are runs of pixels. Of equal depths
// the first wins, as with GL_LESS.
class RowRenderer final : public SceneRenderer {
public:
    struct Strip {
        int begin = 0;
        int end = 0;
        float depth = 0.0f;
        uint32_t color = 0;
    };
    explicit RowRenderer(std::vector<Strip> strips)
        : strips_(std::move(strips))
    {
    }

    std::string api() const override { return "row"; }
    std::string renderer_name() const override { return "row"; }
    QueryDevice& device() override { return device_; }
    Result<bool> use_test_method(TestMethod) override { return true; }
    Result<bool> resize(glm::ivec2, int) override { return true; }
    void finish() override {}
    void warm_up() override {}
    void render(const View&, std::span<const ItemId> items) override { paint(items); }
    Capture capture() override { return captured_; }
    std::vector<uint32_t> render_ids(const View&, std::span<const ItemId> items) override
    {
        return paint(items);
    }
    void set_item_colors(std::span<const glm::vec4>) override {}
    void draw_lines(const View&, std::span<const glm::vec3>, glm::vec4, bool) override {}
    void update_transforms(std::span<const glm::mat4>) override {}
    void update_items(std::span<const SceneModel::Item>) override {}

    Capture drawn(std::vector<ItemId> items)
    {
        paint(items);
        return captured_;
    }

private:
    static constexpr int kWidth = 10;

    std::vector<uint32_t> paint(std::span<const ItemId> items)
    {
        std::vector<uint32_t> ids(kWidth, ItemId::kInvalid);
        captured_.color = {{kWidth, 1}, std::vector<uint32_t>(kWidth, 0)};
        captured_.depth.assign(kWidth, 1.0f);
        for (const ItemId item : items) {
            const Strip& strip = strips_[item.value];
            for (int x = strip.begin; x < strip.end; ++x) {
                const auto pixel = static_cast<size_t>(x);
                if (strip.depth < captured_.depth[pixel]) {
                    captured_.depth[pixel] = strip.depth;
                    captured_.color.pixels[pixel] = strip.color;
                    ids[pixel] = item.value;
                }
            }
        }
        return ids;
    }

    std::vector<Strip> strips_;
    ScriptedDevice device_;
    Capture captured_;
};

constexpr ItemId kA{0u};
constexpr ItemId kB{1u};
constexpr ItemId kC{2u};

// Strips 0 and 1 lie in one plane and overlap in pixels 4 and 5; strip 2 is behind both.
struct Coplanar {
    RowRenderer renderer{
        {{0, 6, 0.5f, 0xff0000ffu}, {4, 10, 0.5f, 0xff00ff00u}, {3, 8, 0.7f, 0xffff0000u}}};
    std::vector<ItemBounds> bounds{
        3, {{glm::vec3{-1.0f, -1.0f, -6.0f}, glm::vec3{1.0f, 1.0f, -5.0f}}, 2}};
    Hierarchy hierarchy = build_bvh(bounds, {.leaf_triangles = 0});
    View view = look_along_z();

    Verdict judge(const Capture& culled, std::vector<ItemId> drawn)
    {
        const Capture reference = renderer.drawn({kA, kB, kC});
        return judge_frame({hierarchy, bounds, renderer}, view, reference, culled, drawn, {});
    }
};

} // namespace

TEST(JudgeFrame, TheSameImageIsEqual)
{
    Coplanar scene;
    const Verdict verdict = scene.judge(scene.renderer.drawn({kA, kB}), {kA, kB});
    EXPECT_EQ(verdict.differing_pixels, 0u);
    EXPECT_EQ(verdict.tied_pixels, 0u);
}

TEST(JudgeFrame, CoplanarSurfacesInAnotherOrderAreTiedNotDifferent)
{
    Coplanar scene;
    const Capture culled = scene.renderer.drawn({kB, kA});
    ASSERT_NE(culled.color.pixels, scene.renderer.drawn({kA, kB, kC}).color.pixels);
    const Verdict verdict = scene.judge(culled, {kB, kA});
    EXPECT_EQ(verdict.differing_pixels, 0u);
    EXPECT_EQ(verdict.tied_pixels, 2u);
    EXPECT_TRUE(verdict.missing.empty());
    ASSERT_EQ(verdict.coincident.size(), 1u);
    EXPECT_EQ(verdict.coincident[0].first, kA);
    EXPECT_EQ(verdict.coincident[0].last, kB);
    EXPECT_EQ(verdict.coincident[0].pixels, 2u);
}

TEST(JudgeFrame, ADepthOnlyPassShowsTheLastOfEqualsWhichIsTiedToo)
{
    Coplanar scene;
    const Verdict verdict = scene.judge(scene.renderer.drawn({kB, kA}), {kA, kB});
    EXPECT_EQ(verdict.differing_pixels, 0u);
    EXPECT_EQ(verdict.tied_pixels, 2u);
}

TEST(JudgeFrame, AMissingItemIsDifferentAlsoWhereTiesAre)
{
    Coplanar scene;
    const Verdict verdict = scene.judge(scene.renderer.drawn({kB}), {kB});
    EXPECT_EQ(verdict.differing_pixels, 6u); // all pixels of item 0, which owns the tied ones first
    EXPECT_EQ(verdict.tied_pixels, 0u);
    ASSERT_EQ(verdict.missing.size(), 1u);
    EXPECT_EQ(verdict.missing[0].item, kA);
    EXPECT_EQ(verdict.missing[0].pixels, 6u);
    EXPECT_EQ(verdict.first_pixel, glm::ivec2(0, 0));
}

TEST(JudgeFrame, ATraceThatATestLeftIsDifferentThoughNoItemIsMissing)
{
    Coplanar scene;
    Capture culled = scene.renderer.drawn({kA, kB, kC});
    culled.color.pixels[9] = 0xffffffffu;
    const Verdict verdict = scene.judge(culled, {kA, kB, kC});
    EXPECT_EQ(verdict.differing_pixels, 1u);
    EXPECT_TRUE(verdict.missing.empty());
    EXPECT_EQ(verdict.first_pixel, glm::ivec2(9, 0));
}

TEST(JudgeFrame, DepthAloneCanDiffer)
{
    Coplanar scene;
    Capture culled = scene.renderer.drawn({kA, kB, kC});
    culled.depth[2] = 0.25f;
    EXPECT_EQ(scene.judge(culled, {kA, kB, kC}).differing_pixels, 1u);
}

TEST(Verify, AWrongCullerIsCaughtAndNamedWithFrameItemAndNode)
{
    TinyStage tiny{wall_model()};
    const ItemId seen{3u}; // before the wall
    const std::vector<View> views = {look_along_z({0.0f, 0.0f, 0.0f}, 180.0f), look_along_z()};
    const std::vector<Contender> contenders = {registered("frustum"), dropping(seen)};
    const auto runs = verify(tiny.stage(), contenders, views);
    ASSERT_TRUE(runs);
    EXPECT_EQ(summarise((*runs)[0]).differing_pixels, 0u);
    EXPECT_FALSE(promises_kept(*runs));

    const AlgorithmRun& wrong = (*runs)[1];
    EXPECT_EQ(wrong.frames[0].verdict->differing_pixels, 0u); // looks the other way
    const Verdict& verdict = *wrong.frames[1].verdict;
    EXPECT_GT(verdict.differing_pixels, 0u);
    ASSERT_EQ(verdict.missing.size(), 1u);
    EXPECT_EQ(verdict.missing[0].item, seen);
    EXPECT_EQ(verdict.missing[0].pixels, verdict.differing_pixels);
    EXPECT_EQ(verdict.missing[0].decision, Decision::hidden);
    const std::span<const ItemId> blamed = tiny.hierarchy.subtree_items(verdict.missing[0].node);
    EXPECT_NE(std::find(blamed.begin(), blamed.end(), seen), blamed.end());

    const std::vector<std::string> lines = describe_differences(wrong, 10);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_NE(lines[0].find("dropping: frame 1"), std::string::npos) << lines[0];
    EXPECT_NE(lines[0].find("item 3"), std::string::npos) << lines[0];
    EXPECT_NE(lines[0].find("node " + std::to_string(verdict.missing[0].node.value)),
              std::string::npos)
        << lines[0];
    EXPECT_NE(lines[0].find("'hidden'"), std::string::npos) << lines[0];
}

TEST(Verify, DroppingWhatNobodySeesIsRight)
{
    TinyStage tiny{wall_model()};
    const std::vector<View> views = {look_along_z()};
    const std::vector<Contender> contenders = {dropping(ItemId{1u})}; // behind the wall
    const auto runs = verify(tiny.stage(), contenders, views);
    ASSERT_TRUE(runs);
    EXPECT_LT((*runs)[0].frames[0].counters.items_drawn, 5u);
    EXPECT_TRUE(promises_kept(*runs));
}

namespace {

// Moves before and behind the wall, with jumps between and some turns.
void expect_all_algorithms_exact(const Stage& stage)
{
    std::vector<View> views;
    for (int i = 0; i < 24; ++i) {
        const float x = static_cast<float>(i % 8) - 4.0f;
        const float z = i >= 12 ? -7.0f : 0.0f;
        views.push_back(look_along_z({x, 0.1f, z}, i % 5 == 4 ? 90.0f : 0.0f));
    }
    std::vector<Contender> contenders;
    for (const AlgorithmInfo& info : algorithms()) {
        contenders.push_back(registered(info.name));
    }
    const auto runs = verify(stage, contenders, views);
    ASSERT_TRUE(runs);
    for (const AlgorithmRun& run : *runs) {
        EXPECT_EQ(summarise(run).differing_pixels, 0u) << run.algorithm;
        EXPECT_TRUE(summarise(run).verified) << run.algorithm;
    }
}

} // namespace

TEST(Verify, EveryAlgorithmIsExactOnTheCpuThroughJumpsAndTurns)
{
    TinyStage tiny{wall_model()};
    expect_all_algorithms_exact(tiny.stage());
}

TEST(Verify, EveryAlgorithmIsExactWithOpenGlThroughJumpsAndTurns)
{
    TinyStage tiny{wall_model()};
    const auto renderer = make_gl_renderer(tiny.model, tiny.scene.items, {48, 32}, 1);
    ASSERT_TRUE(renderer) << renderer.error().message;
    expect_all_algorithms_exact({tiny.hierarchy, tiny.scene.scene.item_bounds(), **renderer});
}

TEST(Verify, CoplanarQuadsInAnotherOrderAreTiedWithOpenGl)
{
    SceneModel model;
    model.name = "coplanar";
    add_quad(model, {-2.0f, -1.0f}, {1.0f, 1.0f}, -4.0f, {1.0f, 0.0f, 0.0f});
    add_quad(model, {-2.0f, -1.0f}, {1.0f, 1.0f}, -4.0f, {0.0f, 1.0f, 0.0f});
    TinyStage tiny{std::move(model)};
    const auto renderer = make_gl_renderer(tiny.model, tiny.scene.items, {48, 32}, 1);
    ASSERT_TRUE(renderer) << renderer.error().message;
    const Stage stage{tiny.hierarchy, tiny.scene.scene.item_bounds(), **renderer};
    const View view = look_along_z();
    const std::vector<ItemId> ascending = {ItemId{0u}, ItemId{1u}};
    const std::vector<ItemId> descending = {ItemId{1u}, ItemId{0u}};
    (*renderer)->render(view, ascending);
    const Capture reference = (*renderer)->capture();
    (*renderer)->render(view, descending);
    const Capture culled = (*renderer)->capture();
    ASSERT_NE(reference.color.pixels, culled.color.pixels) << "the order does not show";
    const Verdict tied = judge_frame(stage, view, reference, culled, descending, {});
    EXPECT_EQ(tied.differing_pixels, 0u);
    EXPECT_GT(tied.tied_pixels, 0u);
    ASSERT_EQ(tied.coincident.size(), 1u);
    EXPECT_EQ(tied.coincident[0].pixels, tied.tied_pixels);
}

TEST(Verify, OnlyExactPromisesCount)
{
    AlgorithmRun approximate{"chc", Guarantee::approximate(20), std::vector<FrameFigures>(1)};
    approximate.frames[0].verdict = Verdict{.differing_pixels = 5};
    EXPECT_TRUE(promises_kept(std::vector<AlgorithmRun>{approximate}));
    approximate.guarantee = Guarantee::exact();
    EXPECT_FALSE(promises_kept(std::vector<AlgorithmRun>{approximate}));
}

TEST(DescribeDifferences, SaysHowManyFramesItLeftOut)
{
    AlgorithmRun run{"chc", {}, std::vector<FrameFigures>(5)};
    for (FrameFigures& frame : run.frames) {
        frame.verdict = Verdict{.differing_pixels = 1};
    }
    const std::vector<std::string> lines = describe_differences(run, 2);
    ASSERT_EQ(lines.size(), 3u);
    EXPECT_NE(lines[2].find("3 more frames"), std::string::npos);
}

} // namespace occlude::tools
