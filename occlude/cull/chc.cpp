#include <occlude/cull/chc.h>

#include <occlude/cull/parts/cull_frame.h>

namespace occlude {

void Chc::reset_state()
{
    states_.clear();
    distance_queue_.clear();
    query_queue_.clear();
}

void Chc::pull_up_visibility(NodeId node)
{
    while (node.valid() && !states_[node.value].visible) {
        states_[node.value].visible = true;
        node = hierarchy().node(node).parent;
    }
}

void Chc::traverse_node(CullFrame& frame, NodeId node, PlaneMask mask, Decision decision)
{
    if (hierarchy().is_leaf(node)) {
        frame.draw_leaf(node, mask, decision);
        frame.flush_draws();
        return;
    }
    frame.draw_own(node, mask, decision);
    frame.flush_draws();
    distance_queue_.push_children(hierarchy(), frame.view(), node, mask);
}

void Chc::query_node(CullFrame& frame, NodeId node, PlaneMask mask)
{
    query_queue_.push({frame.query(node), node, mask});
}

void Chc::handle_returned_query(CullFrame& frame, const PendingQuery& query, const Answer& answer)
{
    NodeState& state = states_[query.node.value];
    if (!is_visible(answer, options_.threshold)) {
        if (!state.was_visible) {
            frame.decide(query.node, Decision::hidden);
        }
        return;
    }
    if (!state.was_visible) {
        traverse_node(frame, query.node, query.mask, Decision::drawn_revealed);
    }
    state.next_test = frame.stamp() + 1 + options_.assume_visible_frames;
    pull_up_visibility(query.node);
}

void Chc::visit_node(CullFrame& frame, DistanceQueue::Entry entry)
{
    const NodeId node = entry.node;
    if (!frame.visit(node, entry.mask)) {
        return; // last_visited stays: on re-entry the node is not "visible before" (R8)
    }
    NodeState& state = states_[node.value];
    state.was_visible = state.visible && state.last_visited + 1 == frame.stamp();
    state.visible = false;
    state.last_visited = frame.stamp();

    if (frame.near(node)) {
        pull_up_visibility(node);
        traverse_node(frame, node, entry.mask, Decision::drawn_near);
    } else if (!state.was_visible) {
        query_node(frame, node, entry.mask);
    } else if (!hierarchy().is_leaf(node)) {
        traverse_node(frame, node, entry.mask, Decision::drawn);
    } else if (frame.stamp() < state.next_test) {
        pull_up_visibility(node);
        traverse_node(frame, node, entry.mask, Decision::drawn);
    } else if (options_.visible_test == ChcOptions::VisibleTest::geometry &&
               frame.can_draw_and_query(node)) {
        const Ticket ticket = frame.draw_and_query(node, entry.mask, Decision::drawn_tested);
        query_queue_.push({ticket, node, entry.mask});
    } else {
        query_node(frame, node, entry.mask);
        traverse_node(frame, node, entry.mask, Decision::drawn_tested);
    }
}

// Waits for the next result only if nothing is left to traverse.
void Chc::handle_finished_queries(CullFrame& frame)
{
    while (!query_queue_.empty()) {
        const PendingQuery query = query_queue_.front();
        const Answer answer =
            distance_queue_.empty() ? frame.wait(query.ticket) : frame.poll(query.ticket);
        if (answer.state == AnswerState::pending) {
            return;
        }
        query_queue_.pop();
        handle_returned_query(frame, query, answer);
    }
}

void Chc::cull_frame(CullFrame& frame)
{
    states_.resize(hierarchy().nodes().size());
    const NodeId root = hierarchy().root();
    distance_queue_.push(root, 0.0f, Frustum::kAllPlanes);

    while (!distance_queue_.empty() || !query_queue_.empty()) {
        handle_finished_queries(frame);
        if (!distance_queue_.empty()) {
            visit_node(frame, distance_queue_.pop());
        }
    }
}

} // namespace occlude
