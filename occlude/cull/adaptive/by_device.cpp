#include <occlude/cull/adaptive/by_device.h>

#include <algorithm>

namespace occlude {

void TestingByDevice::drop_late_tests(std::vector<Ticket>& tickets)
{
    for (const LateTest& test : late_) {
        tickets.push_back(test.ticket);
    }
    late_.clear();
}

// --- what was drawn, tested for a frame to come --------------------------------------------------

void TestingByDevice::take_late_answers(CullFrame& frame)
{
    turned_hidden_.clear();
    std::erase_if(late_, [&](const LateTest& test) {
        const Answer answer = frame.poll(test.ticket);
        if (!is_visible(answer, 0)) {
            turned_hidden_.push_back(test.entry);
        }
        return answer.state != AnswerState::pending;
    });
    std::sort(turned_hidden_.begin(), turned_hidden_.end());
}

// The longer ago its last test, the sooner one pays again.
bool TestingByDevice::retest_pays(const CullFrame& frame, const CutCandidate& candidate)
{
    const ScreenBounds bounds = project(frame.view(), shared_.cut.box_of(candidate.entry));
    if (!bounds.valid || shared_.touches_near(frame, candidate.entry)) {
        return false;
    }
    const double share = coverage_.share(bounds);
    const double covered = coverage_.chance_covered(share);
    coverage_.add_drawn(share);
    return shared_.planner.retest_pays(shared_.costs(), shared_.cut.draw_us(candidate.entry),
                                       covered, frame.stamp() - candidate.entry.tested);
}

// What was not worth opening when it was drawn first may be now.
void TestingByDevice::keep_parts_visible(const CullFrame& frame, const CutCandidate& candidate)
{
    next_round_.clear();
    shared_.cut.add_parts(frame, candidate, next_round_);
    for (CutCandidate& part : next_round_) {
        part.entry.tested = candidate.entry.tested;
        shared_.cut.keep_visible(part.entry);
    }
}

void TestingByDevice::retest(CullFrame& frame)
{
    // Late tests leave the other half of the device's tickets to the rounds of the next frame.
    const size_t max_late = frame.caps().max_outstanding / 2;

    batch_.clear();
    coverage_.start_frame(frame.view().size_px());
    const size_t first = late_.size();
    for (CutCandidate& candidate : shared_.cut.drawn()) {
        Entry& entry = candidate.entry;
        if (shared_.cut.opens(entry)) {
            keep_parts_visible(frame, candidate);
            continue;
        }
        if (late_.size() < max_late && frame.free_tickets(late_.size()) > 0 &&
            retest_pays(frame, candidate)) {
            batch_.add_box(shared_.test_box(frame, entry), entry.node);
            batch_.end_test();
            late_.push_back({Ticket{}, CutTraversal::name_of(entry)});
            entry.tested = frame.stamp();
        }
        shared_.cut.keep_visible(entry);
    }
    if (batch_.empty()) {
        return;
    }
    frame.query(batch_, tickets_, shared_.planner.method());
    for (size_t i = 0; i < tickets_.size(); ++i) {
        late_[first + i].ticket = tickets_[i];
    }
    const auto tests = static_cast<double>(tickets_.size());
    shared_.meter.spend(shared_.costs().round(shared_.planner.method()).of(tests), tests);
}

// --- what a round tests --------------------------------------------------------------------------

void TestingByDevice::draw_untested(CullFrame& frame, const CutCandidate& candidate)
{
    shared_.cut.draw(frame, candidate, Decision::drawn);
    shared_.cut.keep_visible(candidate.entry);
}

bool TestingByDevice::worth_testing(const Entry& entry) const
{
    const CostModel& costs = shared_.costs();
    return entry.state == HierarchyCut::State::hidden
               ? shared_.cut.draw_us(entry) > shared_.planner.kept_us(costs)
               : hoped_us(entry) > costs.round(shared_.planner.method()).us_per_test;
}

// What the near plane may touch is drawn, or its parts take its place.
void TestingByDevice::open_near(CullFrame& frame, const CutCandidate& candidate)
{
    if (!shared_.cut.opens(candidate.entry)) {
        shared_.cut.draw(frame, candidate, Decision::drawn_near);
        shared_.cut.keep_visible(candidate.entry);
        return;
    }
    next_round_.clear();
    shared_.cut.add_parts(frame, candidate, next_round_);
    for (CutCandidate& part : next_round_) {
        if (shared_.cut.visit(frame, part)) {
            shared_.cut.candidates().push_back(part);
        } else {
            shared_.cut.keep_outside(part.entry);
        }
    }
    next_round_.clear();
}

// Leaves in `round_` what will be tested: of the candidates in the frustum, those that a test may
// see and that are worth one.
void TestingByDevice::collect_round(CullFrame& frame, bool first_round)
{
    round_.clear();
    std::vector<CutCandidate>& candidates = shared_.cut.candidates();
    while (!candidates.empty()) {
        CutCandidate candidate = candidates.back();
        candidates.pop_back();
        if (!first_round && !shared_.cut.visit(frame, candidate)) {
            shared_.cut.keep_outside(candidate.entry);
        } else if (shared_.touches_near(frame, candidate.entry)) {
            open_near(frame, candidate);
        } else if (!worth_testing(candidate.entry)) {
            draw_untested(frame, candidate);
        } else {
            round_.push_back(candidate);
        }
    }
    if (!first_round) {
        end_rounds_unless_worthwhile(frame);
    }
}

// What one more round may hide, all of it, must be worth the wait.
void TestingByDevice::end_rounds_unless_worthwhile(CullFrame& frame)
{
    double hidden_us = 0.0;
    for (const CutCandidate& candidate : round_) {
        hidden_us += hoped_us(candidate.entry);
    }
    const RoundCost cost = shared_.costs().round(shared_.planner.method());
    if (hidden_us < cost.of(static_cast<double>(round_.size()))) {
        for (const CutCandidate& candidate : round_) {
            draw_untested(frame, candidate);
        }
        round_.clear();
    }
}

// --- which candidates share a test ---------------------------------------------------------------

// Those that were hidden for longest come first and may share queries; the parts of groups that
// failed come last and stay together. By flags each box costs the same, whatever it shares.
void TestingByDevice::sort_for_groups()
{
    keep_.clear();
    if (shared_.planner.method() != TestMethod::queries) {
        return;
    }
    std::stable_sort(
        round_.begin(), round_.end(), [](const CutCandidate& a, const CutCandidate& b) {
            return a.failed_group != b.failed_group ? a.failed_group < b.failed_group
                                                    : a.entry.frames_hidden > b.entry.frames_hidden;
        });
    double last = 1.0;
    for (const CutCandidate& candidate : round_) {
        if (candidate.failed_group != 0) {
            break;
        }
        // The measured table need not be monotonic; the greedy choice of group sizes wants it so.
        last = std::min(last, keep_table_.keep_probability(candidate.entry.frames_hidden));
        keep_.push_back(last);
    }
}

uint32_t TestingByDevice::group_size(uint32_t first) const
{
    if (first < keep_.size()) {
        return static_cast<uint32_t>(best_multiquery_size(
            std::span<const double>{keep_}.subspan(first), max_tested_singly()));
    }
    const uint32_t group = round_[first].failed_group;
    uint32_t count = 1;
    while (group != 0 && first + count < round_.size() &&
           round_[first + count].failed_group == group) {
        ++count;
    }
    return count;
}

// Fills the batch with at most `max_tests` tests of round_ from `first` on, and returns where it
// ends.
uint32_t TestingByDevice::group_tests(CullFrame& frame, uint32_t first, size_t max_tests)
{
    groups_.clear();
    batch_.clear();
    while (first < round_.size() && groups_.size() < max_tests) {
        const uint32_t count = group_size(first);
        for (uint32_t i = first; i < first + count; ++i) {
            const Entry& entry = round_[i].entry;
            batch_.add_box(shared_.test_box(frame, entry), entry.node);
        }
        batch_.end_test();
        groups_.push_back({first, count});
        kept_tests_ += round_[first].entry.state == HierarchyCut::State::hidden ? 1.0 : 0.0;
        frame.counters().multiqueries += spans_nodes(groups_.back()) ? 1 : 0;
        first += count;
    }
    return first;
}

// A failed group is halved as long as that is cheaper than to test its nodes one by one: one more
// round and two tests, for half of the nodes hidden.
size_t TestingByDevice::max_tested_singly() const
{
    constexpr double kMinUsPerTest = 1e-6; // keeps the ratio finite
    constexpr double kMaxNodes = 1e6;
    const RoundCost cost = shared_.costs().round(shared_.planner.method());
    const double nodes =
        2.0 * (2.0 + cost.us_per_round / std::max(cost.us_per_test, kMinUsPerTest));
    return std::max(static_cast<size_t>(std::min(nodes, kMaxNodes)), kLeastHalved - 1);
}

// --- answers -------------------------------------------------------------------------------------

// A multiquery, as the counters mean it: items of one node that share a test are none.
bool TestingByDevice::spans_nodes(const Group& group) const
{
    const std::span members = std::span{round_}.subspan(group.first, group.count);
    return std::ranges::any_of(members, [&](const CutCandidate& candidate) {
        return candidate.entry.node != members.front().entry.node;
    });
}

// A group that shows something is asked again in parts.
void TestingByDevice::split(const Group& group)
{
    const size_t part = failed_multiquery_part(group.count, max_tested_singly());
    for (uint32_t k = 0; k < group.count; ++k) {
        failed_groups_ += k % part == 0 ? 1 : 0;
        round_[group.first + k].failed_group = failed_groups_;
        next_round_.push_back(round_[group.first + k]);
    }
}

void TestingByDevice::take_answer(CullFrame& frame, const CutCandidate& candidate, bool visible,
                                  bool alone)
{
    CutTraversal& cut = shared_.cut;
    if (candidate.entry.state == HierarchyCut::State::hidden) {
        kept_ += 1.0;
        keep_table_.record(candidate.entry.frames_hidden, !visible);
    } else {
        cut.hidden_share.note(!visible);
    }
    if (!visible) {
        cut.keep_hidden(frame, candidate.entry, alone ? Decision::hidden : Decision::hidden_group);
    } else if (cut.opens(candidate.entry)) {
        cut.add_parts(frame, candidate, next_round_);
    } else {
        Entry entry = candidate.entry;
        entry.tested = frame.stamp();
        cut.draw(frame, candidate, Decision::drawn_revealed);
        cut.keep_visible(entry);
    }
}

void TestingByDevice::take_answers(CullFrame& frame)
{
    for (size_t i = 0; i < groups_.size(); ++i) {
        const Group group = groups_[i];
        const bool visible = is_visible(frame.wait(tickets_[i]), 0);
        if (visible && group.count > 1) {
            frame.counters().multiqueries_failed += spans_nodes(group) ? 1 : 0;
            split(group);
            continue;
        }
        for (uint32_t k = 0; k < group.count; ++k) {
            take_answer(frame, round_[group.first + k], visible, group.count == 1);
        }
    }
}

// --- rounds --------------------------------------------------------------------------------------

// Asks the batch, and waits for what has to be known before anything else can be decided.
void TestingByDevice::ask(CullFrame& frame, bool first_round)
{
    // A round of fewer tests does not tell what one costs.
    constexpr size_t kMinTests = 16;

    CostMeter& meter = shared_.meter;
    const TestMethod method = shared_.planner.method();
    const double queued_us = shared_.cut.queued_us(frame);
    const double from = meter.now_us();
    frame.flush_draws();
    frame.query(batch_, tickets_, method);
    take_answers(frame);
    const double to = meter.now_us();
    meter.check_clock(from, to);
    const size_t boxes = batch_.boxes().size();
    if (!first_round && groups_.size() >= kMinTests) {
        meter.note_round(method, groups_.size(), boxes, std::max(to - from - queued_us, 0.0));
    }
    const auto tests = static_cast<double>(groups_.size());
    meter.spend(shared_.costs().round(method).of(tests, static_cast<double>(boxes)), tests);
}

void TestingByDevice::test_in_rounds(CullFrame& frame, double since_us)
{
    CostMeter& meter = shared_.meter;
    failed_groups_ = 0;
    kept_tests_ = 0.0;
    kept_ = 0.0;
    for (bool first_round = true; !shared_.cut.candidates().empty(); first_round = false) {
        collect_round(frame, first_round);
        if (round_.empty()) {
            break;
        }
        sort_for_groups();
        next_round_.clear();
        for (uint32_t first = 0; first < round_.size();) {
            const size_t free_tickets = frame.free_tickets(late_.size());
            if (free_tickets == 0) {
                draw_untested(frame, round_[first]);
                ++first;
                continue;
            }
            first = group_tests(frame, first, free_tickets);
            ask(frame, first_round);
        }
        if (first_round) { // the device is idle: what did drawing cost?
            meter.note_drawing(shared_.drawn_units(frame),
                               meter.now_us() - since_us - meter.spent_us());
        }
        trials_.try_one(frame, round_, frame.free_tickets(late_.size()));
        shared_.update_prices();
        shared_.cut.candidates().swap(next_round_);
    }
    shared_.planner.note_sharing(kept_tests_, kept_);
    shared_.update_prices();
}

void TestingByDevice::test(CullFrame& frame, double since_us)
{
    test_in_rounds(frame, since_us);
    frame.flush_draws();
    retest(frame);
}

void TestingByDevice::probe(CullFrame& frame, double since_us)
{
    shared_.cut.assume_all_drawn();
    shared_.cut.candidates().assign(1, CutCandidate{shared_.cut.cut().entries().front()});
    test_in_rounds(frame, since_us);
}

} // namespace occlude
