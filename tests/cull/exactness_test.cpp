// Invariant I6: the image of an exact algorithm equals that of drawing everything in the frustum,
// pixel by pixel, on the exact CPU device: with teleports, turns, moving items, odd sizes, every
// option and every clip convention.
#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/registry.h>
#include <occlude/device/delaying_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include "support/all_methods_device.h"
#include "support/trees.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace occlude {
namespace {

/// Boxes of twelve triangles: item i is bounds[i] exactly, or a pyramid in it, which leaves most of
/// its box empty.
class BoxScene final : public CpuScene {
public:
    explicit BoxScene(std::vector<ItemBounds> items)
        : bounds(std::move(items))
    {
        for (ItemBounds& item : bounds) {
            item.triangles = 12;
        }
        positions_.resize(bounds.size());
        rebuild();
    }

    void rebuild()
    {
        for (size_t i = 0; i < bounds.size(); ++i) {
            const Aabb& box = bounds[i].box;
            auto& corners = positions_[i];
            corners.clear();
            for (int c = 0; c < 8; ++c) {
                glm::vec3 p{(c & 1) != 0 ? box.max.x : box.min.x,
                            (c & 2) != 0 ? box.max.y : box.min.y,
                            (c & 4) != 0 ? box.max.z : box.min.z};
                if (i % 3 == 0 && (c & 2) != 0) {
                    p = {box.center().x, box.max.y, box.center().z};
                }
                corners.push_back(p);
            }
        }
    }

    CpuItem item(ItemId item) const override
    {
        static const std::vector<uint32_t> kIndices{0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7,
                                                    0, 4, 1, 1, 4, 5, 2, 3, 6, 6, 3, 7,
                                                    0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};
        return {.positions = positions_[item.value],
                .indices = kIndices,
                .translucent = has_flag(bounds[item.value].flags, ItemFlags::translucent)};
    }

    std::vector<ItemBounds> bounds;

private:
    std::vector<std::vector<glm::vec3>> positions_;
};

struct Picture {
    std::vector<float> depth;
    std::vector<CpuDevice::Owner> owners;
    std::vector<CpuDevice::TranslucentFragment> translucent;

    bool operator==(const Picture&) const = default;
};

Picture picture_of(const CpuDevice& device)
{
    Picture picture;
    picture.depth.assign(device.depth().begin(), device.depth().end());
    for (size_t i = 0; i < picture.depth.size(); ++i) {
        picture.owners.push_back(device.owner(i));
    }
    const auto fragments = device.translucent_fragments();
    picture.translucent.assign(fragments.begin(), fragments.end());
    return picture;
}

View with_convention(const View& view, ClipConvention convention)
{
    glm::mat4 fix{1.0f};
    const bool reversed = convention.order == DepthOrder::near_is_large;
    if (convention.range == DepthRange::zero_to_one) {
        fix[2][2] = reversed ? -0.5f : 0.5f;
        fix[3][2] = 0.5f;
    } else if (reversed) {
        fix[2][2] = -1.0f;
    }
    return View::from_clip(fix * view.clip_from_world(), view.size_px(), convention);
}

// A walk with jumps and 90 degree turns, inside and outside of the boxes.
View camera(uint64_t frame, glm::ivec2 size)
{
    const float t = static_cast<float>(frame);
    if (frame % 10 == 5) {
        return test::look({-30.0f, 3.0f, 8.0f}, {30.0f, 0.0f, 0.0f}, size);
    }
    if (frame % 10 > 7) {
        return test::look({1.0f, 0.0f, 20.0f - t}, {60.0f, 0.0f, 20.0f - t}, size);
    }
    return test::look({1.0f, 0.5f, 26.0f - 2.0f * t}, {0.4f * t, 0.0f, -60.0f}, size);
}

struct Case {
    std::string algorithm;
    std::vector<OptionValue> options = {};
    ClipConvention convention = {};
    glm::ivec2 size{161, 89};
    bool moving = false;
    bool late_answers = false;
    std::string_view hierarchy = "bvh";
    TestMethod method = TestMethod::queries;
    bool flags = false; ///< some items are translucent, some never cull, some never occlude
    bool culls = true;  ///< must draw visibly less than what is in the frustum
    /// What an item claims to cost, to those who ask whether a test pays.
    uint32_t triangles_claimed = 12;
};

/// Exact by default, and decides by tests what to draw.
bool culls_exactly(const AlgorithmInfo& info)
{
    return info.exact && !info.needs.visible_set && info.name != "frustum";
}

// Runs an algorithm beside the reference and expects the same picture in every frame.
void expect_exact(const Case& setup)
{
    BoxScene scene(test::random_boxes(700, 31, 24.0f, 7.0f));
    for (size_t i = 0; setup.flags && i < scene.bounds.size(); ++i) {
        constexpr std::array kFlags{
            ItemFlags::translucent, ItemFlags::never_occlude, ItemFlags::never_cull,
            ItemFlags::never_cull | ItemFlags::translucent, ItemFlags::alpha_tested};
        scene.bounds[i].flags = i % 37 < kFlags.size() ? kFlags[i % 37] : ItemFlags::none;
    }
    for (ItemBounds& item : scene.bounds) {
        item.triangles = setup.triangles_claimed;
    }
    Hierarchy tree = find_hierarchy_kind(setup.hierarchy)->build(scene.bounds, 24);
    CpuDevice device(scene);
    ASSERT_TRUE(device.use_method(setup.method));
    CpuDevice reference_device(scene);
    DelayingDevice late(device, {.seed = 3, .max_polls = 5, .lose_every = 7});
    test::AllMethodsDevice used(setup.late_answers ? static_cast<QueryDevice&>(late) : device);
    FrustumCuller reference{tree};
    auto culler = make_culler(setup.algorithm, tree, setup.options);
    ASSERT_TRUE(culler) << culler.error().message;

    uint64_t drawn = 0;
    uint64_t in_frustum = 0;
    uint64_t blended = 0;
    for (uint64_t frame = 0; frame < 20; ++frame) {
        if (setup.moving) {
            for (size_t i = 0; i < scene.bounds.size(); ++i) {
                const glm::vec3 step{0.3f * static_cast<float>(i % 3) - 0.3f, 0.0f,
                                     0.2f * static_cast<float>(i % 5) - 0.4f};
                scene.bounds[i].box.min += step;
                scene.bounds[i].box.max += step;
            }
            scene.rebuild();
            tree.refit(scene.bounds);
        }
        const View view = with_convention(camera(frame, setup.size), setup.convention);
        reference.cull(view, reference_device);
        (*culler)->cull(view, used);
        const Picture expected = picture_of(reference_device);
        ASSERT_EQ(picture_of(device), expected) << "frame " << frame;
        blended += expected.translucent.size();
        drawn += (*culler)->drawn_items().size();
        in_frustum += reference.drawn_items().size();
    }
    // The scene is evidence: something is hidden, and something is not.
    EXPECT_TRUE(drawn < in_frustum * 19 / 20 || !setup.culls);
    EXPECT_GT(drawn, in_frustum / 20);
    EXPECT_EQ(blended > 1000, setup.flags);
}

TEST(Exactness, StopAndWait)
{
    expect_exact({.algorithm = "stop_and_wait"});
}
TEST(Exactness, BatchAndWait)
{
    expect_exact({.algorithm = "batch_and_wait"});
    expect_exact({.algorithm = "batch_and_wait", .options = {{"batch_size", "3"}}});
    expect_exact({.algorithm = "batch_and_wait", .options = {{"sphere_elongation", "1.5"}}});
    expect_exact({.algorithm = "batch_and_wait", .moving = true});
    expect_exact({.algorithm = "batch_and_wait", .late_answers = true});
}
TEST(Exactness, Chc)
{
    expect_exact({.algorithm = "chc"});
}
TEST(Exactness, ChcWithGeometryTests)
{
    expect_exact({.algorithm = "chc", .options = {{"visible_test", "geometry"}}});
}
TEST(Exactness, ChcAssumingVisibility)
{
    expect_exact({.algorithm = "chc", .options = {{"assume_visible_frames", "4"}}});
}
TEST(Exactness, ChcPlusPlus)
{
    expect_exact({.algorithm = "chc_plus_plus"});
}

TEST(Exactness, ChcPlusPlusWithEachPartSwitched)
{
    const std::vector<OptionValue> switches{
        {"batch_size", "1"},
        {"v_queue", "false"},
        {"render_queue", "false"},
        {"jitter", "false"},
        {"tight_bounds_depth", "0"},
        {"virtual_leaves", "false"},
        {"multiqueries", "analytic"},
        {"multiqueries", "off"},
        {"min_render_triangles", "600"},
        {"depth_only_pass", "true"},
        {"v_fill", "1"},
        {"assume_visible_frames", "1"},
    };
    for (const OptionValue& option : switches) {
        SCOPED_TRACE(option.first + "=" + option.second);
        expect_exact({.algorithm = "chc_plus_plus", .options = {option}});
    }
}

TEST(Exactness, TwoPhase)
{
    expect_exact({.algorithm = "two_phase"});
}
TEST(Exactness, TwoPhaseWithEachPartSwitched)
{
    const std::vector<OptionValue> switches{{"virtual_leaves", "true"},
                                            {"refine", "false"},
                                            {"reread_triangles", "0"},
                                            {"reread_triangles", "200"},
                                            {"final_depth", "true"},
                                            {"tile", "2"},
                                            {"tile", "8"},
                                            {"tile", "64"}};
    for (const OptionValue& option : switches) {
        SCOPED_TRACE(option.first + "=" + option.second);
        expect_exact({.algorithm = "two_phase", .options = {option}});
    }
}

// Items of twelve triangles are not worth a query: these claim to have more.
constexpr uint32_t kWorthATest = 3000;

TEST(Exactness, AdaptiveByEveryMethodOnEveryHierarchy)
{
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        for (const std::string method : {"automatic", "queries", "raster", "pyramid"}) {
            SCOPED_TRACE(method + " on " + std::string{kind.name});
            const Case standing{.algorithm = "adaptive",
                                .options = {{"method", method}},
                                .hierarchy = kind.name,
                                .triangles_claimed = kWorthATest};
            expect_exact(standing);
            Case moving = standing;
            moving.moving = true;
            expect_exact(moving);
            moving.late_answers = true;
            expect_exact(moving);
            Case flags = standing;
            flags.flags = true;
            expect_exact(flags);
        }
    }
}

TEST(Exactness, AdaptiveThatDrawsAllIsFrustumCulling)
{
    const Case all{.algorithm = "adaptive", .options = {{"method", "draw_all"}}, .culls = false};
    expect_exact(all);
    Case flags = all;
    flags.flags = true;
    expect_exact(flags);
}

TEST(Exactness, UniformGrid)
{
    for (const std::string levels : {"0", "1", "3"}) {
        for (const std::string triangles : {"24", "200"}) {
            SCOPED_TRACE(levels + " levels, cells of " + triangles);
            const std::vector<OptionValue> options{{"nested_levels", levels},
                                                   {"cell_triangles", triangles}};
            expect_exact({.algorithm = "uniform_grid", .options = options});
            expect_exact({.algorithm = "uniform_grid", .options = options, .moving = true});
        }
    }
    expect_exact({.algorithm = "uniform_grid",
                  .options = {{"cell_triangles", "100"}},
                  .late_answers = true});
}

TEST(Exactness, PrioritizedWithTheConservativeFinish)
{
    for (const std::string budget : {"1", "1500"}) {
        const std::vector<OptionValue> options{
            {"finish", "true"}, {"budget_triangles", budget}, {"cell_triangles", "60"}};
        expect_exact({.algorithm = "prioritized", .options = options});
        expect_exact({.algorithm = "prioritized", .options = options, .moving = true});
        expect_exact({.algorithm = "prioritized", .options = options, .late_answers = true});
    }
}

TEST(Exactness, Statistical)
{
    expect_exact({.algorithm = "statistical"});
}

TEST(Exactness, StatisticalWithEachPartSwitched)
{
    const std::vector<OptionValue> switches{
        {"base_time", "0"},         {"base_time", "0.05"}, {"history", "1"},
        {"max_age", "0"},           {"spread", "0"},       {"max_in_flight", "1"},
        {"max_in_flight", "500"},   {"issue", "at_place"}, {"results", "oldest"},
        {"frames_per_second", "5"},
    };
    for (const OptionValue& option : switches) {
        SCOPED_TRACE(option.first + "=" + option.second);
        expect_exact({.algorithm = "statistical", .options = {option}});
    }
}

TEST(Exactness, TwoLevelWithEachPartSwitched)
{
    const std::vector<OptionValue> switches{
        {"disjoint", "true"},      {"disjoint", "false"},       {"max_pending", "1"},
        {"history_length", "1"},   {"history_length", "32"},    {"frames_per_visible", "0"},
        {"max_postponed", "1000"}, {"frames_per_visible", "9"}, {"spread", "false"},
        {"multiqueries", "false"},
    };
    for (const OptionValue& option : switches) {
        SCOPED_TRACE(option.first + "=" + option.second);
        expect_exact({.algorithm = "two_level", .options = {option}});
    }
    expect_exact({.algorithm = "two_level", .late_answers = true});
}

TEST(Exactness, OnEveryHierarchy)
{
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        for (const AlgorithmInfo& info : algorithms()) {
            const bool has_own_cells = info.name == "uniform_grid"; // and no use of nodes
            if (culls_exactly(info) && !has_own_cells) {
                SCOPED_TRACE(info.name + " on " + std::string{kind.name});
                expect_exact({.algorithm = info.name, .hierarchy = kind.name});
                expect_exact({.algorithm = info.name, .moving = true, .hierarchy = kind.name});
            }
        }
    }
}

TEST(Exactness, WithTestsAnsweredByTheDepthPyramid)
{
    for (const AlgorithmInfo& info : algorithms()) {
        if (culls_exactly(info) && !info.needs.depth_read) {
            SCOPED_TRACE(info.name);
            std::vector<OptionValue> options;
            if (info.name == "uniform_grid") {
                options.emplace_back("cell_triangles", "100"); // else three cells hold all
            }
            expect_exact(
                {.algorithm = info.name, .options = options, .method = TestMethod::pyramid});
            expect_exact({.algorithm = info.name,
                          .options = options,
                          .moving = true,
                          .method = TestMethod::pyramid});
        }
    }
    expect_exact({.algorithm = "chc_plus_plus",
                  .convention = {DepthRange::zero_to_one, DepthOrder::near_is_large},
                  .method = TestMethod::pyramid});
}

TEST(Exactness, LazyGridWithEachPartSwitched)
{
    const std::vector<std::vector<OptionValue>> switches{
        {},
        {{"cell_size", "1"}},
        {{"cell_size", "7"}},
        {{"cell_size", "1000"}},
        {{"update", "busy"}},
        {{"traversal", "two_lists"}},
        {{"traversal", "two_lists"}, {"update", "busy"}},
        {{"variant", "occlusion_buffer"}},
        {{"variant", "occlusion_buffer"}, {"update", "busy"}},
        {{"source", "queries"}},
        {{"source", "queries"}, {"traversal", "two_lists"}, {"join", "rows"}},
        {{"source", "queries"}, {"variant", "occlusion_buffer"}},
        {{"source", "queries"}, {"variant", "occlusion_buffer"}, {"update", "busy"}},
        {{"source", "queries"}, {"whole_cell_share", "0.4"}},
        {{"join", "rows"}},
        {{"join", "target"}, {"update", "busy"}},
        {{"tests_at_once", "8"}},
        {{"tests_at_once", "8"}, {"join", "rows"}, {"variant", "occlusion_buffer"}},
        {{"bounds", "faces"}},
        {{"bounds", "faces"}, {"cell_size", "7"}, {"join", "target"}, {"update", "busy"}},
        {{"bounds", "faces"}, {"traversal", "two_lists"}},
        {{"bounds", "faces"}, {"variant", "occlusion_buffer"}, {"join", "rows"}},
        {{"bounds", "faces"}, {"source", "queries"}, {"whole_cell_share", "0.4"}},
        {{"free_below_covered", "0.6"}},
        {{"whole_cell_share", "0.5"}},
        {{"whole_cell_share", "0.5"}, {"join", "rows"}},
        {{"internal_above_pixels", "900"}},
        {{"tile", "8"}},
        {{"tile", "8"}, {"cell_size", "7"}, {"update", "busy"}},
        {{"tile", "4"}, {"bounds", "faces"}, {"whole_cell_share", "0.5"}},
        {{"tile", "2"}, {"variant", "occlusion_buffer"}, {"tests_at_once", "8"}},
        {{"variant", "occlusion_buffer"},
         {"free_below_covered", "0.6"},
         {"whole_cell_share", "0.5"},
         {"internal_above_pixels", "900"}},
        {{"source", "queries"},
         {"traversal", "two_lists"},
         {"free_below_covered", "0.6"},
         {"whole_cell_share", "0.5"},
         {"internal_above_pixels", "900"}},
    };
    for (const std::vector<OptionValue>& options : switches) {
        std::string name = "lazy_grid";
        for (const OptionValue& option : options) {
            name += " " + option.first + "=" + option.second;
        }
        SCOPED_TRACE(name);
        expect_exact({.algorithm = "lazy_grid", .options = options, .late_answers = true});
    }
}

TEST(Exactness, LazyGridInEveryClipConventionAndSize)
{
    for (const char* source : {"depth", "queries"}) {
        SCOPED_TRACE(source);
        const std::vector<OptionValue> options{{"source", source}};
        for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one}) {
            for (const DepthOrder order : {DepthOrder::near_is_small, DepthOrder::near_is_large}) {
                expect_exact({.algorithm = "lazy_grid",
                              .options = options,
                              .convention = {range, order},
                              .size = {67, 211}});
            }
        }
    }
}

TEST(Exactness, InEveryClipConvention)
{
    for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one}) {
        for (const DepthOrder order : {DepthOrder::near_is_small, DepthOrder::near_is_large}) {
            expect_exact({.algorithm = "chc_plus_plus", .convention = {range, order}});
            expect_exact({.algorithm = "two_phase", .convention = {range, order}});
            expect_exact({.algorithm = "adaptive", .convention = {range, order}});
        }
    }
}

TEST(Exactness, AtOtherSizes)
{
    expect_exact({.algorithm = "chc_plus_plus", .size = {320, 180}});
    expect_exact({.algorithm = "stop_and_wait", .size = {67, 211}});
    expect_exact({.algorithm = "two_phase", .size = {67, 211}});
    expect_exact({.algorithm = "adaptive", .size = {67, 211}});
    expect_exact({.algorithm = "two_phase", .size = {256, 128}});
}

TEST(Exactness, WhileEverythingMoves)
{
    expect_exact({.algorithm = "stop_and_wait", .moving = true});
    expect_exact({.algorithm = "chc", .moving = true});
    expect_exact({.algorithm = "chc_plus_plus", .moving = true});
    expect_exact({.algorithm = "two_phase", .moving = true});
    expect_exact({.algorithm = "statistical", .moving = true});
    expect_exact({.algorithm = "lazy_grid", .moving = true});
    expect_exact({.algorithm = "adaptive", .moving = true});
}

TEST(Exactness, WithLateAndLostAnswers)
{
    expect_exact({.algorithm = "chc", .late_answers = true});
    expect_exact({.algorithm = "chc_plus_plus", .late_answers = true});
    expect_exact({.algorithm = "statistical", .late_answers = true});
    expect_exact(
        {.algorithm = "statistical", .options = {{"results", "oldest"}}, .late_answers = true});
}

TEST(Exactness, WithTranslucentAndOtherFlaggedItems)
{
    for (const AlgorithmInfo& info : algorithms()) {
        if (culls_exactly(info)) {
            SCOPED_TRACE(info.name);
            expect_exact({.algorithm = info.name, .flags = true});
        }
    }
    const std::vector<OptionValue> geometry{{"visible_test", "geometry"}};
    expect_exact({.algorithm = "chc", .options = geometry, .flags = true});
    const std::vector<OptionValue> depth_only{{"depth_only_pass", "true"}};
    expect_exact({.algorithm = "chc_plus_plus", .options = depth_only, .flags = true});
}

// Items that are never culled are drawn before everything else, however far they are: a covered
// pixel hides nothing then. `lazy_grid` used to say so all the same.
TEST(Exactness, OfEveryVariantOfLazyGridWithFlaggedItems)
{
    for (const char* variant : {"z_buffer", "occlusion_buffer"}) {
        for (const char* source : {"depth", "queries"}) {
            for (const char* update : {"lazy", "busy"}) {
                for (const char* tests : {"1", "32"}) {
                    SCOPED_TRACE(std::string{variant} + " " + source + " " + update + " " + tests);
                    expect_exact({.algorithm = "lazy_grid",
                                  .options = {{"variant", variant},
                                              {"source", source},
                                              {"update", update},
                                              {"tests_at_once", tests}},
                                  .flags = true});
                }
            }
        }
    }
}

TEST(Exactness, ARebuiltHierarchyStartsAfresh)
{
    BoxScene scene(test::random_boxes(300, 32, 24.0f, 7.0f));
    Hierarchy tree = build_bvh(scene.bounds, {.leaf_triangles = 24});
    CpuDevice device(scene);
    CpuDevice reference_device(scene);
    auto culler = make_culler("chc_plus_plus", tree);
    for (uint64_t frame = 0; frame < 12; ++frame) {
        if (frame == 6) {
            tree =
                build_bvh(scene.bounds, {.leaf_triangles = 60}); // other node ids in the same place
        }
        const View view = camera(frame, {161, 89});
        const FrameReport report = (*culler)->cull(view, device);
        FrustumCuller reference{tree};
        reference.cull(view, reference_device);
        ASSERT_EQ(picture_of(device), picture_of(reference_device)) << "frame " << frame;
        EXPECT_EQ(report.frame, frame % 6); // counts again from the rebuild
    }
}

TEST(Exactness, TheOraclesDrawTheSamePicture)
{
    BoxScene scene(test::random_boxes(500, 33, 24.0f, 7.0f));
    for (size_t i = 0; i < scene.bounds.size(); i += 29) {
        scene.bounds[i].flags = ItemFlags::translucent;
    }
    const Hierarchy tree = build_bvh(scene.bounds, {.leaf_triangles = 24});
    CpuDevice device(scene);
    CpuDevice reference_device(scene);
    FrustumCuller reference{tree};
    size_t drawn_by_opt = 0;
    for (const std::string name : {"opt", "ideal"}) {
        auto culler = make_culler(name, tree);
        auto& oracle = dynamic_cast<OracleCuller&>(**culler);
        size_t drawn = 0;
        for (uint64_t frame = 0; frame < 10; ++frame) {
            const View view = camera(frame, {161, 89});
            reference.cull(view, reference_device);
            const Picture expected = picture_of(reference_device);
            std::set<ItemId> owners;
            for (const CpuDevice::Owner& owner : expected.owners) {
                if (owner.item.valid()) {
                    owners.insert(owner.item);
                }
            }
            const std::vector<ItemId> list(owners.begin(), owners.end());
            oracle.record(view, device, list);
            const FrameReport report = oracle.cull(view, device);
            ASSERT_EQ(picture_of(device), expected) << name << ", frame " << frame;
            EXPECT_EQ(report.counters.queries, 0u);
            if (name == "ideal") {
                EXPECT_GE(oracle.drawn_items().size(), list.size()); // and translucent ones
            }
            drawn += oracle.drawn_items().size();
        }
        if (name == "opt") {
            drawn_by_opt = drawn;
        } else {
            EXPECT_LT(drawn, drawn_by_opt); // boxes are looser than what they bound
        }
    }
}

TEST(Exactness, OptDrawsWhatStopAndWaitDraws)
{
    BoxScene scene(test::random_boxes(500, 34, 24.0f, 7.0f));
    // Items in inner nodes too.
    const Hierarchy tree = find_hierarchy_kind("bsp")->build(scene.bounds, 24);
    CpuDevice device(scene);
    auto stop_and_wait = make_culler("stop_and_wait", tree);
    auto opt = make_culler("opt", tree);
    auto& oracle = dynamic_cast<OracleCuller&>(**opt);
    for (uint64_t frame = 0; frame < 5; ++frame) {
        const View view = camera(frame, {161, 89});
        (*stop_and_wait)->cull(view, device);
        oracle.record(view, device, {});
        oracle.cull(view, device);
        EXPECT_TRUE(std::ranges::equal((*stop_and_wait)->drawn_items(), oracle.drawn_items()));
    }
}

} // namespace
} // namespace occlude
