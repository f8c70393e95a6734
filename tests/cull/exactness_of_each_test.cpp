// Invariant I6 for each algorithm, with each value of its options.
#include "cull/exactness.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using namespace test::exactness;

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

// A query for items of twelve triangles does not pay: these claim to have more.
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

// Items that are never culled are drawn first, however far they are. A pixel that they cover need
// not hide anything, and `lazy_grid` must not count it as a hiding one.
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

} // namespace
} // namespace occlude
