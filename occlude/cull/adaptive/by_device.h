// The frames of `adaptive` that test on the device: rounds of tests, each for what the last one
// revealed, and tests of what is drawn whose answers are for a frame to come.
//
//    candidates --> collect_round --> group_tests --> query, wait --> hidden: kept
//         ^                                                  |        visible: drawn, or
//         +---------- its parts; the halves of a group ------+                 opened
//
//    what is drawn --> retest --> the answers come in a later frame --> turned_hidden()
//
// Guarantees  No test of a box that the near plane may touch (C5); never more unspent tickets than
//             the device can hold (C11).
// Cost        A round costs one wait. Rounds end where the next would hide less than it costs.
#pragma once

#include <occlude/cull/adaptive/method_trials.h>
#include <occlude/cull/adaptive/shared.h>
#include <occlude/cull/parts/chc_plus_plus_math.h>
#include <occlude/cull/parts/coverage.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

class TestingByDevice {
public:
    TestingByDevice(AdaptiveShared& shared, MethodTrials& trials)
        : shared_(shared)
        , trials_(trials)
    {
    }

    /// Forgets how long nodes stay hidden.
    void forget() { keep_table_.clear(); }
    /// Moves the tickets of tests whose answers are not wanted any more to `tickets`: they must be
    /// spent all the same.
    void drop_late_tests(std::vector<Ticket>& tickets);

    // --- one frame, in order ---

    /// Reads the answers for this frame that are there by now.
    void take_late_answers(CullFrame& frame);
    /// Entries that were visible and have turned out hidden, by CutTraversal::name_of(), ascending.
    std::span<const uint64_t> turned_hidden() const { return turned_hidden_; }

    /// Tests the candidates in rounds, draws what shows, and tests what was drawn for frames to
    /// come. Precondition: what was visible is drawn. `since_us`: when drawing began.
    void test(CullFrame& frame, double since_us);

    /// Tests the finished frame, from the root down as far as that pays: what would tests hide?
    void probe(CullFrame& frame, double since_us);

private:
    using Entry = HierarchyCut::Entry;

    /// One test: candidates [first, first + count) of round_.
    struct Group {
        uint32_t first = 0;
        uint32_t count = 0;
    };
    /// A test of what is drawn, whose answer is for a frame to come.
    struct LateTest {
        Ticket ticket;
        uint64_t entry = 0; ///< its CutTraversal::name_of()
    };

    void test_in_rounds(CullFrame& frame, double since_us);
    void collect_round(CullFrame& frame, bool first_round);
    void open_near(CullFrame& frame, const CutCandidate& candidate);
    bool worth_testing(const Entry& entry) const;
    void end_rounds_unless_worthwhile(CullFrame& frame);
    void draw_untested(CullFrame& frame, const CutCandidate& candidate);

    void sort_for_groups();
    uint32_t group_size(uint32_t first) const;
    uint32_t group_tests(CullFrame& frame, uint32_t first, size_t max_tests);
    void ask(CullFrame& frame, bool first_round);
    void take_answers(CullFrame& frame);
    bool spans_nodes(const Group& group) const;
    void split(const Group& group);
    void take_answer(CullFrame& frame, const CutCandidate& candidate, bool visible, bool alone);
    size_t max_tested_singly() const;

    void retest(CullFrame& frame);
    bool retest_pays(const CullFrame& frame, const CutCandidate& candidate);
    void keep_parts_visible(const CullFrame& frame, const CutCandidate& candidate);

    double hoped_us(const Entry& entry) const
    {
        return shared_.planner.hoped_us(shared_.costs(), shared_.cut.draw_us(entry),
                                        shared_.cut.hidden_share.value(),
                                        keep_table_.keep_probability(1));
    }

    AdaptiveShared& shared_;
    MethodTrials& trials_;

    // The round under way.
    std::vector<CutCandidate> round_;
    std::vector<CutCandidate> next_round_;
    std::vector<double> keep_; ///< of the front of round_: the chance to stay hidden, descending
    std::vector<Group> groups_;
    TestBatch batch_;
    std::vector<Ticket> tickets_;

    // Of the frame.
    uint32_t failed_groups_ = 0; ///< the last number given to a part of a failed group
    double kept_tests_ = 0.0;    ///< tests of what was hidden before
    double kept_ = 0.0;          ///< what was hidden before and was asked again

    // Over frames.
    KeepTable keep_table_;
    ScreenCoverage coverage_;
    std::vector<LateTest> late_;
    std::vector<uint64_t> turned_hidden_;
};

} // namespace occlude
