// The frames of `adaptive` that test on the device: rounds of tests, each for what the last one
// revealed, and tests of what is drawn whose answers are for a frame to come.
//
//    candidates --> collect_round --> add_tests, add_parts --> ask, wait --> hidden: kept
//         ^                               ^                         |        visible: drawn, or
//         +-- the parts of a node --------+-- the parts of a group -+                 opened
//
// Which candidates share a test, and what follows if it fails, is MultiqueryBatcher's work.
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
#include <occlude/cull/parts/multiquery.h>

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
    std::span<const uint64_t> turned_hidden() const { return late_.turned_hidden; }

    /// Tests the candidates in rounds, draws what shows, and tests what was drawn for frames to
    /// come. Precondition: what was visible is drawn. `since_us`: when drawing began.
    void test(CullFrame& frame, double since_us);

    /// Tests the finished frame, from the root down as far as that pays: what would tests hide?
    void probe(CullFrame& frame, double since_us);

private:
    using Entry = HierarchyCut::Entry;

    using Test = MultiqueryBatcher::Test; // of candidates: its members are indices into asked_
    /// A test of what is drawn, whose answer is for a frame to come.
    struct LateTest {
        Ticket ticket;
        uint64_t entry = 0; ///< its CutTraversal::name_of()
    };
    struct LateTests {
        std::vector<LateTest> pending;
        std::vector<uint64_t> turned_hidden; ///< names of entries, as answered in this frame
        TestBatch batch;
        std::vector<Ticket> tickets; ///< scratch, of `batch`
    };

    void test_in_rounds(CullFrame& frame, double since_us);
    void collect_round(CullFrame& frame, bool first_round);
    void open_near(CullFrame& frame, const CutCandidate& candidate);
    bool worth_testing(const Entry& entry) const;
    void end_rounds_unless_worthwhile(CullFrame& frame);
    void draw_untested(CullFrame& frame, const CutCandidate& candidate);

    void test_round(CullFrame& frame, bool first_round);
    void sort_for_groups();
    void line_up();
    size_t add_tests(CullFrame& frame, size_t first, size_t max_tests);
    size_t add_parts(CullFrame& frame, size_t first, size_t max_tests);
    auto add_boxes(CullFrame& frame) const;
    void ask(CullFrame& frame, bool first_round);
    void take_answers(CullFrame& frame, std::span<const Test> tests);
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
    std::vector<CutCandidate> round_; ///< all that it tests
    std::vector<CutCandidate> next_round_;
    std::vector<MultiqueryBatcher::Candidate> in_line_; ///< of round_, those not in parts_
    std::vector<Test> parts_;                           ///< of groups that failed before
    std::vector<Test> next_parts_;                      ///< ... and in this round

    // Of the frame.
    MultiqueryBatcher batcher_;
    std::vector<CutCandidate> asked_;
    double kept_tests_ = 0.0; ///< tests of what was hidden before
    double kept_ = 0.0;       ///< what was hidden before and was asked again

    // Over frames.
    KeepTable keep_table_;
    ScreenCoverage coverage_;
    LateTests late_;
};

} // namespace occlude
