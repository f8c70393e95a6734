// Invariant I4: all ancestors of a visible node are visible.
#include <occlude/cull/chc.h>
#include <occlude/cull/chc_plus_plus.h>

#include "support/culler_probe.h"
#include "support/trees.h"
#include "support/visibility_script.h"

#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

template <class C>
void expect_visible_nodes_have_visible_ancestors(C& culler, const Hierarchy& tree)
{
    for (uint32_t i = 1; i < tree.nodes().size(); ++i) {
        if (CullerProbe::visible(culler, NodeId{i})) {
            ASSERT_TRUE(CullerProbe::visible(culler, tree.node(NodeId{i}).parent)) << "node " << i;
        }
    }
}

TEST(PullUp, EveryAncestorOfAVisibleNodeIsVisible)
{
    const Hierarchy tree = test::random_bvh(600, 22);
    uint64_t frame = 0;
    ScriptedDevice device({.boxes = test::consistent_visibility(tree, 6, frame, 0.2f)});
    Chc chc{tree};
    ChcPlusPlus chc_plus_plus{tree};
    const View view = test::look({0, 0, 110}, {0, 0, 0});
    for (; frame < 20; ++frame) {
        chc.cull(view, device);
        chc_plus_plus.cull(view, device);
        expect_visible_nodes_have_visible_ancestors(chc, tree);
        expect_visible_nodes_have_visible_ancestors(chc_plus_plus, tree);
    }
    EXPECT_TRUE(CullerProbe::visible(chc, tree.root()));
    EXPECT_TRUE(CullerProbe::visible(chc_plus_plus, tree.root()));
}

} // namespace
} // namespace occlude
