// Coherent hierarchical culling: temporal coherence hides the latency of occlusion queries.
//
// Implements  J. Bittner, M. Wimmer, H. Piringer, W. Purgathofer, "Coherent Hierarchical Culling:
//             Hardware Occlusion Queries Made Useful", Computer Graphics Forum 23(3), 2004; as in
//             Bittner, Mattausch, Wimmer, "Game-Engine-Friendly Occlusion Culling", ShaderX7 8.4.
// Map         Listing 8.4.1 main loop      -> Chc::cull_frame
//             ... process finished queries -> handle_finished_queries
//             ... hierarchical traversal   -> visit_node
//             HandleReturnedQuery          -> handle_returned_query
//             TraverseNode                 -> traverse_node
//             PullUpVisibility             -> pull_up_visibility
//             Q.visiblePixels > threshold  -> is_visible (cull_frame.h)
// Deviations  The listing prints its second `else` one level too far left, so that nodes outside
//             the frustum would be traversed; here it belongs to "was visible". A node counts as
//             visible before only if it was also visited in the frame before (rule R8). Boxes that
//             the near plane may touch are not tested (R1). Pulling up stops at the root (R9).
// Guarantees  exact with threshold 0: a previously hidden node is always tested in this frame, and
//             its result is used in this frame.
// Cost        about one test per visible leaf and one per node of the hidden boundary, each with
//             two changes of state: with many visible leaves this can be slower than frustum
//             culling.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/distance_queue.h>
#include <occlude/cull/parts/fifo.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace occlude {

struct ChcOptions {
    /// How visible leaves are tested.
    enum class VisibleTest : uint8_t {
        box,      ///< by their box, before they are drawn
        geometry, ///< by the samples that pass while they are drawn
    };
    VisibleTest visible_test = VisibleTest::box;
    /// A leaf that was found visible is drawn without a test for this many frames.
    uint32_t assume_visible_frames = 0;
    /// A node with at most this many visible samples is hidden. Above 0 the image is approximate.
    uint64_t threshold = 0;
};

class Chc final : public Culler {
public:
    using Options = ChcOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "chc",
        .paper = "Bittner, Wimmer, Piringer, Purgathofer 2004",
        .summary =
            "coherent hierarchical culling: draws visible leaves at once and tests them meanwhile",
        .needs = {.queries = true},
    };

    explicit Chc(HierarchyRef hierarchy, ChcOptions options = {})
        : Culler(hierarchy)
        , options_(clamped(options))
    {
    }

private:
    friend class CullerProbe; // of the tests
    struct NodeState {
        uint32_t last_visited = 0; ///< stamp of the last frame that visited it inside the frustum
        uint32_t next_test = 0;    ///< stamp from which a visible leaf is tested again
        bool visible = false;
        bool was_visible = false;
    };
    struct PendingQuery {
        Ticket ticket;
        NodeId node;
        PlaneMask mask;
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;
    Guarantee guarantee() const override { return by_threshold(options_.threshold); }

    void handle_finished_queries(CullFrame& frame);
    void visit_node(CullFrame& frame, DistanceQueue::Entry entry);
    void query_node(CullFrame& frame, NodeId node, PlaneMask mask);
    void handle_returned_query(CullFrame& frame, const PendingQuery& query, const Answer& answer);
    void traverse_node(CullFrame& frame, NodeId node, PlaneMask mask, Decision decision);
    void pull_up_visibility(NodeId node);

    ChcOptions options_;
    std::vector<NodeState> states_;
    DistanceQueue distance_queue_;
    Fifo<PendingQuery> query_queue_;
};

/// Names of the options for the registry; see registry.h.
constexpr std::array<std::string_view, 2> option_names(ChcOptions::VisibleTest)
{
    return {"box", "geometry"};
}
template <class Visit>
void visit_options(ChcOptions& o, Visit&& visit)
{
    visit("visible_test", o.visible_test,
          "how visible leaves are tested: by their box or by their geometry");
    visit("assume_visible_frames", o.assume_visible_frames, {0, 1'000'000},
          "frames for which a leaf that was found visible is drawn without a test");
    visit("threshold", o.threshold, {},
          "a node with at most this many visible samples is hidden; above 0 not exact");
}

} // namespace occlude
