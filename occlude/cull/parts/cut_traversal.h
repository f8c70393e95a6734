// One frame over a cut that is kept from frame to frame. It sorts the entries into lists and
// records the result for each. The tests (by depth: depth_traversal.h; on the device:
// adaptive/by_device.h) take candidates from here and say of each whether it is hidden.
//
//    the cut of the last frame --> in the frustum?
//                                    visible then --> drawn()       drawn at once, near to far
//                                    hidden, new  --> candidates()  to be tested
//                                    outside      --> kept
//    Every entry, or each of its parts, returns by keep_hidden(), keep_visible() or keep_outside().
//    finish() makes the cut of the next frame from them, and merges siblings none of which is
//    visible.
//
// Guarantees  The frame is exact if every entry that is not drawn went to keep_hidden() or
//             keep_outside(). A node that was visible and left the frustum is a candidate when it
//             comes back (rule R8).
// Cost        O(entries of the cut) per frame, which follows the visible boundary. There is no
//             state per node of the tree.
#pragma once

#include <occlude/core/rng.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/hierarchy_cut.h>
#include <occlude/cull/parts/share_estimate.h>
#include <occlude/cull/parts/test_prices.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace occlude {

/// An entry of the cut on its way through one frame.
struct CutCandidate {
    HierarchyCut::Entry entry;
    PlaneMask mask = Frustum::kAllPlanes;
    float distance = 0.0f;
};

class CutTraversal {
public:
    using Entry = HierarchyCut::Entry;
    using State = HierarchyCut::State;

    explicit CutTraversal(const Hierarchy& hierarchy)
        : hierarchy_(hierarchy)
    {
    }

    const Hierarchy& hierarchy() const { return hierarchy_; }
    const HierarchyCut& cut() const { return cut_; }

    /// Forgets the cut.
    void clear() { cut_.clear(); }
    /// Forgets the cut, and the share of hidden answers over frames.
    void forget();
    /// Makes the cut one unknown entry, the root.
    void restart() { cut_.reset(hierarchy_); }

    /// Sets the prices from now on.
    void set_prices(const CutPrices& prices) { prices_ = prices; }

    // --- one frame, in order ---

    /// Starts a frame. If the last frame ended half-way, because the engine's draw callback threw,
    /// the cut is that of the frame before it.
    void start_frame();

    /// Sorts the cut into entries that are outside, were visible, or must be tested.
    /// `turned_hidden` names entries (by name_of(), ascending) that were visible and were found
    /// hidden since.
    void sort_out(CullFrame& frame, std::span<const uint64_t> turned_hidden = {});

    /// Draws the entries that were visible in the last frame, near to far.
    void draw_visible(CullFrame& frame);

    /// Declares that everything is drawn: from here on, tests are for the next frame and decide
    /// nothing.
    void assume_all_drawn() { all_drawn_ = true; }

    /// Ends the frame: the kept entries become the cut. One in `kNodesPerTrial` of the nodes below
    /// which nothing is visible, chosen by a hash of `seed`, is merged into one entry if it is
    /// outside the frustum or `hides(node)`.
    template <class Hides>
    void finish(CullFrame& frame, uint64_t seed, Hides&& hides);
    /// Ends the frame without merging.
    void finish_without_merging();

    /// Entries that are drawn in this frame or stay visible: first those visible before, then
    /// revealed.
    std::vector<CutCandidate>& drawn() { return drawn_; }
    /// Entries in the frustum that are hidden or unknown, and so must be tested.
    std::vector<CutCandidate>& candidates() { return candidates_; }

    // --- entries ---

    const Aabb& box_of(const Entry& entry) const
    {
        return entry.is_item() ? hierarchy_.item_bounds(entry.place).box
                               : hierarchy_.node(entry.node).box;
    }
    uint64_t items_of(const Entry& entry) const
    {
        return entry.is_item() ? 1 : hierarchy_.node(entry.node).subtree_items;
    }
    /// The work of drawing the entry, in units.
    double units_of(const Entry& entry) const;
    double draw_us(const Entry& entry) const { return prices_.us_per_unit * units_of(entry); }
    /// The cost of drawing the queued items.
    double queued_us(const CullFrame& frame) const
    {
        return prices_.us_per_unit * units(frame.queued_triangles(), frame.queued_items());
    }
    /// False if the entry has no parts, or if it is cheaper to draw it whole.
    bool opens(const Entry& entry) const;
    static uint64_t name_of(const Entry& entry)
    {
        return uint64_t{entry.node.value} << 32 | entry.place.value;
    }

    bool visit(CullFrame& frame, CutCandidate& candidate) const;
    /// Queues the entry for drawing, unless everything is drawn already.
    void draw(CullFrame& frame, const CutCandidate& candidate, Decision decision) const;
    /// Adds the parts of an opened node, its own items and its children, the farthest first.
    void add_parts(const CullFrame& frame, const CutCandidate& candidate,
                   std::vector<CutCandidate>& out);

    /// Keeps an entry that a test of this frame found hidden before it was drawn.
    void keep_hidden(CullFrame& frame, Entry entry, Decision decision);
    /// Keeps an entry that was drawn and then found hidden: the next frame tests it first.
    void keep_drawn_in_vain(const CullFrame& frame, Entry entry);
    void keep_visible(Entry entry) { keep(entry, State::visible); }
    void keep_outside(Entry entry) { keep(entry, State::outside); }
    /// Keeps an entry of which nothing is known.
    void keep_unknown(Entry entry);

    // --- what the tests of this frame found ---

    /// The work that was not drawn because tests of this frame found it hidden.
    double hidden_units() const { return hidden_units_; }
    /// The work that was drawn and then found hidden.
    double wasted_units() const { return wasted_units_; }

    /// The share of hidden answers among first tests of an entry, averaged over frames.
    ShareEstimate hidden_share;

private:
    double units(uint64_t triangles, uint64_t items) const
    {
        return static_cast<double>(triangles) + prices_.units_per_item * static_cast<double>(items);
    }
    void keep(Entry& entry, State state);
    /// True if the merge is tried: it costs a test of the node unless all of it is outside, so that
    /// each frame tries only a few.
    static bool is_tried(uint64_t turn, NodeId node, State state);

    struct Part {
        float distance;
        NodeId node;
        ItemPosition place;
    };

    const Hierarchy& hierarchy_;
    CutPrices prices_;
    HierarchyCut cut_;
    std::vector<CutCandidate> drawn_;
    std::vector<CutCandidate> candidates_;
    bool all_drawn_ = false;
    double hidden_units_ = 0.0;
    double wasted_units_ = 0.0;
    std::vector<Part> parts_;                       ///< scratch
    std::vector<CutCandidate> by_distance_;         ///< scratch
    std::vector<std::pair<float, uint32_t>> order_; ///< scratch
};

template <class Hides>
void CutTraversal::finish(CullFrame& frame, uint64_t seed, Hides&& hides)
{
    const uint64_t turn = hash64(seed, frame.stamp());
    cut_.finish(
        hierarchy_, [&](NodeId node, State state) { return is_tried(turn, node, state); },
        [&](NodeId node, bool all_outside, Entry& replacement) {
            PlaneMask mask = Frustum::kAllPlanes;
            const bool outside = frame.view().frustum().classify(hierarchy_.node(node).box, mask) ==
                                 Containment::outside;
            replacement.state = all_outside || outside ? State::outside : State::hidden;
            return all_outside || outside ? outside : hides(node);
        });
}

} // namespace occlude
