// Two-level dynamic scenes. One list of active nodes covers the scene tree and the objects' own
// trees. Nodes whose boxes do not overlap on the screen are tested in parallel, and a node is
// tested the more rarely, the more often it was visible.
//
// Implements  V. Kovalcik, P. Tobola, "Fast Rendering of Complex Dynamic Scenes",
//             sections 3.3 and 3.4. The trees are hierarchy/builders/two_level.h.
// Map         Algorithm 2, rendering of a frame    -> TwoLevel::cull_frame
//               first loop, active queries         -> finish_queries
//               second loop, active nodes          -> process_active_nodes, issue_queries
//             Algorithm 3, FirstVisibilityTest     -> first_visibility_test
//               FrustumCulled                      -> frustum_culled
//               ViewerInside                       -> viewer_inside
//               WasInvisibleLastTime               -> was_invisible_last_time
//               ExamineRecentQueryResults, Fig. 3  -> examine_recent_query_results, postponement
//             Algorithm 4, ProcessVisibleNode      -> process_visible_node
//             list sorted by distance              -> insert, is_nearer
//             non-intersecting rectangles          -> overlaps_pending, ObjectSpaces::project
// Deviations  Limits that the paper leaves out are options: max_pending, history_length,
//             frames_per_visible, max_postponed. The list is sorted by the distance of the boxes
//             throughout; the paper sorts "approximately", the children of a node in its place.
//             An inner node is not tested while a child of it is visible (pull_up). "Viewer inside"
//             is rule R1: the near plane may touch the box. A node that comes back into the frustum
//             is tested (R8). Postponements are shortened at random (spread). Nodes that stayed
//             hidden are tested last and in groups (multiqueries), as in CHC++: they cause most of
//             the queries. A group that fails is halved, where CHC++ tests its nodes one by one.
//             The loop waits for the nearest query when there is nothing else to do.
// Guarantees  exact with threshold 0, whatever moves: a leaf in the frustum is drawn, or lies in a
//             node whose test found nothing in this frame (I1).
// Cost        one test per hidden node below a visible one, and one per visible node in
//             1 + postponement frames; with `disjoint`, one batch and one wait per layer of boxes
//             that overlap on the screen. On trees that are not two-level it works all the same,
//             without oriented boxes.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/multiquery.h>
#include <occlude/cull/parts/multiquery_value.h>
#include <occlude/cull/parts/object_spaces.h>

#include <cstdint>
#include <vector>

namespace occlude {

struct TwoLevelCullOptions {
    /// Boxes that overlap on the screen are tested one after the other, the nearer first, so that
    /// the farther is tested against what the nearer revealed. false: all at once.
    bool disjoint = true;
    /// The largest number of pending tests.
    uint32_t max_pending = 256;
    /// How many of its last results a node keeps.
    uint32_t history_length = 8;
    /// The test of a visible node is postponed by this many frames for each visible result among
    /// those that it keeps ...
    uint32_t frames_per_visible = 12;
    /// ... but by at most this many. 0: every node is tested in every frame.
    uint32_t max_postponed = 48;
    /// An inner node is not tested while one of its children is visible, because it is visible
    /// then, too. false: inner nodes are tested as leaves are, as in the paper.
    bool pull_up = true;
    /// Nodes that stayed hidden are tested last, when everything else is drawn, and several share
    /// one test if that is likely to pay (the multiqueries of CHC++). A group in which something is
    /// visible is halved until it is small. false: as in the paper.
    bool multiqueries = true;
    /// Shortens each postponement by a random share of up to one half, so that nodes that turn
    /// visible together are not tested together in all later frames. false: as in the paper.
    bool spread = true;
    /// A node with at most this many visible samples is hidden. Above 0 the image is approximate.
    uint64_t threshold = 0;
    uint64_t seed = 1;
};

class TwoLevel final : public Culler {
public:
    using Options = TwoLevelCullOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "two_level",
        .paper = "Kovalcik, Tobola (two-level BSP)",
        .summary = "for moving objects: tests boxes that do not overlap on the screen together",
        .needs = {.queries = true},
    };

    explicit TwoLevel(HierarchyRef hierarchy, TwoLevelCullOptions options = {});

private:
    friend class CullerProbe; // of the tests
    /// The memory of a node, by its key.
    struct NodeState {
        uint32_t last_visited = 0;  ///< stamp of the last frame that reached it inside the frustum
        uint32_t next_test = 0;     ///< stamp from which a visible node is tested again
        uint32_t child_seen = 0;    ///< stamp of the last frame in which a child was visible
        uint32_t frames_hidden = 0; ///< the number of consecutive tests that found it hidden
        uint32_t history = 0;       ///< the last results, one bit each; bit 0 is the latest, 1 is
                                    ///< visible
        bool visible = false;
    };
    /// A node in the list of active nodes.
    struct Active {
        NodeId node;
        NodeId parent; ///< invalid for the root
        PlaneMask mask = 0;
        float distance = 0.0f; ///< View::distance_key of its box
        SpacedBox test;        ///< the box that a test uses
        ScreenBounds screen;   ///< its rectangle on the screen, once it needs a test, if `disjoint`
    };
    /// A test of one or several active nodes. The batcher's members are indices into active_.
    using Query = MultiqueryBatcher::Test;
    enum class VisibilityResult : uint8_t { invisible, visible, need_query };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;
    void structure_changed() override;
    Guarantee guarantee() const override { return by_threshold(options_.threshold); }

    // --- Algorithm 2 ---
    void start_frame();
    void finish_queries(CullFrame& frame);
    bool finish_answered_queries(CullFrame& frame);
    void finish_query(CullFrame& frame, const Query& query, const Answer& answer);
    void handle_result(CullFrame& frame, uint32_t at, bool visible, Decision if_hidden);
    void process_active_nodes(CullFrame& frame);
    bool issue_queries(CullFrame& frame);
    auto add_boxes() const;
    void issue_disjoint(CullFrame& frame);
    void issue_parts(CullFrame& frame);
    void issue_groups(CullFrame& frame);
    bool overlaps_pending(const Active& active) const;
    size_t pending_limit(const CullFrame& frame) const;
    void submit(CullFrame& frame);

    // --- Algorithm 3 ---
    VisibilityResult first_visibility_test(CullFrame& frame, Active& active, Decision& if_visible);
    bool frustum_culled(CullFrame& frame, Active& active) const;
    NodeState& recall(const CullFrame& frame, NodeId node);
    bool viewer_inside(CullFrame& frame, Active& active);
    static bool was_invisible_last_time(const NodeState& state) { return !state.visible; }
    bool examine_recent_query_results(const CullFrame& frame, const NodeState& state) const;
    uint32_t postponement(const NodeState& state, uint32_t key, uint32_t stamp) const;

    // --- Algorithm 4 ---
    void process_visible_node(CullFrame& frame, uint32_t at, Decision decision);
    void insert(CullFrame& frame, NodeId node, NodeId parent, PlaneMask mask);
    bool is_nearer(uint32_t a, uint32_t b) const;

    uint32_t key_of(NodeId node) const;
    NodeState& state_of(NodeId node) { return states_[key_of(node)]; }

    TwoLevelCullOptions options_;
    std::vector<NodeState> states_; ///< by key
    uint64_t lineage_ = 0;          ///< the scene that the keys belong to
    KeepTable keep_table_;
    ObjectSpaces spaces_;

    std::vector<Active> active_; ///< all nodes that were active in this frame
    // The paper's list of active nodes, divided by what each node waits for:
    std::vector<uint32_t> fresh_;   ///< to be visited: a heap, the nearest first
    std::vector<uint32_t> waiting_; ///< for a test of its own, near to far
    std::vector<MultiqueryBatcher::Candidate> deferred_; ///< for the end of the frame, because it
                                                         ///< stayed hidden
    std::vector<Query> parts_;   ///< for a test: the parts of groups that failed
    std::vector<Query> pending_; ///< for an answer: tests in the order in which they were issued
    MultiqueryBatcher batcher_{kLeastHalved - 1};
};

/// Names of the options for the registry; see registry.h.
template <class Visit>
void visit_options(TwoLevelCullOptions& o, Visit&& visit)
{
    visit("disjoint", o.disjoint,
          "boxes that overlap on the screen are tested one after the other");
    visit("max_pending", o.max_pending, {1, 1'000'000}, "largest number of pending tests");
    visit("history_length", o.history_length, {1, 32},
          "number of latest results that a node keeps");
    visit("frames_per_visible", o.frames_per_visible, {0, 1'000'000},
          "frames by which a test is postponed for each kept \"visible\"");
    visit("max_postponed", o.max_postponed, {0, 1'000'000},
          "largest postponement of a test, in frames; 0: none");
    visit("pull_up", o.pull_up, "an inner node is not tested while one of its children is visible");
    visit("multiqueries", o.multiqueries, "test nodes that stay hidden last, several in one test");
    visit("spread", o.spread, "shorten postponements at random, so that tests spread over frames");
    visit("threshold", o.threshold, {},
          "a node with at most this many visible samples is hidden; above 0 not exact");
    visit("seed", o.seed, {}, "seed of the random shares of spread");
}

} // namespace occlude
