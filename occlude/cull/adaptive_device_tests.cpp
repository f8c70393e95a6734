// The part of `adaptive` that tests by the device: rounds of tests, each for what the last one
// revealed, and tests of what is drawn whose answers are for the next frame.
#include <occlude/cull/adaptive.h>

#include <occlude/core/rng.h>

#include <algorithm>
#include <array>

namespace occlude {

namespace {

// The part of what is known of the sharing of queries that one frame replaces.
constexpr double kSharingStep = 1.0 / 8.0;

// A round of so many tests on an idle device says what one costs.
constexpr size_t kTellingTests = 16;

// A method whose hint costs so many times the best is not worth measuring.
constexpr double kHopeless = 4.0;

} // namespace

// --- what was drawn, tested for the next frame ---------------------------------------------------

// Reads the answers that are there by now; the others wait on.
void Adaptive::take_late_answers(CullFrame& frame)
{
    found_hidden_.clear();
    std::erase_if(late_, [&](const LateTest& test) {
        const Answer answer = frame.poll(test.ticket);
        if (!is_visible(answer, 0) && answer.state == AnswerState::ready) {
            found_hidden_.push_back(test.entry);
        }
        return answer.state != AnswerState::pending;
    });
    std::sort(found_hidden_.begin(), found_hidden_.end());
}

// QueryReasonable for what is visible: the longer ago its last test, the sooner it pays again.
bool Adaptive::retest_reasonable(const CullFrame& frame, const Candidate& candidate)
{
    const ScreenBounds bounds = project(frame.view(), box_of(candidate.entry));
    if (!bounds.valid || near(frame, candidate.entry)) {
        return false;
    }
    const double share = coverage_.share(bounds);
    const double covered = coverage_.chance_covered(share);
    coverage_.drew(share);
    const double test_us = costs_.round(method_).us_per_test;
    const double benefit_us = 0.5 * covered * covered * (draw_us(candidate.entry) - kept_us());
    const auto age = static_cast<double>(frame.stamp() - candidate.entry.tested);
    return test_us < age * benefit_us;
}

// What was not worth opening when it was drawn first may be now.
void Adaptive::keep_parts_visible(const CullFrame& frame, const Candidate& candidate)
{
    next_round_.clear();
    add_parts(frame, candidate, next_round_);
    for (Candidate& part : next_round_) {
        part.entry.tested = candidate.entry.tested;
        keep_visible(part.entry);
    }
}

void Adaptive::retest_by_device(CullFrame& frame)
{
    batch_.clear();
    coverage_.start_frame(frame.view().size_px());
    const size_t first = late_.size();
    for (Candidate& candidate : drawn_) {
        if (opens(candidate.entry)) {
            keep_parts_visible(frame, candidate);
            continue;
        }
        const size_t room = frame.caps().max_outstanding;
        if (late_.size() < room && retest_reasonable(frame, candidate)) {
            batch_.add_box(test_box(frame, candidate.entry), candidate.entry.node);
            batch_.end_test();
            late_.push_back({Ticket{}, name_of(candidate.entry)});
            candidate.entry.tested = frame.stamp();
        }
        keep_visible(candidate.entry);
    }
    if (batch_.empty()) {
        return;
    }
    frame.query(batch_, tickets_, method_);
    for (size_t i = 0; i < tickets_.size(); ++i) {
        late_[first + i].ticket = tickets_[i];
    }
    const RoundCost cost = costs_.round(method_);
    tests_ += static_cast<double>(tickets_.size());
    spent_us_ += cost.of(static_cast<double>(tickets_.size()));
}

// --- rounds --------------------------------------------------------------------------------------

void Adaptive::draw_untested(CullFrame& frame, const Candidate& candidate)
{
    draw(frame, candidate, Decision::drawn);
    keep_visible(candidate.entry);
}

// A leaf that a test revealed is drawn; of an inner node the parts are tested next.
void Adaptive::open_for_next_round(CullFrame& frame, const Candidate& candidate)
{
    if (!opens(candidate.entry)) {
        Candidate drawn = candidate;
        drawn.entry.tested = frame.stamp();
        draw(frame, drawn, Decision::drawn_revealed);
        keep_visible(drawn.entry);
        return;
    }
    add_parts(frame, candidate, next_round_);
}

// Leaves in `round_` what will be tested: of the candidates in the frustum, those that a test may
// see and that are worth one. The near ones are opened until their parts can be tested.
void Adaptive::collect_round(CullFrame& frame, bool first_round)
{
    round_.clear();
    while (!candidates_.empty()) {
        Candidate candidate = candidates_.back();
        candidates_.pop_back();
        const Entry& entry = candidate.entry;
        if (!first_round && !visit(frame, candidate)) {
            keep_outside(entry);
            continue;
        }
        if (near(frame, entry)) {
            if (!opens(entry)) {
                draw(frame, candidate, Decision::drawn_near);
                keep_visible(entry);
            } else {
                next_round_.clear();
                add_parts(frame, candidate, next_round_);
                for (Candidate& child : next_round_) {
                    if (visit(frame, child)) {
                        candidates_.push_back(child);
                    } else {
                        keep_outside(child.entry);
                    }
                }
                next_round_.clear();
            }
        } else if (const bool kept = entry.state == State::hidden;
                   !(kept ? draw_us(entry) > kept_us() : worth_testing(entry))) {
            draw_untested(frame, candidate);
        } else {
            round_.push_back(candidate);
        }
    }
    // What all of them may hide must be worth the wait for one more round.
    double hidden_us = 0.0;
    for (const Candidate& candidate : round_) {
        hidden_us += hoped_us(candidate.entry);
    }
    const double round_us = costs_.round(method_).of(static_cast<double>(round_.size()));
    if (!first_round && hidden_us < round_us) {
        for (const Candidate& candidate : round_) {
            draw_untested(frame, candidate);
        }
        round_.clear();
    }
}

// Long-hidden nodes share a query, the others have their own; flags cost the same for each box.
void Adaptive::group_round(CullFrame& frame)
{
    groups_.clear();
    batch_.clear();
    keep_.clear();
    if (method_ == TestMethod::queries) {
        std::stable_sort(round_.begin(), round_.end(), [](const Candidate& a, const Candidate& b) {
            return a.together != b.together ? a.together < b.together
                                            : a.entry.frames_hidden > b.entry.frames_hidden;
        });
        double last = 1.0;
        for (const Candidate& candidate : round_) {
            if (candidate.together != 0) {
                break; // they come last
            }
            // The measured table need not be monotonic; the greedy choice wants it so.
            last = std::min(last, keep_table_.keep_probability(candidate.entry.frames_hidden));
            keep_.push_back(last);
        }
    }
    for (uint32_t first = 0; first < round_.size();) {
        uint32_t count = 1;
        if (first < keep_.size()) {
            count = static_cast<uint32_t>(
                best_multiquery_size(std::span<const double>{keep_}.subspan(first), most_singly()));
        } else if (const uint32_t together = round_[first].together; together != 0) {
            while (first + count < round_.size() && round_[first + count].together == together) {
                ++count;
            }
        }
        for (uint32_t i = first; i < first + count; ++i) {
            const Entry& entry = round_[i].entry;
            batch_.add_box(test_box(frame, entry), entry.node);
        }
        batch_.end_test();
        groups_.push_back({first, count});
        kept_tests_ += round_[first].entry.state == State::hidden ? 1.0 : 0.0;
        frame.counters().multiqueries += count > 1 ? 1 : 0;
        first += count;
    }
}

// Learns from an answer that speaks for one candidate.
void Adaptive::note_answer(const Candidate& candidate, bool found_hidden)
{
    if (candidate.entry.state == State::hidden) {
        kept_ += 1.0;
        keep_table_.record(candidate.entry.frames_hidden, found_hidden);
    } else {
        answered(found_hidden);
    }
}

void Adaptive::take_answers(CullFrame& frame)
{
    for (size_t i = 0; i < groups_.size(); ++i) {
        const Group group = groups_[i];
        const bool visible = is_visible(frame.wait(tickets_[i]), 0);
        const bool failed = visible && group.count > 1;
        const size_t part = failed ? failed_multiquery_part(group.count, most_singly()) : 1;
        frame.counters().multiqueries_failed += failed ? 1 : 0;
        for (uint32_t k = 0; k < group.count; ++k) {
            Candidate& candidate = round_[group.first + k];
            if (failed) {
                together_ += k % part == 0 ? 1 : 0;
                candidate.together = together_;
                next_round_.push_back(candidate);
                continue;
            }
            note_answer(candidate, !visible);
            if (visible) {
                candidate.together = 0;
                open_for_next_round(frame, candidate);
            } else {
                keep_hidden(frame, candidate.entry,
                            group.count > 1 ? Decision::hidden_group : Decision::hidden);
            }
        }
    }
}

// A failed group is halved as long as that is cheaper than to test its nodes one by one: one more
// round and two tests, for half of the nodes hidden.
size_t Adaptive::most_singly() const
{
    const RoundCost cost = costs_.round(method_);
    const double nodes = 2.0 * (2.0 + cost.us_per_round / std::max(cost.us_per_test, 1e-6));
    return std::max(static_cast<size_t>(std::min(nodes, 1e6)), kLeastHalved - 1);
}

// How many queries did it take per node that was hidden before?
void Adaptive::note_sharing()
{
    if (method_ == TestMethod::queries && kept_ > 0.0) {
        tests_per_kept_ += kSharingStep * (std::min(kept_tests_ / kept_, 1.0) - tests_per_kept_);
    }
}

void Adaptive::by_device(CullFrame& frame)
{
    by_rounds(frame);
    frame.flush_draws();
    retest_by_device(frame);
}

void Adaptive::by_rounds(CullFrame& frame)
{
    together_ = 0;
    kept_tests_ = 0.0;
    kept_ = 0.0;
    for (bool first_round = true; !candidates_.empty(); first_round = false) {
        collect_round(frame, first_round);
        if (round_.empty()) {
            break;
        }
        group_round(frame);
        const double queued_us =
            costs_.us_per_unit() * costs_.units(frame.queued_triangles(), frame.queued_items());
        const double from = now();
        frame.flush_draws();
        next_round_.clear();
        frame.query(batch_, tickets_, method_);
        take_answers(frame);
        if (clock_ && !first_round && groups_.size() >= kTellingTests) {
            costs_.tested(method_, groups_.size(), round_.size(),
                          std::max(now() - from - queued_us, 0.0));
        }
        tests_ += static_cast<double>(groups_.size());
        spent_us_ += costs_.round(method_).of(static_cast<double>(groups_.size()),
                                              static_cast<double>(round_.size()));
        if (first_round) {
            note_drawing(frame);
        }
        measure_methods(frame, round_);
        candidates_.swap(next_round_);
    }
    note_sharing();
}

// The device is at rest: what did drawing cost?
void Adaptive::note_drawing(CullFrame& frame)
{
    if (clock_) {
        costs_.drew(costs_.units(frame.counters()), std::max(now() - started_us_ - spent_us_, 0.0));
    }
}

// The device is at rest: what do the tests of each method that may be best cost? One round of one
// method in a frame, until that is known or looks no better.
void Adaptive::measure_methods(CullFrame& frame, std::span<const Candidate> candidates)
{
    if (!clock_ || candidates.empty() || options_.method != AdaptiveOptions::Method::automatic) {
        return;
    }
    const double us = expected_us(method_);
    for (const TestMethod method : {TestMethod::pyramid, TestMethod::raster, TestMethod::queries}) {
        const CostModel::Shape shape = costs_.least_known(method);
        const bool looked_at = costs_.rounds_measured(method) > 0 && shape.boxes == 1;
        const double most_us = (looked_at ? 1.0 : kHopeless) * us;
        if (measured_ || shape.tests == 0 || expected_us(method) > most_us) {
            continue;
        }
        if (method == TestMethod::pyramid) {
            if (measures_read(frame)) {
                measure_read(frame);
            }
        } else if (shape.boxes <= candidates.size()) {
            measure_round(frame, method, candidates.first(shape.boxes), shape.boxes / shape.tests);
        }
    }
}

// One round: as many tests as it takes, each of so many of the candidates.
void Adaptive::measure_round(CullFrame& frame, TestMethod method,
                             std::span<const Candidate> candidates, size_t boxes_per_test)
{
    batch_.clear();
    for (size_t i = 0; i < candidates.size(); ++i) {
        batch_.add_box(test_box(frame, candidates[i].entry), candidates[i].entry.node);
        if ((i + 1) % boxes_per_test == 0) {
            batch_.end_test();
        }
    }
    measured_ = true;
    const double from = now();
    frame.query(batch_, tickets_, method);
    for (const Ticket ticket : tickets_) {
        frame.wait(ticket);
    }
    costs_.tested(method, tickets_.size(), candidates.size(), now() - from);
}

} // namespace occlude
