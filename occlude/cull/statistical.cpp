#include <occlude/cull/statistical.h>

#include <occlude/core/rng.h>
#include <occlude/cull/parts/near_to_far.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace occlude {

void Statistical::reset_state()
{
    statistics_.clear();
    queue_.clear();
    query_queue_.clear();
    batch_.clear();
    batch_places_.clear();
}

double Statistical::pause(NodeId node, uint32_t visible_results) const
{
    const double not_query_time =
        double{options_.base_time} * (2.0 - std::exp2(-static_cast<double>(visible_results)));
    const double side = 2.0 * double{uniform01(hash64(options_.seed, node.value))} - 1.0;
    return not_query_time * (1.0 + double{options_.spread} * side);
}

void Statistical::save_statistics(NodeId node, bool visible)
{
    Statistics& s = statistics_[node.value];
    s.visible_bits = (s.visible_bits << 1) | (visible ? 1u : 0u);
    s.results = std::min(s.results + 1, 64u);
    s.last_time = now_;
}

Statistical::Action Statistical::calc_node_action(CullFrame& frame, NodeList::Entry& entry,
                                                  Decision& decision)
{
    if (!frame.visit(entry.node, entry.mask)) {
        return Action::skip;
    }
    decision = Decision::drawn_near;
    if (frame.near(entry.node)) {
        return Action::render;
    }
    decision = Decision::drawn;
    Statistics& s = statistics_[entry.node.value];
    const double age = now_ - s.last_time;
    if (age > double{options_.max_age} * double{options_.base_time}) {
        s = {}; // too old
    }
    const bool last_visible = s.results > 0 && (s.visible_bits & 1) != 0;
    if (!last_visible) {
        return Action::query;
    }
    const uint32_t kept = std::clamp(options_.history, 1u, 64u);
    const uint64_t counted = s.visible_bits & (~uint64_t{0} >> (64 - kept));
    const auto visible_results = static_cast<uint32_t>(std::popcount(counted));
    return age < pause(entry.node, visible_results) ? Action::render : Action::query;
}

NodeList::Position Statistical::render_node(CullFrame& frame, NodeList::Position place,
                                            Decision decision)
{
    const auto [node, mask] = std::pair{queue_[place].node, queue_[place].mask};
    NodeList::Position first = queue_.erase(place);
    if (hierarchy().is_leaf(node)) {
        frame.draw_leaf(node, mask, decision);
        return first;
    }
    frame.draw_own(node, mask, decision);
    push_far_to_near(hierarchy(), frame.view(), node, children_, [&, planes = mask](NodeId child) {
        first = queue_.insert_before(first, child, planes);
    });
    return first;
}

void Statistical::issue(CullFrame& frame, NodeList::Position place)
{
    NodeList::Entry& entry = queue_[place];
    entry.pending = true;
    if (options_.issue == StatisticalOptions::Issue::at_place) {
        frame.flush_draws();
        query_queue_.push({frame.query(entry.node), place});
        return;
    }
    batch_.add_box(frame.test_box(entry.node), entry.node);
    batch_.end_test();
    batch_places_.push_back(place);
}

void Statistical::submit_batch(CullFrame& frame)
{
    if (batch_.empty()) {
        return;
    }
    frame.flush_draws();
    frame.query(batch_, tickets_);
    for (size_t i = 0; i < tickets_.size(); ++i) {
        query_queue_.push({tickets_[i], batch_places_[i]});
    }
    batch_.clear();
    batch_places_.clear();
}

void Statistical::move_pointer(CullFrame& frame)
{
    const size_t most =
        std::clamp(options_.max_in_flight, 1u, std::max(frame.caps().max_outstanding, 1u));
    const auto in_flight = [&] { return query_queue_.size() + batch_.test_count(); };
    NodeList::Position pointer = queue_.begin();
    while (pointer != queue_.end() && in_flight() < most) {
        if (queue_[pointer].pending) {
            pointer = queue_.next(pointer);
            continue;
        }
        Decision decision = Decision::undecided;
        switch (calc_node_action(frame, queue_[pointer], decision)) {
        case Action::skip:
            pointer = queue_.erase(pointer);
            break;
        case Action::render:
            pointer = render_node(frame, pointer, decision);
            break;
        case Action::query:
            issue(frame, pointer);
            pointer = queue_.next(pointer);
            break;
        }
    }
    submit_batch(frame);
}

void Statistical::handle_results(CullFrame& frame)
{
    bool must_have = true;
    while (!query_queue_.empty()) {
        const PendingQuery query = query_queue_.front();
        Answer answer = frame.poll(query.ticket);
        if (answer.state == AnswerState::pending) {
            if (!must_have) {
                return;
            }
            answer = frame.wait(query.ticket);
        }
        query_queue_.pop();
        must_have = options_.results == StatisticalOptions::Results::all;
        const NodeId node = queue_[query.place].node;
        const bool visible = is_visible(answer, options_.threshold);
        if (answer.state == AnswerState::ready) {
            save_statistics(node, visible);
        }
        if (visible) {
            render_node(frame, query.place, Decision::drawn_revealed);
        } else {
            frame.decide(node, Decision::hidden);
            queue_.erase(query.place);
        }
    }
}

void Statistical::cull_frame(CullFrame& frame)
{
    statistics_.resize(hierarchy().nodes().size());
    now_ = clock_ ? clock_()
                  : static_cast<double>(frame.stamp() - 1) / double{options_.frames_per_second};
    queue_.clear();
    queue_.insert_before(queue_.end(), hierarchy().root(), Frustum::kAllPlanes);
    while (!queue_.empty()) {
        move_pointer(frame);
        handle_results(frame);
    }
}

} // namespace occlude
