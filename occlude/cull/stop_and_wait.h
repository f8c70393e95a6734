// Hierarchical stop-and-wait: the simplest exact culler with tests. `opt` records what it finds.
//
// Implements  the baseline that CHC (Bittner, Wimmer, Piringer, Purgathofer, "Coherent Hierarchical
//             Culling: Hardware Occlusion Queries Made Useful", 2004) is measured against: test a
//             node's box, wait for the answer, and only then go on.
// Map         visit(N) -> StopAndWait::cull_frame, one turn of its loop
// Deviations  none.
// Guarantees  exact with threshold 0: every leaf in the frustum is drawn, or lies in a node whose
//             test found nothing in this frame, against depth drawn in this frame (I1).
// Cost        one test and one wait per visited node: every visible inner node, every visible leaf,
//             and every hidden node whose parent is visible.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace occlude {

struct StopAndWaitOptions {
    /// A node with at most this many visible samples is hidden. Above 0 the image is approximate.
    uint64_t threshold = 0;
};

class StopAndWait final : public Culler {
public:
    using Options = StopAndWaitOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "stop_and_wait",
        .paper = "baseline",
        .summary = "tests each node and waits for the answer",
        .needs = {.queries = true},
        .remembers = false,
    };

    explicit StopAndWait(HierarchyRef hierarchy, StopAndWaitOptions options = {})
        : Culler(hierarchy)
        , options_(clamped(options))
    {
    }

private:
    struct Pending {
        NodeId node;
        PlaneMask mask;
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override {}
    Guarantee guarantee() const override { return by_threshold(options_.threshold); }

    StopAndWaitOptions options_;
    std::vector<Pending> stack_;
    std::vector<std::pair<float, NodeId>> children_;
};

template <class Visit>
void visit_options(StopAndWaitOptions& o, Visit&& visit)
{
    visit("threshold", o.threshold, {},
          "a node with at most this many visible samples is hidden; above 0 not exact");
}

} // namespace occlude
