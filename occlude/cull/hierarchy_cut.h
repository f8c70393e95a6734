// A cut through the tree, kept from frame to frame: where the last traversal stopped, so that the
// next one starts there instead of at the root. Its size follows the visible boundary, not the
// number of objects.
//
//            root                   Entries are the nodes at which a frame stopped:
//           /    \                    V  a leaf that is drawn            (visible)
//         a        H                  H  a subtree that was found hidden (hidden)
//        / \                          O  a subtree outside the frustum   (outside)
//       V    b                        ?  not known yet                   (unknown)
//           / \                     Every item lies below exactly one entry. Opened nodes (root, a,
//          H    O                   b) are no entries, unless they have items of their own.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

class HierarchyCut {
public:
    enum class State : uint8_t { unknown, hidden, visible, outside };
    enum class Scope : uint8_t {
        subtree,   ///< the node with all that is below it
        own_items, ///< the items of an opened node itself
    };
    struct Entry {
        NodeId node;
        uint32_t tested = 0;        ///< stamp of the last test; 0: never
        uint16_t frames_hidden = 0; ///< frames for which tests have found nothing
        State state = State::unknown;
        Scope scope = Scope::subtree;
    };

    /// Forgets everything: one unknown entry, the root. Precondition: the tree is not empty.
    void reset(const Hierarchy& hierarchy);
    bool empty() const { return entries_.empty(); }
    void clear();

    /// The entries that the last frame left, in no particular order.
    std::span<const Entry> entries() const { return entries_; }

    /// Adds an entry of the cut that this frame leaves. Together they must cover the tree again.
    void keep(const Entry& entry) { next_.push_back(entry); }

    /// Ends a frame: the kept entries become the cut. Where all entries below a node are hidden or
    /// outside, `merged(node, all_outside, replacement)` may answer true, and `replacement` takes their
    /// place. One level per frame; O(entries).
    template <class Merged>
    void finish(const Hierarchy& hierarchy, Merged&& merged);

private:
    // The node that the entry was opened from.
    static NodeId opened_from(const Hierarchy& hierarchy, const Entry& entry)
    {
        return entry.scope == Scope::own_items ? entry.node : hierarchy.node(entry.node).parent;
    }
    static bool quiet(const Entry& entry)
    {
        return entry.state == State::hidden || entry.state == State::outside;
    }
    // What is counted below an opened node: quiet entries, and in the high half those outside.
    static constexpr uint32_t kOutside = 1u << 16;
    static constexpr uint32_t kMerged = 0xffffffffu;

    static uint32_t entries_below(const Node& node)
    {
        return node.child_count + (node.own_items > 0 ? 1 : 0);
    }

    std::vector<Entry> entries_;
    std::vector<Entry> next_;
    std::vector<uint32_t> quiet_below_; ///< per node; all 0 between frames
};

template <class Merged>
void HierarchyCut::finish(const Hierarchy& hierarchy, Merged&& merged)
{
    for (const Entry& entry : next_) {
        const NodeId parent = opened_from(hierarchy, entry);
        // Wider nodes than the counter holds stay open.
        if (quiet(entry) && parent.valid() && entries_below(hierarchy.node(parent)) < kOutside) {
            quiet_below_[parent.value] += entry.state == State::outside ? 1 + kOutside : 1;
        }
    }
    entries_.clear();
    for (const Entry& entry : next_) {
        const NodeId parent = opened_from(hierarchy, entry);
        if (!quiet(entry) || !parent.valid()) {
            entries_.push_back(entry);
            continue;
        }
        uint32_t& count = quiet_below_[parent.value];
        const uint32_t all = entries_below(hierarchy.node(parent));
        if (count == kMerged) {
            continue; // its replacement is in the cut
        }
        Entry replacement{parent, entry.tested, entry.frames_hidden, entry.state};
        if (count % kOutside == all && merged(parent, count / kOutside == all, replacement)) {
            count = kMerged;
            entries_.push_back(replacement);
        } else {
            count = 0; // asked once: the others stay as well
            entries_.push_back(entry);
        }
    }
    for (const Entry& entry : next_) {
        const NodeId parent = opened_from(hierarchy, entry);
        if (parent.valid()) {
            quiet_below_[parent.value] = 0;
        }
    }
    next_.clear();
}

} // namespace occlude
