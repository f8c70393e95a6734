#include <occlude/cull/next_frame.h>

#include <algorithm>
#include <utility>

namespace occlude {

NextFrame::NextFrame(HierarchyRef hierarchy, NextFrameOptions options)
    : Culler(hierarchy)
    , options_(clamped(options))
    , tests_(options_.tests)
{
}

Guarantee NextFrame::guarantee() const
{
    uint32_t frames = options_.read == NextFrameOptions::Read::wait ? 1 : options_.max_latency;
    if (options_.hysteresis == NextFrameOptions::Hysteresis::hide) {
        frames += options_.hold_frames;
    }
    Guarantee guarantee = Guarantee::latent(frames);
    if (options_.threshold > 0) {
        guarantee.kind = Guarantee::Kind::approximate;
        guarantee.threshold = options_.threshold;
    }
    return guarantee;
}

uint64_t NextFrame::visible_samples(NodeId object) const
{
    return object.value < states_.size() ? states_[object.value].samples : Answer::kUnknownSamples;
}

void NextFrame::reset_state()
{
    pending_.clear();
    states_.clear();
}

void NextFrame::handle_result(NodeId object, const Answer& answer, uint32_t stamp)
{
    using Hysteresis = NextFrameOptions::Hysteresis;
    ObjectState& state = states_[object.value];
    const TestedBy test = std::exchange(state.pending, TestedBy::nothing);
    state.samples = answer.samples;
    if (state.issued < state.valid_from) {
        return; // it was out of sight, or was drawn untested, in the meantime
    }
    const bool visible = is_visible(answer, options_.threshold);
    if (test == TestedBy::geometry) {
        const bool drawn_in_vain = !visible && state.revealed_by_box;
        state.visible = visible;
        state.revealed_by_box = drawn_in_vain;
        if (drawn_in_vain && options_.hysteresis == Hysteresis::draw) {
            state.visible = true;
            state.test_by_box = true;
        } else if (drawn_in_vain && options_.hysteresis == Hysteresis::hide) {
            state.hidden_until = stamp + options_.hold_frames;
        }
    } else if (!visible) {
        state.visible = false;
        state.revealed_by_box = false;
        state.test_by_box = false;
        state.hidden_until = 0;
    } else if (!state.visible && stamp >= state.hidden_until) {
        state.visible = true;
        state.revealed_by_box = true;
    }
}

void NextFrame::collect_results(CullFrame& frame)
{
    const uint32_t stamp = frame.stamp();
    still_pending_.clear();
    for (const NodeId object : pending_) {
        const ObjectState& state = states_[object.value];
        const bool waits = options_.read == NextFrameOptions::Read::wait ||
                           stamp - state.issued >= options_.max_latency;
        const Answer answer = waits ? frame.wait(state.ticket) : frame.poll(state.ticket);
        if (answer.state == AnswerState::pending) {
            still_pending_.push_back(object);
        } else {
            handle_result(object, answer, stamp);
        }
    }
    std::swap(pending_, still_pending_);
}

void NextFrame::remember(NodeId object, Ticket ticket, TestedBy test, uint32_t stamp)
{
    ObjectState& state = states_[object.value];
    state.ticket = ticket;
    state.pending = test;
    state.issued = stamp;
    pending_.push_back(object);
}

// Forgets the object's results: it is drawn and tested like a new one.
void NextFrame::draw_untested(CullFrame& frame, const ObjectTests::Object& object,
                              Decision decision)
{
    ObjectState& state = states_[object.node.value];
    state.visible = true;
    state.revealed_by_box = false;
    state.test_by_box = false;
    state.hidden_until = 0;
    state.valid_from = frame.stamp() + 1;
    frame.draw_leaf(object.node, object.mask, decision);
}

// "Render the object itself" in a query every k frames, and in the first frame after one in which
// only its box was found visible.
void NextFrame::draw_visible(CullFrame& frame, const ObjectTests::Object& object)
{
    const NodeId node = object.node;
    const ObjectState& state = states_[node.value];
    const bool unconfirmed = state.revealed_by_box && !state.test_by_box;
    const bool turn = (frame.stamp() + node.value) % options_.visible_interval == 0;
    const bool due = state.pending == TestedBy::nothing && (turn || unconfirmed);
    if (due && !state.test_by_box && frame.can_draw_and_query(node)) {
        const Ticket ticket = frame.draw_and_query(node, object.mask, Decision::drawn_tested);
        remember(node, ticket, TestedBy::geometry, frame.stamp());
        return;
    }
    frame.draw_leaf(node, object.mask, due ? Decision::drawn_tested : Decision::drawn);
    if (due) {
        box_tests_.push_back(node);
    }
}

void NextFrame::test_boxes(CullFrame& frame)
{
    if (box_tests_.empty()) {
        return;
    }
    frame.flush_draws();
    batch_.clear();
    for (const NodeId node : box_tests_) {
        tests_.add_test(frame, node, batch_);
    }
    frame.query(batch_, tickets_);
    for (size_t i = 0; i < box_tests_.size(); ++i) {
        remember(box_tests_[i], tickets_[i], TestedBy::box, frame.stamp());
    }
}

void NextFrame::cull_frame(CullFrame& frame)
{
    states_.resize(hierarchy().nodes().size());
    if (options_.depth_only_pass) {
        frame.use_depth_only_pass();
    }
    collect_results(frame);

    box_tests_.clear();
    for (const ObjectTests::Object& object : tests_.collect_near_to_far(frame)) {
        ObjectState& state = states_[object.node.value];
        const bool came_back = state.last_seen + 1 != frame.stamp();
        state.last_seen = frame.stamp();
        if (frame.near(object.node)) {
            draw_untested(frame, object, Decision::drawn_near);
        } else if (!tests_.worth_testing(frame, object.node)) {
            draw_untested(frame, object, Decision::drawn);
        } else if (came_back || state.visible) {
            if (came_back) {
                state = {.last_seen = state.last_seen,
                         .valid_from = frame.stamp(),
                         .issued = state.issued,
                         .ticket = state.ticket,
                         .pending = state.pending};
            }
            draw_visible(frame, object);
        } else {
            frame.decide(object.node, Decision::hidden);
            if (state.pending == TestedBy::nothing) {
                box_tests_.push_back(object.node);
            }
        }
    }
    test_boxes(frame);
}

} // namespace occlude
