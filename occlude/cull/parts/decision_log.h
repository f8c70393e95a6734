// The decisions of a culler about each part of the tree in one frame, and their reasons: for
// pictures, for error messages, and for hashes that prove that two runs made the same decisions.
#pragma once

#include <occlude/core/ids.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace occlude {

enum class Decision : uint8_t {
    undecided,      ///< no decision: above a decided node, or not reached
    outside,        ///< outside the frustum
    hidden,         ///< a test of its own found no sample
    hidden_group,   ///< a test of several nodes found no sample
    drawn,          ///< drawn without a test (known visible, or the algorithm does not test)
    drawn_near,     ///< drawn because the near plane may touch its box
    drawn_tested,   ///< drawn, and tested for later frames
    drawn_revealed, ///< drawn because a test of this frame found samples
};

std::string_view to_string(Decision decision);

/// True for the decisions that put the node's items into the image.
constexpr bool is_drawn(Decision decision)
{
    return decision >= Decision::drawn;
}

/// Combines the hash of a walk with the hash of one more frame (DecisionLog::hash). Frames come in
/// their order, beginning with 0.
uint64_t walk_hash(uint64_t walk_so_far, uint64_t next_frame);

class DecisionLog {
public:
    /// The part of a node that a decision is about.
    enum class Scope : uint8_t {
        subtree,   ///< all items of the node and of its subtree
        own_items, ///< the own items of an inner node
        one_item,  ///< the item that the entry names
    };
    struct Entry {
        NodeId node;
        Decision decision;
        Scope scope = Scope::subtree;
        ItemId item = {}; ///< with Scope::one_item
    };

    void clear() { entries_.clear(); }
    void add(NodeId node, Decision decision, Scope scope = Scope::subtree)
    {
        entries_.push_back({node, decision, scope, {}});
    }
    void add(NodeId owner, ItemId item, Decision decision)
    {
        entries_.push_back({owner, decision, Scope::one_item, item});
    }

    /// The decisions, in the order in which they were made.
    std::span<const Entry> entries() const { return entries_; }

    /// One decision per item, indexed by ItemId. O(items).
    std::vector<Decision> by_item(const Hierarchy& hierarchy) const;

    /// A hash of (frame, drawn / hidden / outside, item). It does not depend on the order of
    /// decisions, because latency reorders them within a frame.
    uint64_t hash(const Hierarchy& hierarchy, uint64_t frame) const;

private:
    std::vector<Entry> entries_;
};

} // namespace occlude
