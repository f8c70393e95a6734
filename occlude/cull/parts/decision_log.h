// The decisions of a culler for each part of the tree in one frame, and why: for pictures, for
// error messages, and for hashes that prove two runs made the same decisions.
#pragma once

#include <occlude/core/ids.h>
#include <occlude/hierarchy/hierarchy.h>

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace occlude {

enum class Decision : uint8_t {
    undecided,      ///< nobody asked: above a decided node, or not reached
    outside,        ///< outside the frustum
    hidden,         ///< a test of its own found no sample
    hidden_group,   ///< a test of several nodes found no sample
    drawn,          ///< drawn without a test (known visible, or the algorithm does not test)
    drawn_near,     ///< drawn because the near plane may touch its box
    drawn_tested,   ///< drawn, and tested for the frames to come
    drawn_revealed, ///< drawn because a test of this frame found samples
};

std::string_view to_string(Decision decision);

/// True for the decisions that put the node's items into the image.
constexpr bool is_drawn(Decision decision)
{
    return decision >= Decision::drawn;
}

/// The hash of a walk with one more frame: hashes of frames (DecisionLog::hash) are taken in their
/// order, beginning with 0.
uint64_t walk_hash(uint64_t walk_so_far, uint64_t next_frame);

class DecisionLog {
public:
    /// The part of a node that a decision speaks for.
    enum class Scope : uint8_t {
        subtree,   ///< all items of the node and below
        own_items, ///< the items of an inner node itself
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

    /// In the order they were made.
    std::span<const Entry> entries() const { return entries_; }

    /// One decision per item, indexed by ItemId. O(items).
    std::vector<Decision> by_item(const Hierarchy& hierarchy) const;

    /// A hash of (frame, drawn / hidden / outside, item), independent of the order in which
    /// decisions were made: latency moves decisions in time and must not change them.
    uint64_t hash(const Hierarchy& hierarchy, uint64_t frame) const;

private:
    std::vector<Entry> entries_;
};

} // namespace occlude
