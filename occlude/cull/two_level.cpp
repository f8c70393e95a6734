#include <occlude/cull/two_level.h>

#include <occlude/core/assert.h>
#include <occlude/core/rng.h>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

namespace occlude {

namespace {

// The margin of an inflated box is found by subtraction, which rounds; so it is taken larger.
constexpr float kMarginSlack = 1.25f;

bool overlap(const PixelRect& a, const PixelRect& b)
{
    return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
           b.y < a.y + a.height;
}

// Groups of at most so many are tested node by node if something in them is visible.
constexpr uint32_t kMostSingly = kLeastHalved - 1;

} // namespace

TwoLevel::TwoLevel(const Hierarchy& hierarchy, TwoLevelCullOptions options)
    : Culler(hierarchy)
    , options_(options)
{
    options_.max_pending = std::max(options_.max_pending, 1u);
    options_.history_length = std::clamp(options_.history_length, 1u, 32u);
}

Guarantee TwoLevel::guarantee() const
{
    return options_.threshold == 0 ? Guarantee::exact()
                                   : Guarantee::approximate(options_.threshold);
}

void TwoLevel::reset_state()
{
    states_.clear();
    object_views_.clear();
    keep_table_.clear();
    lineage_ = hierarchy().two_level().lineage;
}

// Relinked objects change node ids, but not keys.
void TwoLevel::structure_changed()
{
    const uint64_t lineage = hierarchy().two_level().lineage;
    if (lineage == 0 || lineage != lineage_) {
        reset();
    }
}

uint32_t TwoLevel::key_of(NodeId node) const
{
    const TwoLevelNodes& info = hierarchy().two_level();
    return info.empty() ? node.value : info.key[node.value];
}

const TwoLevel::ObjectView& TwoLevel::object_view(CullFrame& frame, uint32_t object)
{
    ObjectView& known = object_views_[object];
    if (known.stamp != frame.stamp()) {
        const glm::mat4& world_from_object =
            hierarchy().two_level().frames[object].world_from_object;
        const View& view = frame.view();
        known.stamp = frame.stamp();
        known.shrink = inverse_stretch(world_from_object);
        known.view = View::from_clip(
            glm::mat4{glm::dmat4{view.clip_from_world()} * glm::dmat4{world_from_object}},
            view.size_px(), view.convention());
    }
    return known;
}

// --- the list of active nodes
// ------------------------------------------------------------------------

bool TwoLevel::is_nearer(uint32_t a, uint32_t b) const
{
    const Active& one = active_[a];
    const Active& other = active_[b];
    return one.distance != other.distance ? one.distance < other.distance : one.node < other.node;
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

// --- visibility
// --------------------------------------------------------------------------------------

// How many frames a node that was just found visible is drawn without a test.
uint32_t TwoLevel::postponement(const NodeState& state, uint32_t key, uint32_t stamp) const
{
    const uint32_t remembered = state.history << (32u - options_.history_length);
    const auto visible = static_cast<uint32_t>(std::popcount(remembered));
    const auto frames = static_cast<uint32_t>(std::min<uint64_t>(
        uint64_t{options_.frames_per_visible} * visible, options_.max_postponed));
    const uint64_t random = hash64(options_.seed, key, stamp);
    return options_.spread ? frames - uniform_below(random, frames / 2 + 1) : frames;
}

// The box to test, and the space that it is in: the object's own where that is tighter.
void TwoLevel::prepare_query(CullFrame& frame, Active& active)
{
    const TwoLevelNodes& info = hierarchy().two_level();
    const Aabb& world_box = hierarchy().node(active.node).box;
    const bool wants_rectangle = options_.disjoint;
    active.world_from_box = nullptr;
    if (!info.empty()) {
        const uint32_t object = info.object[active.node.value];
        const Aabb& box = info.box[active.node.value];
        const bool oriented = object != TwoLevelNodes::kScene && info.frames[object].oriented;
        const ObjectView* space = oriented ? &object_view(frame, object) : nullptr;
        if (space != nullptr && space->shrink > 0.0f && box.is_bounded()) {
            // As much as the box around it would grow in the world (R2), in the object's lengths.
            active.world_from_box = &info.frames[object].world_from_object;
            const Aabb around = transformed(*active.world_from_box, box);
            const Aabb grown = frame.view().inflated_for_test(around);
            const glm::vec3 margins = glm::max(grown.max - around.max, around.min - grown.min);
            const float margin = std::max({margins.x, margins.y, margins.z});
            active.box = inflated(box, kMarginSlack * margin * space->shrink);
            if (wants_rectangle) {
                active.screen = project(space->view, box);
            }
            return;
        }
        const Aabb& tested = oriented ? world_box : box;
        active.box = frame.view().inflated_for_test(tested);
        if (wants_rectangle) {
            active.screen = project(frame.view(), tested);
        }
        return;
    }
    active.box = frame.test_box(active.node);
    if (wants_rectangle) {
        active.screen = project(frame.view(), world_box);
    }
}

// Algorithm 3.
TwoLevel::FirstResult TwoLevel::first_visibility_test(CullFrame& frame, Active& active,
                                                      Decision& if_visible)
{
    if (!frame.visit(active.node, active.mask)) {
        return FirstResult::invisible; // last_visited stays: on re-entry the node is unknown (R8)
    }
    NodeState& state = state_of(active.node);
    const bool known = state.last_visited + 1 == frame.stamp();
    state.last_visited = frame.stamp();
    if (!known) {
        state.history = 0;
        state.frames_hidden = 0;
        state.visible = false;
    }
    const bool child_seen = options_.pull_up && state.child_seen + 1 == frame.stamp();
    if (state.visible && (child_seen || frame.stamp() < state.next_test)) {
        if_visible = Decision::drawn;
        return FirstResult::visible;
    }
    prepare_query(frame, active);
    const Aabb box_world = active.world_from_box != nullptr
                               ? transformed(*active.world_from_box, active.box)
                               : active.box;
    if (frame.view().touches_near(box_world)) {
        if_visible = Decision::drawn_near;
        state.visible = true;
        state.frames_hidden = 0;
        state.next_test = frame.stamp() + 1;
        return FirstResult::visible;
    }
    return FirstResult::needs_query;
}

bool TwoLevel::overlaps_pending(const Active& active) const
{
    if (!options_.disjoint) {
        return false;
    }
    for (const PendingTest& test : pending_) {
        for (uint32_t i = test.first; i < test.first + test.count; ++i) {
            if (overlap(active.screen.rect, active_[tested_[i]].screen.rect)) {
                return true;
            }
        }
    }
    return false;
}

// --- Algorithm 4
// -------------------------------------------------------------------------------------

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
    frame.draw_own(node, mask, decision);
    const Node& n = hierarchy().node(node);
    for (uint32_t i = 0; i < n.child_count; ++i) {
        insert(frame, NodeId{n.first_child.value + i}, node, mask);
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

// A group of which something is visible says nothing of its nodes: its halves are tested, or they
// are, each by itself.
void TwoLevel::handle_test(CullFrame& frame, const PendingTest& test, const Answer& answer)
{
    const bool visible = is_visible(answer, options_.threshold);
    if (test.count > 1 && visible) {
        ++frame.counters().multiqueries_failed;
        const auto part = static_cast<uint32_t>(failed_multiquery_part(test.count, kMostSingly));
        for (uint32_t i = 0; i < test.count; i += part) {
            const uint32_t count = std::min(part, test.count - i);
            if (count == 1) {
                waiting_.push_back(tested_[test.first + i]);
            } else {
                halves_.push_back({Ticket{}, test.first + i, count});
            }
        }
        return;
    }
    const Decision if_hidden = test.count > 1 ? Decision::hidden_group : Decision::hidden;
    for (uint32_t i = test.first; i < test.first + test.count; ++i) {
        handle_result(frame, tested_[i], visible, if_hidden);
    }
}

// --- issuing
// -----------------------------------------------------------------------------------------

// Collects one test over all of `entries`, which are none of tested_.
void TwoLevel::add_test(std::span<const uint32_t> entries)
{
    collected_.push_back(
        {Ticket{}, static_cast<uint32_t>(tested_.size()), static_cast<uint32_t>(entries.size())});
    tested_.insert(tested_.end(), entries.begin(), entries.end());
    for (const uint32_t at : entries) {
        const Active& active = active_[at];
        if (active.world_from_box != nullptr) {
            batch_.add_box(active.box, *active.world_from_box, active.node);
        } else {
            batch_.add_box(active.box, active.node);
        }
    }
    batch_.end_test();
    pending_.push_back(collected_.back());
}

void TwoLevel::submit(CullFrame& frame)
{
    if (batch_.empty()) {
        return;
    }
    frame.flush_draws();
    frame.query(batch_, tickets_);
    const size_t first = pending_.size() - collected_.size();
    for (size_t i = 0; i < collected_.size(); ++i) {
        pending_[first + i].ticket = tickets_[i];
        frame.counters().multiqueries += collected_[i].count > 1 ? 1 : 0;
    }
    batch_.clear();
    collected_.clear();
}

// The halves of groups in which something is visible.
void TwoLevel::issue_halves(CullFrame& frame)
{
    while (!halves_.empty() && pending_.size() < pending_limit(frame)) {
        const PendingTest half = halves_.back();
        halves_.pop_back();
        const auto first = tested_.begin() + half.first;
        ordered_.assign(first, first + half.count);
        add_test(ordered_);
    }
    submit(frame);
}

// Only nodes that stayed hidden are left, and all that is known to be visible is drawn: tests them
// in groups of those that are likely to stay hidden together.
void TwoLevel::issue_deferred(CullFrame& frame)
{
    for (Deferred& deferred : deferred_) {
        const uint32_t frames_hidden = state_of(active_[deferred.at].node).frames_hidden;
        deferred.keep = keep_table_.keep_probability(frames_hidden);
    }
    // Descending: the greedy choice of a group relies on it.
    std::sort(deferred_.begin(), deferred_.end(), [this](const Deferred& a, const Deferred& b) {
        return a.keep != b.keep ? a.keep > b.keep : is_nearer(a.at, b.at);
    });
    keep_.clear();
    ordered_.clear();
    for (const Deferred& deferred : deferred_) {
        keep_.push_back(deferred.keep);
        ordered_.push_back(deferred.at);
    }
    size_t done = 0;
    while (done < deferred_.size() && pending_.size() < pending_limit(frame)) {
        const size_t size =
            best_multiquery_size(std::span<const double>{keep_}.subspan(done), kMostSingly);
        add_test(std::span<const uint32_t>{ordered_}.subspan(done, size));
        done += size;
    }
    deferred_.erase(deferred_.begin(), deferred_.begin() + static_cast<std::ptrdiff_t>(done));
    submit(frame);
}

// --- Algorithm 2
// -------------------------------------------------------------------------------------

size_t TwoLevel::pending_limit(const CullFrame& frame) const
{
    return std::max<size_t>(std::min(options_.max_pending, frame.caps().max_outstanding), 1);
}

// Handles the queries that are answered; false if none was.
bool TwoLevel::poll_pending(CullFrame& frame)
{
    const size_t before = pending_.size();
    size_t left = 0;
    for (size_t i = 0; i < before; ++i) {
        const PendingTest test = pending_[i];
        const Answer answer = frame.poll(test.ticket);
        if (answer.state == AnswerState::pending) {
            pending_[left++] = test;
        } else {
            handle_test(frame, test, answer);
        }
    }
    pending_.resize(left);
    return left < before;
}

// First loop: the queries that are answered. All that could be done without them is done, so if
// none is, the first is waited for; mostly that brings the answers of its whole batch.
void TwoLevel::finish_queries(CullFrame& frame)
{
    if (poll_pending(frame) || pending_.empty()) {
        return;
    }
    const PendingTest test = pending_.front();
    pending_.erase(pending_.begin());
    handle_test(frame, test, frame.wait(test.ticket));
    poll_pending(frame);
}

// Reaches nodes near to far until none is left that was not: draws and opens it, drops it, or says
// how it is to be tested.
void TwoLevel::reach_fresh(CullFrame& frame)
{
    const auto farther = [this](uint32_t a, uint32_t b) { return is_nearer(b, a); };
    while (!fresh_.empty()) {
        std::pop_heap(fresh_.begin(), fresh_.end(), farther);
        const uint32_t at = fresh_.back();
        fresh_.pop_back();
        Decision decision = Decision::drawn;
        switch (first_visibility_test(frame, active_[at], decision)) {
        case FirstResult::invisible:
            break;
        case FirstResult::visible:
            process_visible_node(frame, at, decision);
            break;
        case FirstResult::needs_query: {
            const bool stayed_hidden = state_of(active_[at].node).frames_hidden > 0;
            if (options_.multiqueries && stayed_hidden) {
                deferred_.push_back({at});
            } else {
                waiting_.push_back(at);
            }
            break;
        }
        }
    }
}

// Tests the nodes whose boxes are apart on the screen, the nearer first.
void TwoLevel::issue_waiting(CullFrame& frame)
{
    std::sort(waiting_.begin(), waiting_.end(),
              [this](uint32_t a, uint32_t b) { return is_nearer(a, b); });
    size_t left = 0;
    for (const uint32_t at : waiting_) {
        const bool full = pending_.size() >= pending_limit(frame); // maximum queries reached
        if (full || overlaps_pending(active_[at])) {
            waiting_[left++] = at;
        } else {
            add_test({&at, 1});
        }
    }
    waiting_.resize(left);
    submit(frame);
}

// Second loop: as many nodes as possible at once. False once the list is empty.
bool TwoLevel::process_active(CullFrame& frame)
{
    reach_fresh(frame);
    issue_waiting(frame);
    if (pending_.empty() && !halves_.empty()) {
        issue_halves(frame);
    }
    if (pending_.empty() && !deferred_.empty()) {
        issue_deferred(frame);
    }
    return !pending_.empty();
}

void TwoLevel::cull_frame(CullFrame& frame)
{
    const TwoLevelNodes& info = hierarchy().two_level();
    states_.resize(info.empty() ? hierarchy().nodes().size() : info.key_count);
    object_views_.resize(info.frames.size());
    active_.clear();
    tested_.clear();
    insert(frame, hierarchy().root(), NodeId{}, Frustum::kAllPlanes);
    while (process_active(frame)) {
        finish_queries(frame);
    }
}

} // namespace occlude
