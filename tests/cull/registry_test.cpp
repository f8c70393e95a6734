#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>

#include "support/visibility_script.h"
#include "support/walks.h"

#include <occlude/cull/parts/decision_log.h>
#include <occlude/cull/statistical.h>
#include <occlude/cull/uniform_grid.h>
#include <occlude/device/scripted_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace occlude {
namespace {

TEST(Registry, EveryAlgorithmIsMadeByItsName)
{
    const Hierarchy tree = test::row_tree(1);
    for (const AlgorithmInfo& info : algorithms()) {
        const auto culler = make_culler(info.name, tree);
        ASSERT_TRUE(culler) << info.name;
        EXPECT_EQ(find_algorithm(info.name), &info);
        EXPECT_FALSE(info.summary.empty());
        EXPECT_EQ(dynamic_cast<OracleCuller*>(culler->get()) != nullptr, info.needs.visible_set);
    }
}

TEST(Registry, EveryOptionTakesItsOwnDefault)
{
    const Hierarchy tree = test::row_tree(1);
    for (const AlgorithmInfo& info : algorithms()) {
        for (const OptionInfo& option : info.options) {
            const OptionValue value{option.name, option.default_value};
            EXPECT_TRUE(make_culler(info.name, tree, {&value, 1}))
                << info.name << "." << option.name;
            EXPECT_FALSE(option.description.empty());
        }
    }
}

// Values that "a whole number from 1 to 64" refuses: one less, one more, and text that is no
// number.
std::vector<std::string> values_outside(const std::string& accepted)
{
    std::vector<std::string> outside{"-1", "nan", "inf", "1e400", "", "many"};
    const size_t from = accepted.find(" from ");
    const size_t to = accepted.find(" to ");
    if (from != std::string::npos && to != std::string::npos) {
        const double least = std::stod(accepted.substr(from + 6));
        const double most = std::stod(accepted.substr(to + 4));
        if (least >= 1.0) {
            outside.push_back(std::to_string(static_cast<int64_t>(least) - 1));
        }
        if (most < 4e9) {
            outside.push_back(std::to_string(static_cast<int64_t>(most) + 1));
        }
        outside.push_back("18446744073709551616"); // 2^64
    }
    return outside;
}

TEST(Registry, EveryNumericOptionOfAnAlgorithmHasARange)
{
    const Hierarchy tree = test::row_tree(1);
    size_t numbers = 0;
    for (const AlgorithmInfo& info : algorithms()) {
        for (const OptionInfo& option : info.options) {
            if (option.accepted_values.find("number") == std::string::npos) {
                continue;
            }
            ++numbers;
            for (const std::string& text : values_outside(option.accepted_values)) {
                const OptionValue value{option.name, text};
                const auto culler = make_culler(info.name, tree, {&value, 1});
                ASSERT_FALSE(culler) << info.name << "." << option.name << "=" << text;
                EXPECT_NE(culler.error().message.find(option.accepted_values), std::string::npos);
            }
        }
    }
    EXPECT_GT(numbers, 30u);
}

TEST(Registry, EveryNumericOptionOfAHierarchyHasARange)
{
    const std::vector<ItemBounds> items = test::random_boxes(10, 1);
    size_t numbers = 0;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        for (const OptionInfo& option : kind.options()) {
            if (option.accepted_values.find("number") == std::string::npos) {
                continue;
            }
            ++numbers;
            for (const std::string& text : values_outside(option.accepted_values)) {
                const OptionValue value{option.name, text};
                EXPECT_FALSE(kind.build_with(items, 0, {&value, 1}))
                    << kind.name << "." << option.name << "=" << text;
            }
        }
    }
    EXPECT_GT(numbers, 10u);
}

// 4294967295 levels of nested grids must not make the library throw bad_alloc.
TEST(Registry, OptionsSetInCodeAreMovedIntoTheirRange)
{
    const UniformGridOptions options =
        clamped(UniformGridOptions{.cell_triangles = 0, .nested_levels = 0xffffffffu});
    EXPECT_EQ(options.cell_triangles, 1u);
    EXPECT_EQ(options.nested_levels, 8u);
    const StatisticalOptions statistical =
        clamped(StatisticalOptions{.base_time = std::numeric_limits<float>::quiet_NaN()});
    EXPECT_EQ(statistical.base_time, 0.0f); // tests every node in every frame
    const Hierarchy tree = test::row_tree(1);
    UniformGrid culler(tree, {.cell_triangles = 0, .nested_levels = 0xffffffffu});
    ScriptedDevice device;
    EXPECT_EQ(culler.cull(test::look_ahead(), device).counters.items_drawn, 2u);
}

TEST(Registry, SaysWhichHierarchiesSuitAnAlgorithm)
{
    using Names = std::vector<std::string>;
    const Names all{"bvh", "bsp", "octree", "grid", "two_level"};
    for (const AlgorithmInfo& info : algorithms()) {
        for (const std::string& name : info.hierarchies) {
            EXPECT_NE(find_hierarchy_kind(name), nullptr) << info.name << ": " << name;
        }
    }
    EXPECT_EQ(find_algorithm("chc")->hierarchies, all);
    EXPECT_EQ(find_algorithm("two_level")->hierarchies, all);
    EXPECT_EQ(find_algorithm("next_frame")->hierarchies, (Names{"bvh", "octree", "grid"}));
    EXPECT_TRUE(find_algorithm("uniform_grid")->hierarchies.empty());
}

// Each algorithm does what its kTraits promise.
TEST(Registry, TheTraitsOfAnAlgorithmAreTrue)
{
    const Hierarchy tree = test::random_bvh(300, 5);
    uint64_t epoch = 0;
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.needs.visible_set) {
            continue;
        }
        DeviceScript script{.boxes = test::consistent_visibility(tree, 7, epoch, 0.3f)};
        script.caps.read_depth = true;
        script.depth = [](const PixelRect&, std::span<float> depth) {
            std::ranges::fill(depth, 0.99f);
            return true;
        };
        ScriptedDevice device(script);
        const auto culler = std::move(make_culler(info.name, tree).value());
        FrameCounters counters;
        size_t unlike_a_fresh_one = 0;
        for (uint64_t frame = 0; frame < 12; ++frame) {
            epoch = frame / 4;
            const FrameReport report = culler->cull(test::rough_walk(frame), device);
            EXPECT_EQ(report.guarantee == Guarantee::exact(), info.exact) << info.name;
            counters += report.counters;
            ScriptedDevice fresh_device(script);
            const auto fresh = std::move(make_culler(info.name, tree).value());
            fresh->cull(test::rough_walk(frame), fresh_device);
            unlike_a_fresh_one +=
                std::ranges::equal(culler->drawn_items(), fresh->drawn_items()) ? 0 : 1;
        }
        if (info.needs.queries || info.needs.depth_read) { // the others use what is available
            EXPECT_EQ(info.needs.depth_read, counters.depth_reads > 0) << info.name;
        }
        if (!info.remembers) {
            EXPECT_EQ(unlike_a_fresh_one, 0u) << info.name << " remembers";
        }
    }
}

TEST(Registry, WhatMakesNoUseOfNodesDecidesAlikeOnEveryHierarchy)
{
    const std::vector<ItemBounds> items = test::random_boxes(60, 1);
    for (const AlgorithmInfo& info : algorithms()) {
        if (!info.hierarchies.empty() || info.needs.visible_set) {
            continue;
        }
        std::vector<ItemId> expected;
        for (const HierarchyKind& kind : hierarchy_kinds()) {
            const Hierarchy tree = kind.build(items, 0);
            const auto culler = std::move(make_culler(info.name, tree).value());
            ScriptedDevice device;
            culler->cull(test::look_ahead(), device);
            std::vector<ItemId> drawn(culler->drawn_items().begin(), culler->drawn_items().end());
            std::sort(drawn.begin(), drawn.end());
            expected = expected.empty() ? drawn : expected;
            EXPECT_EQ(drawn, expected) << info.name << " on " << kind.name;
        }
    }
}

TEST(Registry, AClockIsAskedOnlyByOptionsThatCountInTime)
{
    const Hierarchy tree = test::row_tree(2);
    int asked = 0;
    const auto cull = [&](const char* name, std::vector<OptionValue> options) {
        const auto clock = [&asked] {
            ++asked;
            return 0.0;
        };
        const auto culler = std::move(make_culler(name, tree, options, clock).value());
        ScriptedDevice device;
        culler->cull(test::look_ahead(), device);
        return std::exchange(asked, 0);
    };
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.name != "adaptive") { // it measures time by it
            EXPECT_EQ(cull(info.name.c_str(), {}), 0) << info.name;
        }
    }
    EXPECT_GT(cull("prioritized", {{"budget_time", "5"}}), 0);
    EXPECT_GT(cull("statistical", {{"time", "clock"}}), 0);
    EXPECT_GT(cull("adaptive", {}), 0);
    EXPECT_EQ(cull("adaptive", {{"measure", "false"}}), 0);
}

TEST(Registry, AnOptionChangesWhatTheCullerDoes)
{
    const Hierarchy tree = test::row_tree(2);
    const OptionValue threshold{"threshold", "50"};
    auto culler = std::move(make_culler("chc_plus_plus", tree, {&threshold, 1}).value());
    ScriptedDevice device({.boxes = [](auto) { return uint64_t{50}; }});
    EXPECT_EQ(to_string(culler->cull(test::look_ahead(), device).guarantee), "approximate(50)");
    EXPECT_TRUE(culler->drawn_items().empty());
}

TEST(Registry, MistakesAreNamedWithWhatWouldWork)
{
    const Hierarchy tree = test::row_tree(1);
    const auto message = [&](const char* algorithm, OptionValue value) {
        const auto culler = make_culler(algorithm, tree, {&value, 1});
        return culler ? std::string{} : culler.error().message;
    };
    EXPECT_EQ(
        make_culler("chcpp", tree)
            .error()
            .message.find("there is no algorithm 'chcpp'; there are frustum, stop_and_wait, chc"),
        0u);
    EXPECT_EQ(
        message("chc", {"jitter", "on"}),
        "chc: there is no option 'jitter'; it has visible_test, assume_visible_frames, threshold");
    EXPECT_EQ(message("frustum", {"x", "1"}), "frustum: there is no option 'x'; it has none");
    EXPECT_EQ(message("chc", {"visible_test", "sphere"}),
              "chc: option 'visible_test' cannot be 'sphere': give one of box geometry");
    EXPECT_EQ(message("chc_plus_plus", {"jitter", "maybe"}),
              "chc_plus_plus: option 'jitter' cannot be 'maybe': give true or false");
    for (const char* bad : {"-1", "3.5", "99999999999999", "", "4x"}) {
        EXPECT_NE(message("chc_plus_plus", {"batch_size", bad}).find("a whole number from 1 to"),
                  std::string::npos)
            << bad;
    }
}

TEST(DecisionLog, ItemsOfAHiddenNodeAreHidden)
{
    const Hierarchy tree = test::row_tree(2);
    DecisionLog log;
    log.add(NodeId{2u}, Decision::hidden);
    log.add(NodeId{3u}, Decision::drawn);
    const std::vector<Decision> expected{Decision::drawn, Decision::undecided, Decision::hidden,
                                         Decision::hidden};
    EXPECT_EQ(log.by_item(tree), expected);
}

TEST(DecisionLog, ADecisionMaySpeakOfANodesOwnItemsOrOfOneItemAlone)
{
    const Hierarchy tree = test::row_tree(2);
    DecisionLog log;
    log.add(NodeId{1u}, Decision::drawn,
            DecisionLog::Scope::own_items); // the node has no items of its own
    log.add(NodeId{2u}, ItemId{3u}, Decision::drawn);
    const std::vector<Decision> expected{Decision::undecided, Decision::undecided,
                                         Decision::undecided, Decision::drawn};
    EXPECT_EQ(log.by_item(tree), expected);
}

TEST(DecisionLog, TheHashIgnoresOrderAndGroupingButNotTheDecision)
{
    const Hierarchy tree = test::row_tree(2);
    DecisionLog a;
    a.add(NodeId{2u}, Decision::hidden);
    a.add(NodeId{3u}, Decision::drawn);
    DecisionLog b;
    b.add(NodeId{3u}, Decision::drawn_revealed);
    b.add(NodeId{5u}, Decision::hidden_group);
    b.add(NodeId{6u}, Decision::hidden);
    EXPECT_EQ(a.hash(tree, 7), b.hash(tree, 7));
    EXPECT_NE(a.hash(tree, 7), a.hash(tree, 8));
    DecisionLog c;
    c.add(NodeId{2u}, Decision::hidden);
    c.add(NodeId{3u}, Decision::hidden);
    EXPECT_NE(a.hash(tree, 7), c.hash(tree, 7));
}

} // namespace
} // namespace occlude
