#include "session/contenders.h"

#include "support/trees.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude::tools {

namespace {

// Every contender of a pairing as "name/kind".
std::vector<std::string> pairs(const std::string& algorithms, const std::string& hierarchies)
{
    const auto contenders = choose_contenders(algorithms, {}, {}, References::if_asked);
    const auto trees = choose_hierarchies(hierarchies, {});
    std::vector<std::string> names;
    for (const Contender& contender :
         pair_with_hierarchies(*contenders, *trees, algorithms, hierarchies).contenders) {
        names.push_back(contender.name + "/" + contender.hierarchy);
    }
    return names;
}

using Names = std::vector<std::string>;

} // namespace

TEST(PairWithHierarchies, EveryAlgorithmMeetsEveryKindInTheOrderOfTheList)
{
    EXPECT_EQ(pairs("frustum,chc", "octree,bvh,octree"),
              (Names{"frustum/octree", "frustum/bvh", "chc/octree", "chc/bvh"}));
    EXPECT_EQ(pairs("chc", "all"),
              (Names{"chc/bvh", "chc/bsp", "chc/octree", "chc/grid", "chc/two_level"}));
}

TEST(PairWithHierarchies, WhatMakesNoUseOfNodesRunsOnceOnTheFirst)
{
    EXPECT_EQ(pairs("uniform_grid,ideal", "grid,bvh"), (Names{"uniform_grid/grid", "ideal/grid"}));
}

TEST(PairWithHierarchies, WhatDoesNotSuitIsLeftOutWithANoteUnlessBothWereNamed)
{
    EXPECT_EQ(pairs("batch_and_wait", "all"),
              (Names{"batch_and_wait/bvh", "batch_and_wait/octree", "batch_and_wait/grid"}));
    EXPECT_EQ(pairs("batch_and_wait", "bsp"), (Names{"batch_and_wait/bsp"}));
    const Names all = pairs("all", "bsp");
    EXPECT_EQ(std::count(all.begin(), all.end(), "batch_and_wait/bsp"), 0);
    EXPECT_EQ(std::count(all.begin(), all.end(), "chc/bsp"), 1);

    const auto contenders = choose_contenders("exact", {}, {}, References::if_asked);
    const auto trees = choose_hierarchies("bvh,bsp,two_level", {});
    const auto notes =
        pair_with_hierarchies(*contenders, *trees, "exact", "bvh,bsp,two_level").notes;
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0].rfind("batch_and_wait is left out on bsp, two_level: ", 0), 0u) << notes[0];
}

TEST(PairWithHierarchies, TreesOfOneKindWithOtherOptionsAreOthers)
{
    EXPECT_EQ(pairs("chc", "bvh,bvh:leaf_triangles=400"),
              (Names{"chc/bvh", "chc/bvh:leaf_triangles=400"}));
    const Names all = pairs("all", "bsp:split=median");
    EXPECT_EQ(std::count(all.begin(), all.end(), "batch_and_wait/bsp:split=median"), 0);
    EXPECT_EQ(std::count(all.begin(), all.end(), "chc/bsp:split=median"), 1);
}

TEST(ChooseHierarchies, OptionsOfAnEntryComeAfterThoseOfItsKind)
{
    const std::vector<std::string> sets{"bvh.leaf_triangles=7"};
    const auto trees = choose_hierarchies("bvh,bvh:leaf_triangles=400:max_leaf_items=2", sets);
    ASSERT_TRUE(trees) << trees.error().message;
    ASSERT_EQ(trees->size(), 2u);
    using Options = std::vector<OptionValue>;
    EXPECT_EQ((*trees)[0].options, (Options{{"leaf_triangles", "7"}}));
    EXPECT_EQ((*trees)[1].kind, "bvh");
    EXPECT_EQ(
        (*trees)[1].options,
        (Options{{"leaf_triangles", "7"}, {"leaf_triangles", "400"}, {"max_leaf_items", "2"}}));
}

TEST(ChooseHierarchies, WhatIsWrongIsNamedWithWhatThereIs)
{
    const auto expect_error = [](std::string_view text, std::initializer_list<const char*> words) {
        const auto trees = choose_hierarchies(text, {});
        ASSERT_FALSE(trees) << text;
        for (const char* word : words) {
            EXPECT_NE(trees.error().message.find(word), std::string::npos) << trees.error().message;
        }
    };
    expect_error("bvh,heap", {"'heap'", "octree"});
    expect_error("bvh:leaf_triangles", {"'bvh:leaf_triangles'", "HIERARCHY:OPTION=VALUE"});
    expect_error("bsp:splat=1", {"--hierarchy bsp:splat=1", "'splat'", "max_leaf_items"});
}

TEST(ChooseContenders, OneAlgorithmTakesPartSeveralTimesWithOptionsOfItsOwn)
{
    const std::vector<std::string> sets{"chc.threshold=1"};
    const auto contenders = choose_contenders(
        "chc:threshold=9:visible_test=geometry,frustum,chc,chc", sets, {}, References::if_asked);
    ASSERT_TRUE(contenders) << contenders.error().message;
    Names names;
    for (const Contender& contender : *contenders) {
        names.push_back(contender.name);
    }
    EXPECT_EQ(names, (Names{"frustum", "chc:threshold=9:visible_test=geometry", "chc"}));
    const Hierarchy tree = occlude::test::row_tree(1);
    const auto promise = [&](size_t i) {
        ScriptedDevice device;
        const auto culler = (*contenders)[i].make(tree);
        return to_string((*culler)->cull(occlude::test::look_ahead(), device).guarantee);
    };
    EXPECT_EQ(promise(1), "approximate(9)") << "its own option, after that of --set";
    EXPECT_EQ(promise(2), "approximate(1)");
    EXPECT_EQ(pairs("chc:threshold=2,chc", "bvh"), (Names{"chc:threshold=2/bvh", "chc/bvh"}));

    const auto wrong = choose_contenders("chc:threshold", {}, {}, References::if_asked);
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message.find("ALGORITHM:OPTION=VALUE"), std::string::npos);
    const auto unknown = choose_contenders("magic:x=1", {}, {}, References::if_asked);
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("'magic'"), std::string::npos);
}

TEST(ChooseContenders, TheTimeBudgetIsMillisecondsOfTheGivenClock)
{
    const Hierarchy tree = occlude::test::row_tree(3); // 8 items of 100 triangles
    ScriptedDevice device;
    int asked = 0;
    const SecondsClock clock = [&] { // every item takes 10 ms
        ++asked;
        return 0.01 * static_cast<double>(device.items_drawn_this_frame().size());
    };
    device.begin_frame(occlude::test::look_ahead()); // so that the clock starts at an empty frame
    device.end_frame();
    const auto triangles = [&](std::vector<std::string> sets) {
        sets.emplace_back("prioritized.cell_triangles=100");
        sets.emplace_back("prioritized.chunk_triangles=100");
        const auto contenders =
            choose_contenders("prioritized", sets, {}, References::if_asked, clock);
        const auto culler = contenders->front().make(tree);
        return (*culler)->cull(occlude::test::look_ahead(), device).counters.triangles_drawn;
    };
    EXPECT_EQ(triangles({"prioritized.budget_triangles=0"}), 800u);
    EXPECT_EQ(asked, 0) << "without a time budget nobody looks at the clock";
    device.begin_frame(occlude::test::look_ahead());
    device.end_frame();
    const uint64_t in_time =
        triangles({"prioritized.budget_triangles=0", "prioritized.budget_time=30"});
    EXPECT_GE(in_time, 300u);
    EXPECT_LE(in_time, 400u);
    EXPECT_GT(asked, 2);
}

} // namespace occlude::tools
