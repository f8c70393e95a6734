#include <occlude/cull/parts/cut_traversal.h>

#include <algorithm>

namespace occlude {

void CutTraversal::forget()
{
    clear();
    hidden_share = {};
}

// --- entries -------------------------------------------------------------------------------------

double CutTraversal::units_of(const Entry& entry) const
{
    if (entry.is_item()) {
        return units(hierarchy_.item_bounds(entry.place).triangles, 1);
    }
    const Node& node = hierarchy_.node(entry.node);
    return units(node.subtree_triangles, node.subtree_items);
}

bool CutTraversal::opens(const Entry& entry) const
{
    if (entry.is_item()) {
        return false;
    }
    const Node& node = hierarchy_.node(entry.node);
    const bool has_parts = prices_.stop_at_virtual_leaves
                               ? !hierarchy_.is_leaf(entry.node)
                               : node.child_count > 0 || node.own_items > 1;
    return has_parts && draw_us(entry) >= prices_.min_open_us;
}

bool CutTraversal::visit(CullFrame& frame, CutCandidate& candidate) const
{
    const Entry& entry = candidate.entry;
    return entry.is_item() ? frame.visit_item(entry.node, entry.place, candidate.mask)
                           : frame.visit(entry.node, candidate.mask);
}

void CutTraversal::draw(CullFrame& frame, const CutCandidate& candidate, Decision decision) const
{
    const Entry& entry = candidate.entry;
    if (all_drawn_) {
        return;
    }
    if (entry.is_item()) {
        frame.draw_item(entry.node, entry.place, candidate.mask, decision);
    } else {
        frame.draw_leaf(entry.node, candidate.mask, decision);
    }
}

void CutTraversal::add_parts(const CullFrame& frame, const CutCandidate& candidate,
                             std::vector<CutCandidate>& out)
{
    const Node& node = hierarchy_.node(candidate.entry.node);
    parts_.clear();
    for (uint32_t i = 0; i < node.child_count; ++i) {
        const NodeId child{node.first_child.value + i};
        parts_.push_back(
            {frame.view().distance_key(hierarchy_.node(child).box), child, ItemPosition{}});
    }
    for (uint32_t i = 0; i < node.own_items; ++i) {
        const ItemPosition place{node.first_item + i};
        parts_.push_back({frame.view().distance_key(hierarchy_.item_bounds(place).box),
                          candidate.entry.node, place});
    }
    std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) {
        return a.distance != b.distance ? a.distance > b.distance
               : a.node != b.node       ? a.node > b.node
                                        : a.place > b.place;
    });
    for (const Part& part : parts_) {
        out.push_back({Entry{part.node, part.place}, candidate.mask, part.distance});
    }
}

void CutTraversal::keep(Entry& entry, State state)
{
    entry.state = state;
    entry.frames_hidden = 0;
    cut_.keep(entry);
}

void CutTraversal::keep_hidden(CullFrame& frame, Entry entry, Decision decision)
{
    constexpr int kMaxFrames = 0xffff; // the largest count that the entry holds
    entry.frames_hidden = static_cast<uint16_t>(std::min(entry.frames_hidden + 1, kMaxFrames));
    entry.state = State::hidden;
    entry.tested = frame.stamp();
    hidden_units_ += units_of(entry);
    cut_.keep(entry);
    if (all_drawn_) {
        return; // tests after drawing decide nothing
    }
    if (entry.is_item()) {
        frame.decide_item(entry.node, entry.place, decision);
    } else {
        frame.decide(entry.node, decision);
    }
}

void CutTraversal::keep_drawn_in_vain(const CullFrame& frame, Entry entry)
{
    entry.tested = frame.stamp();
    wasted_units_ += units_of(entry);
    keep(entry, State::hidden);
}

void CutTraversal::keep_unknown(Entry entry)
{
    entry.state = State::unknown;
    cut_.keep(entry);
}

// --- one frame, in order -------------------------------------------------------------------------

void CutTraversal::start_frame()
{
    cut_.drop_kept();
    drawn_.clear();
    candidates_.clear();
    all_drawn_ = false;
    hidden_units_ = 0.0;
    wasted_units_ = 0.0;
}

void CutTraversal::sort_out(CullFrame& frame, std::span<const uint64_t> turned_hidden)
{
    if (cut_.empty()) {
        cut_.reset(hierarchy_);
    }
    const std::span<const Entry> entries = cut_.entries();
    for (size_t i = 0; i < entries.size(); ++i) {
        HierarchyCut::fetch_ahead(hierarchy_, entries, i);
        CutCandidate candidate{entries[i]};
        Entry& entry = candidate.entry;
        const bool was_visible = entry.state == State::visible;
        if (!visit(frame, candidate)) {
            keep_outside(entry);
        } else if (was_visible && !std::binary_search(turned_hidden.begin(), turned_hidden.end(),
                                                      name_of(entry))) {
            // By the middle of the box: the nearest point of a large box, or of one around the eye,
            // says nothing about the order.
            const glm::vec3 middle = box_of(entry).center();
            candidate.distance = frame.view().distance_key({middle, middle});
            drawn_.push_back(candidate);
        } else {
            entry.state = was_visible ? State::hidden : entry.state;
            candidates_.push_back(candidate);
        }
    }
}

void CutTraversal::draw_visible(CullFrame& frame)
{
    order_.clear();
    for (uint32_t i = 0; i < drawn_.size(); ++i) {
        order_.emplace_back(drawn_[i].distance, i);
    }
    std::sort(order_.begin(), order_.end());
    by_distance_.clear();
    for (const auto& [distance, i] : order_) {
        by_distance_.push_back(drawn_[i]);
    }
    drawn_.swap(by_distance_);
    for (const CutCandidate& candidate : drawn_) {
        draw(frame, candidate, Decision::drawn_tested);
    }
}

bool CutTraversal::is_tried(uint64_t turn, NodeId node, State state)
{
    constexpr uint32_t kNodesPerTrial = 48;
    constexpr uint32_t kTried = 3;
    constexpr uint32_t kTriedOutside = 16;
    return uniform_below(mix64(turn ^ node.value), kNodesPerTrial) <
           (state == State::outside ? kTriedOutside : kTried);
}

void CutTraversal::finish_without_merging()
{
    cut_.finish(
        hierarchy_, [](NodeId, State) { return false; },
        [](NodeId, bool, Entry&) { return false; });
}

} // namespace occlude
