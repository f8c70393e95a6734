#include <occlude/cull/two_phase.h>

#include <occlude/core/projection.h>
#include <occlude/cull/cull_frame.h>
#include <occlude/cull/near_to_far.h>

#include <algorithm>

namespace occlude {

bool TwoPhase::visible(NodeId node) const
{
    return node.value < draw_first_.size() && draw_first_[node.value] == next_stamp_;
}

bool TwoPhase::is_leaf(NodeId node) const
{
    return options_.virtual_leaves ? hierarchy().is_leaf(node)
                                   : hierarchy().node(node).child_count == 0;
}

// Errs toward false. Invalid bounds are those of rule R1: visible.
bool TwoPhase::hidden(const CullFrame& frame, NodeId node) const
{
    if (!depth_known_) {
        return false;
    }
    const ScreenBounds bounds = project(frame.view(), hierarchy().node(node).box);
    const auto refinement =
        options_.refine ? DepthPyramid::Refinement::pixels : DepthPyramid::Refinement::none;
    return bounds.valid && pyramid_.hides(bounds.rect, bounds.near_depth, refinement);
}

// Draws a leaf; of an inner node what is its own, and pushes its children, the nearest on top.
void TwoPhase::open(CullFrame& frame, const Entry& entry, Decision decision)
{
    opened_.push_back(entry.node);
    if (is_leaf(entry.node)) {
        frame.draw_leaf(entry.node, entry.mask, decision);
        return;
    }
    frame.draw_own(entry.node, entry.mask, decision);
    push_far_to_near(hierarchy(), frame.view(), entry.node, children_,
                     [&, planes = entry.mask](NodeId child) {
                         stack_.push_back({child, planes});
                     });
}

void TwoPhase::draw_last_visible(CullFrame& frame)
{
    boundary_.clear();
    opened_.clear();
    stack_.assign(1, {hierarchy().root(), Frustum::kAllPlanes});
    while (!stack_.empty()) {
        Entry entry = stack_.back();
        stack_.pop_back();
        if (!frame.visit(entry.node, entry.mask)) {
            continue; // its stamp stays: on re-entry the node is tested, not drawn (R8)
        }
        if (draw_first_[entry.node.value] == frame.stamp()) {
            open(frame, entry, Decision::drawn_tested);
        } else {
            boundary_.push_back(entry);
        }
    }
    opened_untested_ = opened_.size();
}

// The depth of all that is drawn so far. Nothing drawn hides nothing, and need not be read.
void TwoPhase::read_pyramid(CullFrame& frame)
{
    frame.flush_draws();
    const glm::ivec2 size = frame.view().size_px();
    if (!frame.caps().read_depth || size.x <= 0 || size.y <= 0 || opened_.empty()) {
        return;
    }
    depth_known_ = frame.read_depth({0, 0, size.x, size.y}, pyramid_.resize(size));
    if (depth_known_) {
        pyramid_.build();
    }
}

void TwoPhase::test_the_rest(CullFrame& frame)
{
    // The stack gives back near to far, and so it must get them far to near.
    stack_.assign(boundary_.rbegin(), boundary_.rend());
    size_t untouched = stack_.size(); // at the bottom: already counted and in the frustum
    while (!stack_.empty()) {
        Entry entry = stack_.back();
        stack_.pop_back();
        const bool from_boundary = stack_.size() < untouched;
        untouched = std::min(untouched, stack_.size());
        if (!from_boundary && !frame.visit(entry.node, entry.mask)) {
            continue;
        }
        if (options_.reread_triangles > 0 && frame.caps().read_depth &&
            frame.queued_triangles() >= options_.reread_triangles) {
            read_pyramid(frame);
        }
        if (hidden(frame, entry.node)) {
            frame.decide(entry.node, Decision::hidden);
        } else {
            open(frame, entry, depth_known_ ? Decision::drawn_revealed : Decision::drawn);
        }
    }
    frame.flush_draws();
}

void TwoPhase::keep_visible(CullFrame& frame)
{
    next_stamp_ = frame.stamp() + 1;
    if (options_.final_depth) {
        read_pyramid(frame);
    }
    const size_t untested = options_.final_depth ? opened_.size() : opened_untested_;
    for (size_t i = 0; i < opened_.size(); ++i) {
        const NodeId node = opened_[i];
        const NodeId parent = hierarchy().node(node).parent;
        // A hidden parent answers for its children.
        const bool known_hidden = parent.valid() && draw_first_[parent.value] != next_stamp_;
        if (!known_hidden && !(i < untested && hidden(frame, node))) {
            draw_first_[node.value] = next_stamp_;
        }
    }
}

void TwoPhase::cull_frame(CullFrame& frame)
{
    draw_first_.resize(hierarchy().nodes().size());
    depth_known_ = false;

    draw_last_visible(frame);
    read_pyramid(frame);
    test_the_rest(frame);
    keep_visible(frame);
}

} // namespace occlude
