// Why an object is drawn, or is not: from the decisions and tests of the last frames.
#pragma once

#include "viewer/pane.h"

#include <occlude/hierarchy/hierarchy.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace occlude::tools::viewer {

/// A node above an item, and what was decided of it in the last frame.
struct ChainLink {
    NodeId node;
    int depth = 0; ///< 0: the root
    uint32_t items = 0;
    uint32_t triangles = 0;
    std::optional<Decision> decision = {}; ///< none: nobody decided here
};

/// The last test that covered the item.
struct LastTest {
    uint64_t frames_ago = 0;
    NodeId node;                       ///< whose box was tested: the item's leaf or a node above it
    std::vector<NodeId> partners = {}; ///< the other nodes in the same test
    TestMethod method = TestMethod::automatic;
    AnswerState state = AnswerState::pending;
    uint64_t samples = 0;
};

struct ItemExplanation {
    ItemId item;
    Decision decision = Decision::undecided;
    std::string rule = {};                  ///< a sentence: which rule decided
    NodeId decided_at = {};                 ///< invalid: nobody decided
    std::vector<ChainLink> chain = {};      ///< from the root to the leaf
    std::optional<LastTest> last_test = {}; ///< of the frames that are remembered
    std::vector<Decision> recent = {};      ///< of the last frames, the newest last
};

/// The node that has `item` among its own items, below virtual leaves too, or an invalid id.
/// O(items).
NodeId leaf_of(const Hierarchy& hierarchy, ItemId item);

/// What became of `item` in the last frame of `pane`, and since when. Precondition: pane.culler().
ItemExplanation explain(const Pane& pane, ItemId item);

/// The rule behind a decision, as a sentence about `it`.
std::string rule_of(Decision decision, DecisionLog::Scope scope, bool own_node);

/// How many pixels of an object each other object covers.
struct Occluder {
    uint32_t instance = 0;
    uint64_t pixels = 0;
};
struct Coverage {
    uint64_t pixels = 0;             ///< that the object would have if nothing else was there
    uint64_t visible_pixels = 0;     ///< that it has
    std::vector<Occluder> occluders; ///< most pixels first
};

/// From two id buffers of the same view: of the object's items alone, and of all that is drawn.
/// `instance_of` is indexed by ItemId.
Coverage coverage(std::span<const uint32_t> alone, std::span<const uint32_t> all,
                  std::span<const uint32_t> instance_of, uint32_t instance);

} // namespace occlude::tools::viewer
