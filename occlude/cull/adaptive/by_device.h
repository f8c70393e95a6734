// The frames of `adaptive` that test on the device. Each round tests the nodes that the round
// before it revealed. What is drawn is tested too, and those answers are read in a later frame.
//
//    candidates --> collect_round --> add_tests, add_parts --> ask, wait --> hidden: kept
//         ^                               ^                         |        visible: drawn, or
//         +-- the parts of a node --------+-- the parts of a group -+                 opened
//
// MultiqueryBatcher decides which candidates share a test, and how a failed group is split.
//
//    what is drawn --> retest --> the answers come in a later frame --> turned_hidden()
//
// Guarantees  It never tests a box that the near plane may touch (C5), and never has more unspent
//             tickets than the device can hold (C11).
// Cost        A round costs one wait. Rounds end when the next one would hide less than it costs.
#pragma once

#include <occlude/cull/adaptive/method_trials.h>
#include <occlude/cull/adaptive/shared.h>
#include <occlude/cull/parts/coverage.h>
#include <occlude/cull/parts/multiquery.h>
#include <occlude/cull/parts/multiquery_value.h>

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
    /// Moves the tickets of late tests to `tickets`. Their answers are not needed any more, but the
    /// caller must spend the tickets.
    void drop_late_tests(std::vector<Ticket>& tickets);

    // --- one frame, in order ---

    /// Reads the late answers that have arrived.
    void take_late_answers(CullFrame& frame);
    /// Names (CutTraversal::name_of()) of entries that were visible and were found hidden,
    /// ascending.
    std::span<const uint64_t> turned_hidden() const { return late_.turned_hidden; }

    /// Tests the candidates in rounds, draws the visible ones, and tests what was drawn for later
    /// frames. `since_us` is the time at which drawing began. Precondition: the entries that were
    /// visible in the last frame are drawn.
    void test(CullFrame& frame, double since_us);

    /// Tests the finished frame from the root down to the nodes that pay, to estimate how much
    /// tests would hide.
    void probe(CullFrame& frame, double since_us);

private:
    using Entry = HierarchyCut::Entry;

    using Test = MultiqueryBatcher::Test; // a test of candidates; its members are indices into
                                          // asked_
    /// A test of a drawn entry, whose answer a later frame reads.
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

    // The current round.
    std::vector<CutCandidate> round_; ///< all candidates that it tests
    std::vector<CutCandidate> next_round_;
    std::vector<MultiqueryBatcher::Candidate> in_line_; ///< the candidates of round_ that are not
                                                        ///< in parts_
    std::vector<Test> parts_;                           ///< parts of groups that failed in the
                                                        ///< round before
    std::vector<Test> next_parts_;                      ///< parts of groups that failed in this
                                                        ///< round

    // Per frame.
    MultiqueryBatcher batcher_;
    std::vector<CutCandidate> asked_;
    double kept_tests_ = 0.0; ///< tests of entries that were hidden in the last frame
    double kept_ = 0.0;       ///< entries that were hidden in the last frame and were tested again

    // Kept between frames.
    KeepTable keep_table_;
    ScreenCoverage coverage_;
    LateTests late_;
};

} // namespace occlude
