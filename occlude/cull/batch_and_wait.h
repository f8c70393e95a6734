// Occlusion queries used properly: n queries, then n results.
//
// Implements  D. Sekulic, "Efficient Occlusion Culling", GPU Gems, 2004, ch. 29, section 29.3.
// Map         29.3.1, "for each of n queries": issue    -> BatchAndWait::test_batch
//             29.3.1, "for each of n queries": result   -> BatchAndWait::handle_results
//             29.3.2, occluders first                   -> BatchAndWait::is_occluder
//             29.4.1, opaque front to back              -> ObjectTests::collect_near_to_far
//             29.3.1, passes after the first only if seen -> Options::depth_only_pass
//             29.5.1, 29.6.1, 29.6.2                    -> ObjectTestOptions
// Deviations  Objects are tested near to far in groups of n, so that a group is tested against what
//             earlier groups drew. The chapter tests all n objects of the scene at once (a large
//             batch_size does that). The chapter leaves open which geometry is drawn first without
//             a test: here, objects whose box covers much of the screen. If the eye is in a box,
//             the chapter offers to draw back faces, which is not conservative, or not to test;
//             this class does not test (rule R1).
// Guarantees  exact with threshold 0: every object in the frustum is drawn, or its own test found
//             nothing in this frame.
// Cost        one test and one wait per object in the frustum, one change of state per n tests and
//             back: no hierarchy saves tests, and no coherence.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/object_tests.h>

#include <cstdint>
#include <vector>

namespace occlude {

struct BatchAndWaitOptions {
    /// n: queries issued before the first of their results is read. 0: as many as the device can
    /// hold.
    uint32_t batch_size = 32;
    /// Objects whose box covers at least this share of the screen are drawn first, untested.
    float occluder_share = 0.1f;
    /// An object with at most this many visible samples is hidden. Above 0 the image is
    /// approximate.
    uint64_t threshold = 0;
    /// Draws a depth-only pass and tests against it, then shades everything drawn in one batch.
    bool depth_only_pass = false;
    ObjectTestOptions tests = {};
};

class BatchAndWait final : public Culler {
public:
    using Options = BatchAndWaitOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "batch_and_wait",
        .paper = "Sekulic 2004, 29.3",
        .summary = "tests objects near to far: issues n queries, then reads n results",
        .needs = {.queries = true},
        .node_use = NodeUse::leaves,
        .remembers = false,
    };

    explicit BatchAndWait(HierarchyRef hierarchy, BatchAndWaitOptions options = {})
        : Culler(hierarchy)
        , options_(clamped(options))
        , tests_(options_.tests)
    {
    }

private:
    void cull_frame(CullFrame& frame) override;
    void reset_state() override {}
    Guarantee guarantee() const override { return by_threshold(options_.threshold); }

    bool is_occluder(const CullFrame& frame, NodeId node) const;
    void test_batch(CullFrame& frame, std::span<const ObjectTests::Object> objects);
    void handle_results(CullFrame& frame, std::span<const ObjectTests::Object> objects);

    BatchAndWaitOptions options_;
    ObjectTests tests_;
    std::vector<ObjectTests::Object> tested_; ///< objects that are neither near nor occluders
    TestBatch batch_;
    std::vector<Ticket> tickets_;
};

template <class Visit>
void visit_options(BatchAndWaitOptions& o, Visit&& visit)
{
    visit("batch_size", o.batch_size, {0, 65536},
          "n: queries issued before the first result is read; 0: as many as the device holds");
    visit("occluder_share", o.occluder_share, {0.0f, 2.0f},
          "objects that cover at least this share of the screen are drawn first, untested");
    visit("threshold", o.threshold, {},
          "an object with at most this many visible samples is hidden; above 0 not exact");
    visit("depth_only_pass", o.depth_only_pass,
          "test against a depth-only pass, then shade in one batch");
    visit_options(o.tests, visit);
}

} // namespace occlude
