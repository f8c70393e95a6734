// A cut through the tree, kept from frame to frame: where the last traversal stopped, so that the
// next one starts there instead of at the root. Its size follows the visible boundary, not the
// number of objects.
//
//            root                   Entries are the nodes at which a frame stopped:
//           /    \                    V  a leaf that is drawn            (visible)
//         a        H                  H  a subtree that was found hidden (hidden)
//        / \                          O  a subtree outside the frustum   (outside)
//       V    b                        ?  not known yet                   (unknown)
//           /|\                     ... and, where a node was opened, its own items one by one (i).
//          H O i                    Every item lies below exactly one entry or is one.
#pragma once

#include <occlude/hierarchy/hierarchy.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

namespace occlude {

class HierarchyCut {
public:
    enum class State : uint8_t { unknown, hidden, visible, outside };

    struct Entry {
        NodeId node;
        ItemPosition place = {};    ///< of one of the node's own items; invalid: the node with
                                    ///< everything below it
        uint32_t tested = 0;        ///< stamp of the last test; 0: never
        uint16_t frames_hidden = 0; ///< frames for which tests have found nothing
        State state = State::unknown;

        bool is_item() const { return place.valid(); }
    };

    /// Forgets everything: one unknown entry, the root. Precondition: the tree is not empty.
    void reset(const Hierarchy& hierarchy);
    bool empty() const { return entries_.empty(); }
    void clear();

    /// The entries that the last frame left, in no particular order.
    std::span<const Entry> entries() const { return entries_; }

    /// Adds an entry to the next cut. All added entries together must cover the tree.
    void keep(const Entry& entry) { next_.push_back(entry); }

    /// Forgets the entries added since the last finish().
    void drop_kept() { next_.clear(); }

    /// Ends a frame: the kept entries become the cut. An opened node below which all entries are
    /// hidden or outside may be merged into one entry. The merge is tried if `chosen(node, state)`
    /// is true for the states of all of them, and `replacement` takes their place if `merged(node,
    /// all_outside, replacement)` is true. Merges one level per frame. O(entries log entries).
    template <class Chosen, class Merged>
    void finish(const Hierarchy& hierarchy, Chosen&& chosen, Merged&& merged);

    /// For loops over entries: prefetches the node or item of an entry a few places after `i`. In
    /// large scenes they are not in the cache, and many prefetches can be under way at once.
    static void fetch_ahead(const Hierarchy& hierarchy, std::span<const Entry> entries, size_t i);

private:
    /// An entry that is hidden or outside; its siblings may be so, too.
    struct Quiet {
        NodeId parent;
        Entry entry;
    };

    // The node that the entry was opened from.
    static NodeId opened_from(const Hierarchy& hierarchy, const Entry& entry)
    {
        return entry.is_item() ? entry.node : hierarchy.node(entry.node).parent;
    }
    static bool quiet(const Entry& entry)
    {
        return entry.state == State::hidden || entry.state == State::outside;
    }

    std::vector<Entry> entries_;
    std::vector<Entry> next_;
    std::vector<Quiet> quiet_; ///< scratch
};

inline void HierarchyCut::fetch_ahead([[maybe_unused]] const Hierarchy& hierarchy,
                                      [[maybe_unused]] std::span<const Entry> entries,
                                      [[maybe_unused]] size_t i)
{
#ifdef __GNUC__
    constexpr size_t kAhead = 8;
    if (i + kAhead < entries.size()) {
        const Entry& entry = entries[i + kAhead];
        const Node* node = &hierarchy.node(entry.node);
        const ItemBounds* item = entry.is_item() ? &hierarchy.item_bounds(entry.place) : nullptr;
        const char* first =
            item ? reinterpret_cast<const char*>(item) : reinterpret_cast<const char*>(node);
        __builtin_prefetch(first);
        __builtin_prefetch(first + (item ? sizeof *item : sizeof *node) - 1); // the next line
    }
#endif
}

template <class Chosen, class Merged>
void HierarchyCut::finish(const Hierarchy& hierarchy, Chosen&& chosen, Merged&& merged)
{
    entries_.clear();
    quiet_.clear();
    for (size_t i = 0; i < next_.size(); ++i) {
        fetch_ahead(hierarchy, next_, i);
        const Entry& entry = next_[i];
        const NodeId parent = quiet(entry) ? opened_from(hierarchy, entry) : NodeId{};
        if (parent.valid() && chosen(parent, entry.state)) {
            quiet_.push_back({parent, entry});
        } else {
            entries_.push_back(entry);
        }
    }
    next_.clear();
    std::sort(quiet_.begin(), quiet_.end(), [](const Quiet& a, const Quiet& b) {
        return std::tie(a.parent, a.entry.node, a.entry.place) <
               std::tie(b.parent, b.entry.node, b.entry.place);
    });
    for (size_t first = 0, end = 0; first < quiet_.size(); first = end) {
        const NodeId parent = quiet_[first].parent;
        uint32_t outside = 0;
        for (; end < quiet_.size() && quiet_[end].parent == parent; ++end) {
            outside += quiet_[end].entry.state == State::outside ? 1 : 0;
        }
        const Node& node = hierarchy.node(parent);
        const uint32_t parts = node.child_count + node.own_items;
        Entry replacement = quiet_[first].entry;
        replacement.node = parent;
        replacement.place = ItemPosition{};
        if (end - first == parts && merged(parent, outside == parts, replacement)) {
            entries_.push_back(replacement);
            continue;
        }
        for (size_t i = first; i < end; ++i) {
            entries_.push_back(quiet_[i].entry);
        }
    }
}

} // namespace occlude
