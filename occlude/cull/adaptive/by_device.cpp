#include <occlude/cull/adaptive/by_device.h>

#include <algorithm>

namespace occlude {

void TestingByDevice::drop_late_tests(std::vector<Ticket>& tickets)
{
    for (const LateTest& test : late_.pending) {
        tickets.push_back(test.ticket);
    }
    late_.pending.clear();
}

// --- what was drawn, tested for a frame to come --------------------------------------------------

void TestingByDevice::take_late_answers(CullFrame& frame)
{
    late_.turned_hidden.clear();
    std::erase_if(late_.pending, [&](const LateTest& test) {
        const Answer answer = frame.poll(test.ticket);
        if (!is_visible(answer, 0)) {
            late_.turned_hidden.push_back(test.entry);
        }
        return answer.state != AnswerState::pending;
    });
    std::sort(late_.turned_hidden.begin(), late_.turned_hidden.end());
}

// The older the last test, the sooner a new one pays.
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

// A node that was not worth opening when it was drawn may be worth it now.
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
    // Late tests take half of the device's tickets. The rounds of the next frame get the other
    // half.
    const size_t max_late = frame.caps().max_outstanding / 2;

    late_.batch.clear();
    coverage_.start_frame(frame.view().size_px());
    const size_t first = late_.pending.size();
    for (CutCandidate& candidate : shared_.cut.drawn()) {
        Entry& entry = candidate.entry;
        if (shared_.cut.opens(entry)) {
            keep_parts_visible(frame, candidate);
            continue;
        }
        if (late_.pending.size() < max_late && frame.free_tickets(late_.pending.size()) > 0 &&
            retest_pays(frame, candidate)) {
            late_.batch.add_box(shared_.test_box(frame, entry), entry.node);
            late_.batch.end_test();
            late_.pending.push_back({Ticket{}, CutTraversal::name_of(entry)});
            entry.tested = frame.stamp();
        }
        shared_.cut.keep_visible(entry);
    }
    if (late_.batch.empty()) {
        return;
    }
    frame.query(late_.batch, late_.tickets, shared_.planner.method());
    for (size_t i = 0; i < late_.tickets.size(); ++i) {
        late_.pending[first + i].ticket = late_.tickets[i];
    }
    const auto tests = static_cast<double>(late_.tickets.size());
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

// Draws a candidate that the near plane may touch, or opens it and adds its parts instead.
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

// Collects in `round_` what this round tests: candidates in the frustum that do not touch the near
// plane and are worth a test, then the members of groups that failed.
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
    line_up();
    for (const Test& part : parts_) {
        for (const uint32_t member : batcher_.members(part)) {
            round_.push_back(asked_[member]);
        }
    }
    if (!first_round) {
        end_rounds_unless_worthwhile(frame);
    }
}

// Ends the rounds unless the expected gain of all tests of one more round exceeds its cost.
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
        in_line_.clear();
        parts_.clear();
    }
}

// --- which candidates share a test ---------------------------------------------------------------

// Sorts the longest hidden first, so that they share queries. Flags and depth have no use for
// groups: there, each box costs the same.
void TestingByDevice::sort_for_groups()
{
    if (shared_.planner.method() == TestMethod::queries) {
        std::stable_sort(round_.begin(), round_.end(),
                         [](const CutCandidate& a, const CutCandidate& b) {
                             return a.entry.frames_hidden > b.entry.frames_hidden;
                         });
    }
}

// Makes the candidates of `round_` members of tests to come, in the order of their tests.
void TestingByDevice::line_up()
{
    sort_for_groups();
    in_line_.clear();
    double last = 1.0;
    for (uint32_t i = 0; i < round_.size(); ++i) {
        // The measured table need not be monotonic, but groups must follow the order of `round_`.
        last = std::min(last, keep_table_.keep_probability(round_[i].entry.frames_hidden));
        in_line_.push_back({static_cast<uint32_t>(asked_.size()), last, i});
        asked_.push_back(round_[i]);
    }
}

auto TestingByDevice::add_boxes(CullFrame& frame) const
{
    return [this, &frame](MultiqueryBatcher::Member member, TestBatch& batch) {
        const Entry& entry = asked_[member].entry;
        batch.add_box(shared_.test_box(frame, entry), entry.node);
    };
}

// Adds at most `max_tests` tests of in_line_, beginning at `first`, and returns the index after the
// last candidate that has a test.
size_t TestingByDevice::add_tests(CullFrame& frame, size_t first, size_t max_tests)
{
    const std::span<MultiqueryBatcher::Candidate> left = std::span{in_line_}.subspan(first);
    if (shared_.planner.method() == TestMethod::queries) {
        return first + batcher_.add_groups(left, max_tests, add_boxes(frame), [](const Test&) {});
    }
    const size_t count = std::min(left.size(), max_tests);
    for (const MultiqueryBatcher::Candidate& candidate : left.first(count)) {
        batcher_.add_test({&candidate.member, 1}, add_boxes(frame));
    }
    return first + count;
}

// Adds at most `max_tests` of parts_, beginning at `first`, and returns the index after the last.
size_t TestingByDevice::add_parts(CullFrame& frame, size_t first, size_t max_tests)
{
    const size_t end = first + std::min(parts_.size() - first, max_tests);
    for (size_t i = first; i < end; ++i) {
        batcher_.add_part(parts_[i], add_boxes(frame));
    }
    return end;
}

// The largest failed group whose nodes are tested one by one. A larger group is halved: halving
// costs one more round and two more tests, and on average spares half of the single tests.
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

// A failed group, in which something is visible, is tested again in parts.
void TestingByDevice::take_answers(CullFrame& frame, std::span<const Test> tests)
{
    for (const Test& test : tests) {
        const std::span<const uint32_t> members = batcher_.members(test);
        const Entry& first = asked_[members.front()].entry;
        kept_tests_ += first.state == HierarchyCut::State::hidden ? 1.0 : 0.0;
        const bool visible = is_visible(frame.wait(test.ticket), 0);
        if (visible && test.count > 1) {
            batcher_.split(frame, test, [&](const Test& part) { next_parts_.push_back(part); });
            continue;
        }
        for (const uint32_t member : members) {
            take_answer(frame, asked_[member], visible, test.count == 1);
        }
    }
}

// --- rounds --------------------------------------------------------------------------------------

// Issues the added tests and waits for their answers, which the next round depends on.
void TestingByDevice::ask(CullFrame& frame, bool first_round)
{
    // Rounds with fewer tests do not show what one test costs.
    constexpr size_t kMinTests = 16;

    CostMeter& meter = shared_.meter;
    const TestMethod method = shared_.planner.method();
    const double queued_us = shared_.cut.queued_us(frame);
    const double from = meter.now_us();
    const size_t boxes = batcher_.box_count();
    frame.flush_draws();
    const std::span<const Test> tests = batcher_.submit(frame, method);
    take_answers(frame, tests);
    const double to = meter.now_us();
    meter.check_clock(from, to);
    if (!first_round && tests.size() >= kMinTests) {
        meter.note_round(method, tests.size(), boxes, std::max(to - from - queued_us, 0.0));
    }
    const auto count = static_cast<double>(tests.size());
    meter.spend(shared_.costs().round(method).of(count, static_cast<double>(boxes)), count);
}

// Tests the whole round, as many tests at a time as the device has free tickets. Draws the rest
// untested when there are no tickets left.
void TestingByDevice::test_round(CullFrame& frame, bool first_round)
{
    next_round_.clear();
    next_parts_.clear();
    size_t in_line = 0;
    size_t part = 0;
    while (in_line < in_line_.size() || part < parts_.size()) {
        const size_t free_tickets = frame.free_tickets(late_.pending.size());
        if (free_tickets == 0) {
            break;
        }
        batcher_.set_most_singly(max_tested_singly());
        in_line = add_tests(frame, in_line, free_tickets);
        part = add_parts(frame, part, free_tickets - batcher_.test_count());
        ask(frame, first_round);
    }
    for (; in_line < in_line_.size(); ++in_line) {
        draw_untested(frame, asked_[in_line_[in_line].member]);
    }
    for (; part < parts_.size(); ++part) {
        for (const uint32_t member : batcher_.members(parts_[part])) {
            draw_untested(frame, asked_[member]);
        }
    }
}

void TestingByDevice::test_in_rounds(CullFrame& frame, double since_us)
{
    CostMeter& meter = shared_.meter;
    batcher_.clear();
    asked_.clear();
    parts_.clear();
    kept_tests_ = 0.0;
    kept_ = 0.0;
    for (bool first_round = true; !shared_.cut.candidates().empty() || !parts_.empty();
         first_round = false) {
        collect_round(frame, first_round);
        if (round_.empty()) {
            break;
        }
        test_round(frame, first_round);
        if (first_round) { // The device is idle here, so that the time of drawing can be read.
            meter.note_drawing(shared_.drawn_units(frame),
                               meter.now_us() - since_us - meter.spent_us());
        }
        trials_.try_one(frame, round_, frame.free_tickets(late_.pending.size()));
        shared_.update_prices();
        shared_.cut.candidates().swap(next_round_);
        parts_.swap(next_parts_);
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
