#include <occlude/cull/chc_plus_plus.h>

#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude {

ChcPlusPlus::ChcPlusPlus(HierarchyRef hierarchy, ChcPlusPlusOptions options)
    : Culler(hierarchy)
    , options_(clamped(options))
{
}

void ChcPlusPlus::reset_state()
{
    states_.clear();
    keep_table_.clear();
    distance_queue_.clear();
    query_queue_.clear();
    i_queue_.clear();
    v_queue_.clear();
    batcher_.clear();
}

bool ChcPlusPlus::is_leaf(NodeId node) const
{
    return options_.virtual_leaves ? hierarchy().is_leaf(node)
                                   : hierarchy().node(node).child_count == 0;
}

void ChcPlusPlus::pull_up_visibility(NodeId node)
{
    while (node.valid() && !states_[node.value].visible) {
        states_[node.value].visible = true;
        node = hierarchy().node(node).parent;
    }
}

void ChcPlusPlus::traverse_node(CullFrame& frame, NodeId node, Decision decision)
{
    const PlaneMask mask = states_[node.value].mask;
    if (is_leaf(node)) {
        frame.draw_leaf(node, mask, decision);
    } else {
        frame.draw_own(node, mask, decision);
        distance_queue_.push_children(hierarchy(), frame.view(), node, mask);
    }
    if (!options_.render_queue) {
        frame.flush_draws();
    }
}

// Figure 8.4.4: the first test of a node that turned visible comes after 1 to n_av frames, at
// random. Otherwise nodes that turn visible together would be tested together in all later frames.
uint32_t ChcPlusPlus::first_test_after(uint32_t stamp, NodeId node) const
{
    const uint32_t n_av = options_.assume_visible_frames;
    const uint64_t random = hash64(options_.seed, node.value, stamp);
    return stamp + (options_.jitter ? 1 + uniform_below(random, n_av) : n_av);
}

// --- issuing tests -------------------------------------------------------------------------------

// The boxes of one node, for the batcher.
auto ChcPlusPlus::add_boxes(CullFrame& frame)
{
    return [this, &frame](uint32_t member, TestBatch& batch) {
        const NodeId node{member};
        for (const NodeId part : tight_bounds_.collect(
                 hierarchy(), node, options_.tight_bounds_depth, options_.tight_bounds_area)) {
            batch.add_box(frame.test_box(part), node);
        }
    };
}

void ChcPlusPlus::add_test(CullFrame& frame, NodeId node)
{
    batcher_.add_test({&node.value, 1}, add_boxes(frame));
}

// IssueQuery for all added tests, with one change of state.
void ChcPlusPlus::submit(CullFrame& frame)
{
    if (frame.queued_triangles() >= options_.min_render_triangles) {
        frame.flush_draws();
    }
    for (const PendingQuery& query : batcher_.submit(frame)) {
        query_queue_.push(query);
    }
}

void ChcPlusPlus::query_previously_invisible_node(CullFrame& frame, NodeId node)
{
    i_queue_.push_back(node);
    if (i_queue_.size() >= options_.batch_size) {
        issue_multiqueries(frame);
    }
}

double ChcPlusPlus::keep_probability(NodeId node) const
{
    const uint32_t frames_hidden = states_[node.value].frames_hidden;
    return options_.multiqueries == ChcPlusPlusOptions::Multiqueries::measured
               ? keep_table_.keep_probability(frames_hidden)
               : analytic_keep_probability(frames_hidden);
}

void ChcPlusPlus::issue_multiqueries(CullFrame& frame)
{
    if (i_queue_.empty()) {
        return;
    }
    if (options_.multiqueries == ChcPlusPlusOptions::Multiqueries::off) {
        for (const NodeId node : i_queue_) {
            add_test(frame, node);
        }
    } else {
        candidates_.clear();
        for (const NodeId node : i_queue_) {
            const auto order = static_cast<uint32_t>(candidates_.size());
            candidates_.push_back({node.value, keep_probability(node), order});
        }
        batcher_.add_groups(candidates_, candidates_.size(), add_boxes(frame),
                            [](const PendingQuery&) {});
    }
    i_queue_.clear();
    submit(frame);
}

void ChcPlusPlus::issue_visible(CullFrame& frame, size_t count)
{
    count = std::min(count, v_queue_.size());
    if (count == 0) {
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        add_test(frame, v_queue_.pop());
    }
    submit(frame);
}

// --- handling results ----------------------------------------------------------------------------

void ChcPlusPlus::handle_node(CullFrame& frame, NodeId node, bool visible, Decision if_hidden)
{
    NodeState& state = states_[node.value];
    if (!state.was_visible) {
        keep_table_.record(state.frames_hidden, !visible);
    }
    if (visible) {
        if (state.was_visible) {
            state.next_test = frame.stamp() + options_.assume_visible_frames;
        } else {
            state.next_test = first_test_after(frame.stamp(), node);
            traverse_node(frame, node, Decision::drawn_revealed);
        }
        state.frames_hidden = 0;
        pull_up_visibility(node);
    } else if (state.was_visible) {
        state.frames_hidden = 0; // the node is drawn in this frame and hidden from the next one on
    } else {
        ++state.frames_hidden;
        frame.decide(node, if_hidden);
    }
}

void ChcPlusPlus::handle_returned_query(CullFrame& frame, const PendingQuery& query,
                                        const Answer& answer)
{
    const bool visible = is_visible(answer, options_.threshold);
    if (visible && query.count > 1) {
        batcher_.split(frame, query, [&](const PendingQuery& node_alone) {
            batcher_.add_part(node_alone, add_boxes(frame));
        });
        submit(frame);
        return;
    }
    const Decision if_hidden = query.count > 1 ? Decision::hidden_group : Decision::hidden;
    for (const uint32_t member : batcher_.members(query)) {
        handle_node(frame, NodeId{member}, visible, if_hidden);
    }
}

void ChcPlusPlus::handle_results(CullFrame& frame)
{
    while (!query_queue_.empty()) {
        const PendingQuery query = query_queue_.front();
        Answer answer = frame.poll(query.ticket);
        if (answer.state == AnswerState::pending) {
            if (!distance_queue_.empty()) {
                return; // Goes on traversing. Draining the queue here would make this stop-and-wait
                        // per batch.
            }
            if (!v_queue_.empty()) {
                issue_visible(frame, options_.v_fill);
                continue;
            }
            answer = frame.wait(query.ticket);
        }
        query_queue_.pop();
        handle_returned_query(frame, query, answer);
    }
}

// --- the main loop -------------------------------------------------------------------------------

void ChcPlusPlus::visit_node(CullFrame& frame, DistanceQueue::Entry entry)
{
    const NodeId node = entry.node;
    if (!frame.visit(node, entry.mask)) {
        return; // last_visited stays: on re-entry the node is not "visible before" (R8)
    }
    NodeState& state = states_[node.value];
    const bool known = state.last_visited + 1 == frame.stamp();
    state.was_visible = state.visible && known;
    state.frames_hidden = known ? state.frames_hidden : 0;
    state.visible = false;
    state.last_visited = frame.stamp();
    state.mask = entry.mask;

    if (frame.near(node)) {
        pull_up_visibility(node);
        state.next_test = first_test_after(frame.stamp(), node);
        traverse_node(frame, node, Decision::drawn_near);
    } else if (!state.was_visible) {
        query_previously_invisible_node(frame, node);
    } else if (!is_leaf(node)) {
        traverse_node(frame, node, Decision::drawn);
    } else if (!query_reasonable(frame, node)) {
        pull_up_visibility(node);
        traverse_node(frame, node, Decision::drawn);
    } else {
        v_queue_.push(node);
        if (!options_.v_queue) {
            issue_visible(frame, 1);
        }
        traverse_node(frame, node, Decision::drawn_tested);
    }
}

bool ChcPlusPlus::query_reasonable(const CullFrame& frame, NodeId node) const
{
    return frame.stamp() >= states_[node.value].next_test;
}

void ChcPlusPlus::cull_frame(CullFrame& frame)
{
    states_.resize(hierarchy().nodes().size());
    batcher_.clear();
    if (options_.depth_only_pass) {
        frame.use_depth_only_pass();
    }
    distance_queue_.push(hierarchy().root(), 0.0f, Frustum::kAllPlanes);

    while (!distance_queue_.empty() || !i_queue_.empty() || !query_queue_.empty()) {
        handle_results(frame);
        if (!distance_queue_.empty()) {
            visit_node(frame, distance_queue_.pop());
        }
        if (distance_queue_.empty()) {
            issue_multiqueries(frame); // nothing is left to traverse
        }
    }

    // Everything visible is known. The rest of the v-queue is one batch. Its results must be read
    // in this frame, because the next frame classifies nodes by them.
    frame.flush_draws();
    issue_visible(frame, v_queue_.size());
    handle_results(frame);
}

} // namespace occlude
