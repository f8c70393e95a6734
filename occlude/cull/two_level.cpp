#include <occlude/cull/two_level.h>

#include <occlude/core/assert.h>
#include <occlude/core/rng.h>

#include <algorithm>
#include <bit>

namespace occlude {

static bool overlap(const PixelRect& a, const PixelRect& b)
{
    return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
           b.y < a.y + a.height;
}

TwoLevel::TwoLevel(HierarchyRef hierarchy, TwoLevelCullOptions options)
    : Culler(hierarchy)
    , options_(clamped(options))
{
}

void TwoLevel::reset_state()
{
    states_.clear();
    keep_table_.clear();
    lineage_ = hierarchy().object_nodes().lineage;
    start_frame();
}

// Relinking an object changes node ids, but not keys.
void TwoLevel::structure_changed()
{
    const uint64_t lineage = hierarchy().object_nodes().lineage;
    if (lineage == 0 || lineage != lineage_) {
        reset();
    }
}

// --- Algorithm 2: rendering of a frame -----------------------------------------------------------

// The paper finishes answered queries first in each round. In the first round there are none.
void TwoLevel::cull_frame(CullFrame& frame)
{
    const ObjectNodes& info = hierarchy().object_nodes();
    states_.resize(info.empty() ? hierarchy().nodes().size() : info.key_count);
    spaces_.start_frame(hierarchy());
    start_frame();
    insert(frame, hierarchy().root(), NodeId{}, Frustum::kAllPlanes);
    do {
        finish_queries(frame);
        process_active_nodes(frame);
    } while (issue_queries(frame));
}

void TwoLevel::start_frame()
{
    active_.clear();
    fresh_.clear();
    waiting_.clear();
    deferred_.clear();
    parts_.clear();
    pending_.clear();
    batcher_.clear();
}

// First loop: the answered queries. Everything that can be done without an answer is done, so it
// waits for the first query if none is answered; mostly that brings the answers of its whole batch.
void TwoLevel::finish_queries(CullFrame& frame)
{
    if (pending_.empty() || finish_answered_queries(frame)) {
        return;
    }
    const Query query = pending_.front();
    pending_.erase(pending_.begin());
    finish_query(frame, query, frame.wait(query.ticket));
    finish_answered_queries(frame);
}

// False if no query is answered.
bool TwoLevel::finish_answered_queries(CullFrame& frame)
{
    const size_t before = pending_.size();
    size_t left = 0;
    for (size_t i = 0; i < before; ++i) {
        const Query query = pending_[i];
        const Answer answer = frame.poll(query.ticket);
        if (answer.state == AnswerState::pending) {
            pending_[left++] = query;
        } else {
            finish_query(frame, query, answer);
        }
    }
    pending_.resize(left);
    return left < before;
}

void TwoLevel::finish_query(CullFrame& frame, const Query& query, const Answer& answer)
{
    const bool visible = is_visible(answer, options_.threshold);
    if (query.count > 1 && visible) {
        batcher_.split(frame, query, [this](const Query& part) {
            if (part.count == 1) {
                waiting_.push_back(batcher_.members(part).front());
            } else {
                parts_.push_back(part);
            }
        });
        return;
    }
    const Decision if_hidden = query.count > 1 ? Decision::hidden_group : Decision::hidden;
    for (const uint32_t at : batcher_.members(query)) {
        handle_result(frame, at, visible, if_hidden);
    }
}

void TwoLevel::handle_result(CullFrame& frame, uint32_t at, bool visible, Decision if_hidden)
{
    const NodeId node = active_[at].node;
    NodeState& state = state_of(node);
    if (!state.visible) {
        keep_table_.record(state.frames_hidden, !visible);
    }
    state.visible = visible;
    state.history = (state.history << 1) | (visible ? 1u : 0u);
    if (visible) {
        const uint32_t postponed = postponement(state, key_of(node), frame.stamp());
        state.next_test = frame.stamp() + 1 + postponed;
        state.frames_hidden = 0;
        process_visible_node(frame, at, Decision::drawn_revealed);
    } else {
        ++state.frames_hidden;
        frame.decide(node, if_hidden);
    }
}

// Second loop: as many nodes as possible at once, near to far.
void TwoLevel::process_active_nodes(CullFrame& frame)
{
    const auto farther = [this](uint32_t a, uint32_t b) { return is_nearer(b, a); };
    while (!fresh_.empty()) {
        std::pop_heap(fresh_.begin(), fresh_.end(), farther);
        const uint32_t at = fresh_.back();
        fresh_.pop_back();
        Decision decision = Decision::drawn;
        switch (first_visibility_test(frame, active_[at], decision)) {
        case VisibilityResult::invisible:
            break;
        case VisibilityResult::visible:
            process_visible_node(frame, at, decision);
            break;
        case VisibilityResult::need_query:
            if (options_.multiqueries && state_of(active_[at].node).frames_hidden > 0) {
                deferred_.push_back({at});
            } else {
                waiting_.push_back(at);
            }
            break;
        }
    }
}

// "Issue query", for the nodes that need one. Nodes that stayed hidden are tested last, after all
// others are decided. Returns false if no query is pending then: the list of active nodes is empty.
bool TwoLevel::issue_queries(CullFrame& frame)
{
    issue_disjoint(frame);
    if (pending_.empty() && !parts_.empty()) {
        issue_parts(frame);
    }
    if (pending_.empty() && !deferred_.empty()) {
        issue_groups(frame);
    }
    return !pending_.empty();
}

// The box of one active node, for the batcher.
auto TwoLevel::add_boxes() const
{
    return [this](uint32_t at, TestBatch& batch) {
        const auto& [box, world_from_box] = active_[at].test;
        if (world_from_box != nullptr) {
            batch.add_box(box, *world_from_box, active_[at].node);
        } else {
            batch.add_box(box, active_[at].node);
        }
    };
}

// Tests nodes whose boxes do not overlap on the screen, the nearer first.
void TwoLevel::issue_disjoint(CullFrame& frame)
{
    std::sort(waiting_.begin(), waiting_.end(),
              [this](uint32_t a, uint32_t b) { return is_nearer(a, b); });
    size_t left = 0;
    for (const uint32_t at : waiting_) {
        const bool full = pending_.size() >= pending_limit(frame); // maximum queries reached
        if (full || overlaps_pending(active_[at])) {
            waiting_[left++] = at;
        } else {
            pending_.push_back(batcher_.add_test({&at, 1}, add_boxes()));
        }
    }
    waiting_.resize(left);
    submit(frame);
}

// Tests the parts of groups in which something is visible.
void TwoLevel::issue_parts(CullFrame& frame)
{
    while (!parts_.empty() && pending_.size() < pending_limit(frame)) {
        const Query part = parts_.back();
        parts_.pop_back();
        pending_.push_back(batcher_.add_part(part, add_boxes()));
    }
    submit(frame);
}

// Tests groups of nodes that are likely to stay hidden together.
void TwoLevel::issue_groups(CullFrame& frame)
{
    using Candidate = MultiqueryBatcher::Candidate;
    std::sort(deferred_.begin(), deferred_.end(), [this](const Candidate& a, const Candidate& b) {
        return is_nearer(a.member, b.member);
    });
    for (uint32_t i = 0; i < deferred_.size(); ++i) {
        const uint32_t frames_hidden = state_of(active_[deferred_[i].member].node).frames_hidden;
        deferred_[i].keep = keep_table_.keep_probability(frames_hidden);
        deferred_[i].order = i;
    }
    const size_t most = pending_limit(frame) - pending_.size();
    const size_t tested = batcher_.add_groups(
        deferred_, most, add_boxes(), [this](const Query& query) { pending_.push_back(query); });
    deferred_.erase(deferred_.begin(), deferred_.begin() + static_cast<std::ptrdiff_t>(tested));
    submit(frame);
}

bool TwoLevel::overlaps_pending(const Active& active) const
{
    if (!options_.disjoint) {
        return false;
    }
    return std::any_of(pending_.begin(), pending_.end(), [&](const Query& query) {
        return std::ranges::any_of(batcher_.members(query), [&](uint32_t at) {
            return overlap(active.screen.rect, active_[at].screen.rect);
        });
    });
}

size_t TwoLevel::pending_limit(const CullFrame& frame) const
{
    return std::max<size_t>(std::min(options_.max_pending, frame.caps().max_outstanding), 1);
}

void TwoLevel::submit(CullFrame& frame)
{
    if (batcher_.empty()) {
        return;
    }
    frame.flush_draws();
    const std::span<const Query> issued = batcher_.submit(frame);
    OCCLUDE_ASSERT(issued.size() <= pending_.size(), "every added test is pending");
    std::copy(issued.begin(), issued.end(),
              pending_.end() - static_cast<std::ptrdiff_t>(issued.size()));
}

// --- Algorithm 3: FirstVisibilityTest ------------------------------------------------------------

TwoLevel::VisibilityResult TwoLevel::first_visibility_test(CullFrame& frame, Active& active,
                                                           Decision& if_visible)
{
    if (frustum_culled(frame, active)) {
        return VisibilityResult::invisible;
    }
    NodeState& state = recall(frame, active.node);
    if (viewer_inside(frame, active)) {
        if_visible = Decision::drawn_near;
        const uint32_t postponed_to = was_invisible_last_time(state) ? 0 : state.next_test;
        state.next_test = std::max(postponed_to, frame.stamp() + 1);
        state.visible = true;
        state.frames_hidden = 0;
        return VisibilityResult::visible;
    }
    if (!was_invisible_last_time(state) && examine_recent_query_results(frame, state)) {
        if_visible = Decision::drawn;
        return VisibilityResult::visible;
    }
    if (options_.disjoint) {
        active.screen = spaces_.project(frame.view(), hierarchy(), active.node);
    }
    return VisibilityResult::need_query;
}

bool TwoLevel::frustum_culled(CullFrame& frame, Active& active) const
{
    return !frame.visit(active.node, active.mask);
}

// Marks a node in the frustum as visited, and returns its memory. Nodes outside keep their
// last_visited, so that they are unknown when they come back (rule R8).
TwoLevel::NodeState& TwoLevel::recall(const CullFrame& frame, NodeId node)
{
    NodeState& state = state_of(node);
    const bool known = state.last_visited + 1 == frame.stamp();
    state.last_visited = frame.stamp();
    if (!known) {
        state.history = 0;
        state.frames_hidden = 0;
        state.visible = false;
    }
    return state;
}

// Rule R1. Also stores the box that a test of the node uses.
bool TwoLevel::viewer_inside(CullFrame& frame, Active& active)
{
    active.test = spaces_.test_box(frame.view(), hierarchy(), active.node);
    const glm::mat4* map = active.test.world_from_box;
    return frame.view().touches_near(map != nullptr ? transformed(*map, active.test.box)
                                                    : active.test.box);
}

// True if the node counts as visible without a test: by Figure 3, or because a child is visible.
bool TwoLevel::examine_recent_query_results(const CullFrame& frame, const NodeState& state) const
{
    const bool child_seen = options_.pull_up && state.child_seen + 1 == frame.stamp();
    return child_seen || frame.stamp() < state.next_test;
}

// Figure 3: for how many frames a node that was just found visible is drawn without a test.
uint32_t TwoLevel::postponement(const NodeState& state, uint32_t key, uint32_t stamp) const
{
    const uint32_t remembered = state.history << (32u - options_.history_length);
    const auto visible = static_cast<uint32_t>(std::popcount(remembered));
    const auto frames = static_cast<uint32_t>(std::min<uint64_t>(
        uint64_t{options_.frames_per_visible} * visible, options_.max_postponed));
    const uint64_t random = hash64(options_.seed, key, stamp);
    return options_.spread ? frames - uniform_below(random, frames / 2 + 1) : frames;
}

// --- Algorithm 4: ProcessVisibleNode -------------------------------------------------------------

void TwoLevel::process_visible_node(CullFrame& frame, uint32_t at, Decision decision)
{
    const NodeId node = active_[at].node;
    const NodeId parent = active_[at].parent;
    const PlaneMask mask = active_[at].mask;
    if (parent.valid()) {
        state_of(parent).child_seen = frame.stamp();
    }
    if (hierarchy().is_leaf(node)) {
        frame.draw_leaf(node, mask, decision);
        return;
    }
    frame.draw_own(node, mask, decision); // the objects without trees
    const Node& n = hierarchy().node(node);
    for (uint32_t i = 0; i < n.child_count; ++i) { // child nodes, and the objects with trees
        insert(frame, NodeId{n.first_child.value + i}, node, mask);
    }
}

void TwoLevel::insert(CullFrame& frame, NodeId node, NodeId parent, PlaneMask mask)
{
    Active& active = active_.emplace_back();
    active.node = node;
    active.parent = parent;
    active.mask = mask;
    active.distance = frame.view().distance_key(hierarchy().node(node).box);
    fresh_.push_back(static_cast<uint32_t>(active_.size() - 1));
    std::push_heap(fresh_.begin(), fresh_.end(),
                   [this](uint32_t a, uint32_t b) { return is_nearer(b, a); });
}

bool TwoLevel::is_nearer(uint32_t a, uint32_t b) const
{
    const Active& one = active_[a];
    const Active& other = active_[b];
    return one.distance != other.distance ? one.distance < other.distance : one.node < other.node;
}

uint32_t TwoLevel::key_of(NodeId node) const
{
    const ObjectNodes& info = hierarchy().object_nodes();
    return info.empty() ? node.value : info.key[node.value];
}

} // namespace occlude
