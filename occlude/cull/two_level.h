// Two-level dynamic scenes: a list of active nodes of the scene tree and of the objects' own trees,
// tested in parallel where their boxes do not overlap on the screen, and the more rarely the longer
// they have been visible.
//
// Implements  V. Kovalcik, P. Tobola, "Real-Time Rendering of Dynamic Scenes" (two-level BSP),
//             sections 3.3 and 3.4. The trees are hierarchy/two_level.h.
// Map         Algorithm 2, rendering of a frame -> TwoLevel::cull_frame, finish_queries,
//                                                  process_active
//             Algorithm 3, FirstVisibilityTest  -> first_visibility_test, postponement
//             Algorithm 4, ProcessVisibleNode   -> process_visible_node, insert_children
//             non-intersecting rectangles       -> overlaps_pending, core/projection.h
// Deviations  Limits that the paper leaves out are options: max_pending, history_length,
//             frames_per_visible, max_postponed. A node whose query is pending keeps its place in the
//             list, so that nothing has to be sorted again. "Viewer inside" is rule R1: the near
//             plane may touch the box. A node that comes back into the frustum is tested (R8).
//             Postponed tests are spread in time (spread). Nodes that stayed hidden are tested last
//             and in groups (multiqueries), as CHC++ does it: they are most of the queries. The loop waits for the nearest query
//             when there is nothing else to do.
// Guarantees  exact with threshold 0, whatever moves: a leaf in the frustum is drawn, or lies in a
//             node whose test found nothing in this frame.
// Cost        one test per hidden node below a visible one, and one per visible node in each
//             1 + postponement frames; with `disjoint`, one batch and one wait per layer of boxes
//             that overlap on the screen. On trees that are not two-level it works all the same,
//             without oriented boxes.
#pragma once

#include <occlude/core/projection.h>
#include <occlude/cull/chc_plus_plus_math.h>
#include <occlude/cull/cull_frame.h>
#include <occlude/cull/culler.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

struct TwoLevelCullOptions {
    /// Boxes that overlap on the screen are not tested at the same time, the nearer first: the
    /// farther is then tested against what the nearer let be drawn. false: all at once.
    bool disjoint = true;
    /// How many tests may be pending at a time; at least 1.
    uint32_t max_pending = 256;
    /// How many of its last results a node remembers: 1 to 32.
    uint32_t history_length = 8;
    /// The test of a visible node is postponed by this many frames for each "visible" among them ...
    uint32_t frames_per_visible = 6;
    /// ... up to this many. 0: every node is tested in every frame.
    uint32_t max_postponed = 48;
    /// Nodes that stayed hidden are tested last, when everything else is drawn, and several in one
    /// test where that is likely to pay (the multiqueries of CHC++). false: as the paper has it.
    bool multiqueries = true;
    /// Shortens each postponement by a random part of up to a half, so that nodes that turned
    /// visible together are not tested together for ever after.
    bool spread = true;
    /// A node with at most this many visible samples is hidden. Above 0 the image is approximate.
    uint64_t threshold = 0;
    uint64_t seed = 1;
};

class TwoLevel final : public Culler {
public:
    explicit TwoLevel(const Hierarchy& hierarchy, TwoLevelCullOptions options = {});

    /// True if no node is left in the list; holds after every frame.
    bool idle() const { return head_ == kEnd && pending_.empty(); }

private:
    static constexpr uint32_t kEnd = 0xffffffffu;

    /// What is remembered of a node, by its key.
    struct NodeState {
        uint32_t last_visited = 0;  ///< stamp of the last frame in which it was reached inside
        uint32_t next_test = 0;     ///< stamp from which a visible node is tested again
        uint32_t frames_hidden = 0; ///< how many tests in a row found it hidden
        uint32_t history = 0;       ///< the last results, newest in bit 0; 1 is visible
        bool visible = false;
    };
    enum class Stage : uint8_t { fresh, needs_query, deferred, pending };
    /// A node in the list of active nodes.
    struct Active {
        NodeId node;
        PlaneMask mask = 0;
        Stage stage = Stage::fresh;
        uint32_t next = kEnd; ///< the next farther one
        uint32_t previous = kEnd;
        ScreenBounds screen; ///< from needs_query on, if `disjoint`
        Aabb box;            ///< from needs_query on: as handed to the test
        const glm::mat4* world_from_box = nullptr;
    };
    /// A test under way.
    struct PendingTest {
        Ticket ticket;
        uint32_t first = 0; ///< into tested_: the nodes that it is of
        uint32_t count = 0;
    };
    enum class FirstResult : uint8_t { invisible, visible, needs_query };
    /// What one object's space needs in one frame.
    struct ObjectView {
        uint32_t stamp = 0;
        View view;           ///< from the object's space
        float shrink = 0.0f; ///< object lengths per world length, at most; 0: no usable map
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;
    void structure_changed() override;
    Guarantee guarantee() const override;

    bool poll_pending(CullFrame& frame);
    void finish_queries(CullFrame& frame);
    size_t pending_limit(const CullFrame& frame) const;
    bool reach(CullFrame& frame, uint32_t at);
    bool process_active(CullFrame& frame);
    FirstResult first_visibility_test(CullFrame& frame, Active& active, Decision& if_visible);
    void prepare_query(CullFrame& frame, Active& active);
    bool overlaps_pending(const Active& active) const;
    void add_test(std::span<const uint32_t> entries);
    void issue_deferred(CullFrame& frame);
    void submit(CullFrame& frame);
    void handle_test(CullFrame& frame, const PendingTest& test, const Answer& answer);
    void handle_result(CullFrame& frame, uint32_t at, bool visible, Decision if_hidden);
    uint32_t postponement(const NodeState& state, uint32_t key, uint32_t stamp) const;

    void process_visible_node(CullFrame& frame, uint32_t at, Decision decision);
    void insert_children(CullFrame& frame, uint32_t after, NodeId node, PlaneMask mask);
    uint32_t insert_after(uint32_t after, NodeId node, PlaneMask mask);
    void erase(uint32_t at);

    uint32_t key_of(NodeId node) const;
    NodeState& state_of(NodeId node) { return states_[key_of(node)]; }
    const ObjectView& object_view(CullFrame& frame, uint32_t object);

    TwoLevelCullOptions options_;
    std::vector<NodeState> states_; ///< by key
    uint64_t lineage_ = 0;          ///< whose keys they are

    std::vector<Active> active_; ///< the list of active nodes, near to far by `next` ...
    uint32_t head_ = kEnd;
    uint32_t free_ = kEnd;
    std::vector<PendingTest> pending_; ///< ... of these, those with a query under way, as issued
    std::vector<uint32_t> tested_;     ///< the nodes of all tests of this frame, test by test

    TestBatch batch_;
    std::vector<PendingTest> collected_; ///< what the tests of `batch_` are of
    std::vector<Ticket> tickets_;
    KeepTable keep_table_;
    struct Deferred {
        double keep; ///< the probability that it stays hidden
        uint32_t entry;
        uint32_t order;
    };
    std::vector<Deferred> deferred_;
    std::vector<double> keep_;
    std::vector<uint32_t> group_;
    std::vector<ObjectView> object_views_;
    struct Child {
        bool is_object;
        float distance;
        NodeId node;
    };
    std::vector<Child> children_;
};

/// Names of the options for the registry; see registry.h.
template <class Visit>
void visit_options(TwoLevelCullOptions& o, Visit&& visit)
{
    visit("disjoint", o.disjoint,
          "boxes that overlap on the screen are tested one after the other");
    visit("max_pending", o.max_pending, "tests that may be pending at a time");
    visit("history_length", o.history_length, "results that a node remembers, 1 to 32");
    visit("frames_per_visible", o.frames_per_visible,
          "frames that a test is postponed for each remembered \"visible\"");
    visit("max_postponed", o.max_postponed, "frames that a test is postponed at most; 0: never");
    visit("multiqueries", o.multiqueries, "test long-hidden nodes last, several at a time");
    visit("spread", o.spread, "shorten postponements at random, so that tests spread in time");
    visit("threshold", o.threshold, "samples up to which a node is hidden; above 0 not exact");
    visit("seed", o.seed, "of the spreading");
}

} // namespace occlude
