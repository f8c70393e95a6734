// CHC++: coherent hierarchical culling with batched queries, for engines that sort by state.
//
// Implements  O. Mattausch, J. Bittner, M. Wimmer, "CHC++: Coherent Hierarchical Culling
//             Revisited", Computer Graphics Forum 27(2), 2008; as in Bittner, Mattausch, Wimmer,
//             "Game-Engine-Friendly Occlusion Culling", ShaderX7 8.4.
// Map         Listing 8.4.2 main loop      -> ChcPlusPlus::cull_frame
//             HandleReturnedQuery          -> handle_returned_query
//             TraverseNode                 -> traverse_node
//             PullUpVisibility             -> pull_up_visibility
//             QueryPreviouslyInvisibleNode -> query_previously_invisible_node
//             QueryReasonable, Fig. 8.4.4  -> query_reasonable, first_test_after
//             IssueMultiQueries            -> issue_multiqueries
//             GetNextMultiQuery            -> MultiqueryBatcher::add_groups (multiquery.h)
//             IssueQuery                   -> submit
//             Tighter bounding volumes     -> TightBounds::collect
//             Render queue                 -> CullFrame::draw_leaf, flush_draws
//             Depth-only pass              -> Options::depth_only_pass
// Deviations  The head of the listing is lost in the printed text and is rebuilt from the prose.
//             The result loop breaks out while nodes remain to be traversed; otherwise the
//             algorithm would be stop-and-wait per batch. Nodes of a failed multiquery are tested
//             one by one at once: back in the i-queue, they could form the same group again. The
//             results of the v-queue are read before the frame ends: read later, the whole visible
//             tree would be classified as hidden. Random numbers are hashes of (seed, node, frame),
//             so that runs repeat. As in chc.h: rules R1, R8, R9.
// Guarantees  exact with threshold 0, with every combination of the switches. After a frame all
//             queues are empty (I2), and a leaf in the frustum is drawn, or covered by a test of
//             this frame that found nothing (I1). Rules and invariants: docs/conventions.md.
// Cost        typically one test per ten visible leaves and one per five to fifty hidden nodes, and
//             tens of state changes per frame.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/distance_queue.h>
#include <occlude/cull/parts/fifo.h>
#include <occlude/cull/parts/multiquery.h>
#include <occlude/cull/parts/multiquery_value.h>
#include <occlude/cull/parts/tight_bounds.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace occlude {

struct ChcPlusPlusOptions {
    /// b: the i-queue is tested when it holds this many nodes. 1 switches batching off.
    uint32_t batch_size = 50;
    /// Visible leaves wait in the v-queue, and their tests fill waits. false: they are tested when
    /// they are reached.
    bool v_queue = true;
    /// How many leaves of the v-queue are tested during one wait. The paper takes one; each costs a
    /// flush.
    uint32_t v_fill = 16;
    /// Leaves wait in the render queue until the next batch of tests. false: they are drawn one by
    /// one.
    bool render_queue = true;
    /// The render queue is flushed before a batch of tests only if it holds at least this many
    /// triangles. A larger number saves flushes, but occluders are drawn later and fewer nodes are
    /// hidden.
    uint32_t min_render_triangles = 0;
    /// n_av: a visible leaf is tested every this many frames.
    uint32_t assume_visible_frames = 10;
    /// Randomises the first test of a leaf that turned visible; false: after n_av frames.
    bool jitter = true;
    /// d_max: how many levels below a node its tight bounds may come from. 0: its own box only. The
    /// paper takes 3 because its boxes are nearly free. On software OpenGL, where a box costs as
    /// much as dozens of triangles, 1 is faster (docs/algorithms/chc_plus_plus.md).
    uint32_t tight_bounds_depth = 1;
    /// s_max: the area of the tight bounds is at most this many times the area of the node's box.
    float tight_bounds_area = 1.4f;
    /// Virtual leaves of the hierarchy count as leaves. false: only nodes without children do.
    bool virtual_leaves = true;

    enum class Multiqueries : uint8_t {
        off,      ///< one test per node
        analytic, ///< p_keep by the paper's formula: groups of at most 11 nodes
        measured, ///< p_keep by the measured table: larger groups of long-hidden nodes
    };
    Multiqueries multiqueries = Multiqueries::measured;

    /// Tests against a depth-only pass, then shades everything visible in one batch.
    bool depth_only_pass = false;
    /// A node with at most this many visible samples is hidden. Above 0 the image is approximate.
    uint64_t threshold = 0;
    uint64_t seed = 1;
};

class ChcPlusPlus final : public Culler {
public:
    using Options = ChcPlusPlusOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "chc_plus_plus",
        .paper = "Mattausch, Bittner, Wimmer 2008",
        .summary = "CHC with batched tests, multiqueries and tight bounds",
        .needs = {.queries = true},
    };

    explicit ChcPlusPlus(HierarchyRef hierarchy, ChcPlusPlusOptions options = {});

private:
    friend class CullerProbe; // of the tests
    struct NodeState {
        uint32_t last_visited = 0;  ///< stamp of the last frame that visited it inside the frustum
        uint32_t next_test = 0;     ///< stamp from which a visible leaf is tested again
        uint32_t frames_hidden = 0; ///< i: the number of consecutive tests that found it hidden
        PlaneMask mask = 0;         ///< frustum planes that its children must be tested against in
                                    ///< this frame
        bool visible = false;
        bool was_visible = false;
    };
    using PendingQuery = MultiqueryBatcher::Test;

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;
    Guarantee guarantee() const override { return by_threshold(options_.threshold); }

    bool is_leaf(NodeId node) const;
    void visit_node(CullFrame& frame, DistanceQueue::Entry entry);
    bool query_reasonable(const CullFrame& frame, NodeId node) const;
    void traverse_node(CullFrame& frame, NodeId node, Decision decision);
    void pull_up_visibility(NodeId node);
    uint32_t first_test_after(uint32_t stamp, NodeId node) const;

    void handle_results(CullFrame& frame);
    void handle_returned_query(CullFrame& frame, const PendingQuery& query, const Answer& answer);
    void handle_node(CullFrame& frame, NodeId node, bool visible, Decision if_hidden);

    void query_previously_invisible_node(CullFrame& frame, NodeId node);
    void issue_multiqueries(CullFrame& frame);
    void issue_visible(CullFrame& frame, size_t count);
    double keep_probability(NodeId node) const;
    auto add_boxes(CullFrame& frame);
    void add_test(CullFrame& frame, NodeId node);
    void submit(CullFrame& frame);

    ChcPlusPlusOptions options_;
    std::vector<NodeState> states_;
    KeepTable keep_table_;

    DistanceQueue distance_queue_;
    Fifo<PendingQuery> query_queue_;
    std::vector<NodeId> i_queue_; ///< previously invisible nodes to be tested
    Fifo<NodeId> v_queue_;        ///< previously visible leaves to be tested

    MultiqueryBatcher batcher_; ///< its members are node ids
    std::vector<MultiqueryBatcher::Candidate> candidates_;
    TightBounds tight_bounds_;
};

/// Names of the options for the registry; see registry.h.
constexpr std::array<std::string_view, 3> option_names(ChcPlusPlusOptions::Multiqueries)
{
    return {"off", "analytic", "measured"};
}
template <class Visit>
void visit_options(ChcPlusPlusOptions& o, Visit&& visit)
{
    visit("batch_size", o.batch_size, {1, 1'000'000},
          "b: the i-queue is tested when it holds this many nodes; 1: no batching");
    visit("v_queue", o.v_queue, "visible leaves wait in the v-queue, and their tests fill waits");
    visit("v_fill", o.v_fill, {1, 1'000'000},
          "how many leaves of the v-queue are tested during one wait");
    visit("render_queue", o.render_queue,
          "leaves wait in the render queue until the next batch of tests");
    visit("min_render_triangles", o.min_render_triangles, {},
          "the render queue is flushed before tests only if it holds this many triangles");
    visit("assume_visible_frames", o.assume_visible_frames, {1, 1'000'000},
          "n_av: a visible leaf is tested every this many frames");
    visit("jitter", o.jitter, "randomise the first test of a leaf that turned visible");
    visit("tight_bounds_depth", o.tight_bounds_depth, {0, 32},
          "d_max: levels below a node that its tight bounds come from; 0: off");
    visit("tight_bounds_area", o.tight_bounds_area, {0.0f, 1000.0f},
          "s_max: largest area of the tight bounds, in areas of the node's box");
    visit("virtual_leaves", o.virtual_leaves, "count virtual leaves of the hierarchy as leaves");
    visit("multiqueries", o.multiqueries,
          "whether nodes that stay hidden share a test, and by which probability");
    visit("depth_only_pass", o.depth_only_pass,
          "cull in a depth-only pass, then shade in one batch");
    visit("threshold", o.threshold, {},
          "a node with at most this many visible samples is hidden; above 0 not exact");
    visit("seed", o.seed, {}, "seed of the jitter");
}

} // namespace occlude
