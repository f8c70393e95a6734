// Two-level dynamic scenes: a list of active nodes of the scene tree and of the objects' own trees,
// tested in parallel where their boxes do not overlap on the screen, and the more rarely the longer
// they have been visible.
//
// Implements  V. Kovalcik, P. Tobola, "Fast Rendering of Complex Dynamic Scenes",
//             sections 3.3 and 3.4. The trees are hierarchy/builders/two_level.h.
// Map         Algorithm 2, rendering of a frame -> TwoLevel::cull_frame, finish_queries,
//                                                  process_active
//             Algorithm 3, FirstVisibilityTest  -> first_visibility_test, postponement
//             Algorithm 4, ProcessVisibleNode   -> process_visible_node
//             list sorted by distance           -> insert, is_nearer
//             non-intersecting rectangles       -> overlaps_pending, screen/projection.h
// Deviations  Limits that the paper leaves out are options: max_pending, history_length,
//             frames_per_visible, max_postponed. The list is sorted by the distance of the boxes
//             throughout; the paper sorts "approximately", the children of a node in its place.
//             An inner node is not tested while a child of it is visible (pull_up). "Viewer inside"
//             is rule R1: the near plane may touch the box. A node that comes back into the frustum
//             is tested (R8). Postponed tests are spread in time (spread). Nodes that stayed hidden
//             are tested last and in groups (multiqueries), as CHC++ does it: they are most of the
//             queries. A group that fails is halved, where CHC++ tests its nodes one by one. The
//             loop waits for the nearest query when there is nothing else to do.
// Guarantees  exact with threshold 0, whatever moves: a leaf in the frustum is drawn, or lies in a
//             node whose test found nothing in this frame.
// Cost        one test per hidden node below a visible one, and one per visible node in each
//             1 + postponement frames; with `disjoint`, one batch and one wait per layer of boxes
//             that overlap on the screen. On trees that are not two-level it works all the same,
//             without oriented boxes.
#pragma once

#include <occlude/cull/culler.h>
#include <occlude/cull/parts/chc_plus_plus_math.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/screen/projection.h>

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
    /// The test of a visible node is postponed by this many frames for each "visible" among them
    /// ...
    uint32_t frames_per_visible = 12;
    /// ... up to this many. 0: every node is tested in every frame.
    uint32_t max_postponed = 48;
    /// An inner node is not tested while one of its children is visible: then it is, too. false:
    /// inner nodes are tested as leaves are.
    bool pull_up = true;
    /// Nodes that stayed hidden are tested last, when everything else is drawn, and several in one
    /// test where that is likely to pay (the multiqueries of CHC++); a group in which something is
    /// visible is halved until it is small. false: as the paper has it.
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
    bool idle() const
    {
        return fresh_.empty() && waiting_.empty() && deferred_.empty() && halves_.empty() &&
               pending_.empty();
    }

private:
    /// What is remembered of a node, by its key.
    struct NodeState {
        uint32_t last_visited = 0;  ///< stamp of the last frame in which it was reached inside
        uint32_t next_test = 0;     ///< stamp from which a visible node is tested again
        uint32_t child_seen = 0;    ///< stamp of the last frame in which a child was visible
        uint32_t frames_hidden = 0; ///< how many tests in a row found it hidden
        uint32_t history = 0;       ///< the last results, newest in bit 0; 1 is visible
        bool visible = false;
    };
    /// A node in the list of active nodes.
    struct Active {
        NodeId node;
        NodeId parent; ///< invalid for the root
        PlaneMask mask = 0;
        float distance = 0.0f; ///< View::distance_key of its box
        ScreenBounds screen;   ///< once it needs a test, if `disjoint`
        Aabb box;              ///< once it needs a test: as handed to it
        const glm::mat4* world_from_box = nullptr;
    };
    /// A test under way.
    struct PendingTest {
        Ticket ticket;
        uint32_t first = 0; ///< into tested_: the nodes that it is of
        uint32_t count = 0;
    };
    struct Deferred {
        uint32_t at = 0;   ///< into active_
        double keep = 0.0; ///< the probability that it stays hidden
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
    bool process_active(CullFrame& frame);
    void reach_fresh(CullFrame& frame);
    void issue_waiting(CullFrame& frame);
    FirstResult first_visibility_test(CullFrame& frame, Active& active, Decision& if_visible);
    void prepare_query(CullFrame& frame, Active& active);
    bool overlaps_pending(const Active& active) const;
    void add_test(std::span<const uint32_t> entries);
    void issue_halves(CullFrame& frame);
    void issue_deferred(CullFrame& frame);
    void submit(CullFrame& frame);
    void handle_test(CullFrame& frame, const PendingTest& test, const Answer& answer);
    void handle_result(CullFrame& frame, uint32_t at, bool visible, Decision if_hidden);
    uint32_t postponement(const NodeState& state, uint32_t key, uint32_t stamp) const;

    void process_visible_node(CullFrame& frame, uint32_t at, Decision decision);
    void insert(CullFrame& frame, NodeId node, NodeId parent, PlaneMask mask);
    bool is_nearer(uint32_t a, uint32_t b) const;

    uint32_t key_of(NodeId node) const;
    NodeState& state_of(NodeId node) { return states_[key_of(node)]; }
    const ObjectView& object_view(CullFrame& frame, uint32_t object);

    TwoLevelCullOptions options_;
    std::vector<NodeState> states_; ///< by key
    uint64_t lineage_ = 0;          ///< whose keys they are

    std::vector<Active> active_;     ///< all that were active in this frame; the list of those ...
    std::vector<uint32_t> fresh_;    ///< ... not reached yet: a heap, the nearest first
    std::vector<uint32_t> waiting_;  ///< ... that need a test of their own, near to far
    std::vector<Deferred> deferred_; ///< ... that stayed hidden and are tested last
    std::vector<PendingTest> pending_; ///< ... with a test under way, as issued
    std::vector<PendingTest> halves_;  ///< ... in halves of groups in which something is visible
    std::vector<uint32_t> tested_;     ///< the nodes of all tests of this frame, test by test

    TestBatch batch_;
    std::vector<PendingTest> collected_; ///< what the tests of `batch_` are of
    std::vector<Ticket> tickets_;
    KeepTable keep_table_;
    std::vector<double> keep_; ///< scratch, as is:
    std::vector<uint32_t> ordered_;
    std::vector<ObjectView> object_views_;
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
    visit("pull_up", o.pull_up, "an inner node is not tested while a child of it is visible");
    visit("multiqueries", o.multiqueries, "test long-hidden nodes last, several at a time");
    visit("spread", o.spread, "shorten postponements at random, so that tests spread in time");
    visit("threshold", o.threshold, "samples up to which a node is hidden; above 0 not exact");
    visit("seed", o.seed, "of the spreading");
}

} // namespace occlude
