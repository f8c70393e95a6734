#include <occlude/cull/parts/hierarchy_cut.h>

#include "support/trees.h"

#include <gtest/gtest.h>

#include <set>

namespace occlude {
namespace {

using State = HierarchyCut::State;

HierarchyCut::Entry entry(uint32_t node, State state)
{
    HierarchyCut::Entry e{NodeId{node}};
    e.state = state;
    return e;
}

const auto every = [](NodeId, State) { return true; };

std::set<uint32_t> nodes_of(const HierarchyCut& cut)
{
    std::set<uint32_t> nodes;
    for (const HierarchyCut::Entry& e : cut.entries()) {
        nodes.insert(e.node.value);
    }
    return nodes;
}

// 0 (1 (3 4) 2 (5 6))
TEST(HierarchyCut, StartsAtTheRoot)
{
    HierarchyCut cut;
    EXPECT_TRUE(cut.empty());
    cut.reset(test::row_tree(2));
    EXPECT_EQ(nodes_of(cut), (std::set<uint32_t>{0}));
    EXPECT_EQ(cut.entries()[0].state, State::unknown);
}

TEST(HierarchyCut, SiblingsThatAreAllHiddenOrOutsideMayBecomeTheirParent)
{
    const Hierarchy tree = test::row_tree(2);
    HierarchyCut cut;
    cut.reset(tree);
    cut.keep(entry(3, State::visible));
    cut.keep(entry(6, State::hidden));
    cut.keep(entry(4, State::hidden));
    cut.keep(entry(5, State::outside));
    int asked = 0;
    cut.finish(tree, every, [&](NodeId node, bool all_outside, HierarchyCut::Entry& replacement) {
        ++asked;
        EXPECT_EQ(node, NodeId{2u}); // node 1 has a visible child
        EXPECT_FALSE(all_outside);
        replacement.state = State::hidden;
        return true;
    });
    EXPECT_EQ(asked, 1);
    EXPECT_EQ(nodes_of(cut), (std::set<uint32_t>{2, 3, 4}));
}

TEST(HierarchyCut, WhatIsNotMergedStays)
{
    const Hierarchy tree = test::row_tree(2);
    HierarchyCut cut;
    cut.reset(tree);
    for (int frame = 0; frame < 2; ++frame) {
        cut.keep(entry(1, State::visible));
        cut.keep(entry(5, State::outside));
        cut.keep(entry(6, State::outside));
        bool all = false;
        cut.finish(tree, every, [&](NodeId, bool all_outside, HierarchyCut::Entry&) {
            all = all_outside;
            return false;
        });
        EXPECT_TRUE(all);
        EXPECT_EQ(nodes_of(cut), (std::set<uint32_t>{1, 5, 6}));
        EXPECT_EQ(cut.entries().size(), 3u);
    }
}

TEST(HierarchyCut, TheOwnItemsOfANodeCountAmongItsParts)
{
    // Node 0 has an item of its own and two leaves.
    std::vector<Node> nodes(3);
    nodes[0].first_child = NodeId{1u};
    nodes[0].child_count = 2;
    nodes[0].own_items = 1;
    nodes[1].first_item = 1;
    nodes[1].own_items = 1;
    nodes[2].first_item = 2;
    nodes[2].own_items = 1;
    const ItemBounds box{{glm::vec3{0.0f}, glm::vec3{1.0f}}, 10};
    const Hierarchy tree = Hierarchy::from_arrays(
        std::move(nodes), {ItemId{0u}, ItemId{1u}, ItemId{2u}}, {box, box, box});
    HierarchyCut cut;
    cut.reset(tree);
    cut.keep(entry(1, State::hidden));
    cut.keep(entry(2, State::hidden));
    HierarchyCut::Entry own = entry(0, State::visible);
    own.place = ItemPosition{0u};
    cut.keep(own);
    const auto merge_all = [](NodeId, bool, HierarchyCut::Entry&) { return true; };
    cut.finish(tree, every, merge_all);
    EXPECT_EQ(cut.entries().size(), 3u); // the own item is still seen
    for (HierarchyCut::Entry e : std::vector(cut.entries().begin(), cut.entries().end())) {
        e.state = State::hidden;
        cut.keep(e);
    }
    cut.finish(tree, every, merge_all);
    ASSERT_EQ(cut.entries().size(), 1u);
    EXPECT_FALSE(cut.entries()[0].is_item());
}

// Nodes outside may be chosen more often than hidden ones. A node with parts of both kinds waits
// for the rarer choice.
TEST(HierarchyCut, NodesAreAskedIfTheStatesOfAllPartsAreChosen)
{
    const Hierarchy tree = test::row_tree(2);
    HierarchyCut cut;
    cut.reset(tree);
    cut.keep(entry(3, State::outside));
    cut.keep(entry(4, State::outside));
    cut.keep(entry(5, State::outside));
    cut.keep(entry(6, State::hidden));
    cut.finish(
        tree, [](NodeId, State state) { return state == State::outside; },
        [](NodeId, bool all_outside, HierarchyCut::Entry&) {
            EXPECT_TRUE(all_outside);
            return true;
        });
    EXPECT_EQ(nodes_of(cut), (std::set<uint32_t>{1, 5, 6}));
}

TEST(HierarchyCut, OnlyChosenNodesAreAsked)
{
    const Hierarchy tree = test::row_tree(2);
    HierarchyCut cut;
    cut.reset(tree);
    for (uint32_t node = 3; node < 7; ++node) {
        cut.keep(entry(node, State::hidden));
    }
    cut.finish(
        tree, [](NodeId node, State) { return node == NodeId{1u}; },
        [](NodeId, bool, HierarchyCut::Entry&) { return true; });
    EXPECT_EQ(nodes_of(cut), (std::set<uint32_t>{1, 5, 6}));
}

TEST(HierarchyCut, ManyNodesCloseAtOnce)
{
    const Hierarchy tree = test::row_tree(8); // 256 leaves
    HierarchyCut cut;
    cut.reset(tree);
    for (uint32_t node = 255; node < 511; ++node) {
        cut.keep(entry(node, node == 300 ? State::visible : State::hidden));
    }
    const auto merge_all = [](NodeId, bool, HierarchyCut::Entry&) { return true; };
    cut.finish(tree, every, merge_all);
    EXPECT_EQ(cut.entries().size(), 127u + 2u);
}

} // namespace
} // namespace occlude
