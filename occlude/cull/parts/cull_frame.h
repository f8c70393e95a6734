// One frame of one culler. An algorithm talks to the device only through this class, so that the
// counters, the decision log and the list of drawn items always agree.
//
// Item flags work the same for all algorithms, which need not know them:
//   never_cull     queued before everything else, in the frustum or not; later requests are ignored
//   never_occlude  set aside, and drawn when all tests are done
//   translucent    set aside, and drawn after everything else, back to front
// Setting items aside is exact: what was hidden when its node was tested stays hidden, whatever is
// drawn later.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/core/frame_report.h>
#include <occlude/core/query_device.h>
#include <occlude/core/view.h>
#include <occlude/cull/parts/frame_record.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/screen/projection.h>

#include <span>
#include <vector>

namespace occlude {

/// Tests collected for one batch: boxes, and where each test ends.
class TestBatch {
public:
    void clear()
    {
        boxes_.clear();
        ends_.clear();
    }
    bool empty() const { return ends_.empty(); }
    size_t test_count() const { return ends_.size(); }

    /// Adds a box to the test being collected.
    void add_box(const Aabb& inflated_box, NodeId subject)
    {
        boxes_.push_back({inflated_box, nullptr, subject});
    }
    /// Adds a box in the space of `world_from_box`, which must live until the batch is issued.
    void add_box(const Aabb& inflated_box, const glm::mat4& world_from_box, NodeId subject)
    {
        boxes_.push_back({inflated_box, &world_from_box, subject});
    }
    /// Ends the test being collected. Precondition: it has a box.
    void end_test()
    {
        OCCLUDE_ASSERT(boxes_.size() > (ends_.empty() ? 0 : ends_.back()), "a test has a box (C6)");
        ends_.push_back(static_cast<uint32_t>(boxes_.size()));
    }

    std::span<const QueryBox> boxes() const { return boxes_; }
    std::span<const uint32_t> test_ends() const { return ends_; }

private:
    std::vector<QueryBox> boxes_;
    std::vector<uint32_t> ends_;
};

class CullFrame {
public:
    /// Begins the device's frame and clears `record`. All references must outlive the frame.
    CullFrame(const Hierarchy& hierarchy, FrameRecord& record, const View& view,
              QueryDevice& device, FrameReport& report);
    /// Ends the device's frame if the device threw before finish().
    ~CullFrame();
    CullFrame(const CullFrame&) = delete;
    CullFrame& operator=(const CullFrame&) = delete;

    const View& view() const { return view_; }
    const Hierarchy& hierarchy() const { return hierarchy_; }
    const DeviceCaps& caps() const { return device_.caps(); }
    /// Counts from 1 since the last reset, so that 0 can mean "never".
    uint32_t stamp() const { return static_cast<uint32_t>(report_.frame) + 1; }
    FrameCounters& counters() { return report_.counters; }
    const FrameCounters& counters() const { return report_.counters; }
    /// The report's plan, for algorithms that choose between ways of making a frame.
    FramePlan& plan() { return report_.plan; }

    // --- looking ---

    /// True unless the node is outside the frustum; logs it if so. Clears from `mask` the planes
    /// that its descendants need not test. Counts one visited node.
    bool visit(NodeId node, PlaneMask& mask);

    /// The same as visit(), for one item of node `owner` by its position in Hierarchy::items(). The
    /// log names the item.
    bool visit_item(NodeId owner, ItemPosition at, PlaneMask& mask);

    /// The same as visit(), but tests the ball around the node's box first
    /// (classify_sphere_first()), and the box only if it is longer than `elongation`. Also true for
    /// some nodes outside the frustum.
    bool visit_sphere_first(NodeId node, PlaneMask& mask, float elongation);

    /// Rule R1: true if the near plane may touch the node's inflated box, so that it must not be
    /// tested.
    bool near(NodeId node) const;

    /// The node's box as a test must see it: inflated (rule R2).
    Aabb test_box(NodeId node) const { return view_.inflated_for_test(hierarchy_.node(node).box); }

    // --- drawing ---

    /// Queues the items of a leaf that are not outside the planes in `mask`.
    void draw_leaf(NodeId leaf, PlaneMask mask, Decision decision);
    /// Queues the own items of an inner node, without its children.
    void draw_own(NodeId node, PlaneMask mask, Decision decision);
    /// Queues one item of node `owner`, by its position in Hierarchy::items().
    void draw_item(NodeId owner, ItemPosition at, PlaneMask mask, Decision decision);
    /// Queues items by id, in this order, for algorithms that do not get them from nodes.
    void draw_items(std::span<const ItemId> items, uint64_t triangles);

    uint64_t queued_triangles() const { return queued_triangles_; }
    size_t queued_items() const { return drawn_.size() - flushed_; }

    /// Hands the render queue to the device as one batch; does nothing if it is empty.
    void flush_draws();

    /// Hands the render queue to the device and starts it, so that it works beside the algorithm.
    void start_draws()
    {
        if (queued_items() > 0) {
            flush_draws();
            device_.flush();
        }
    }

    /// True if the device supports draw_and_query() and would draw the whole leaf: no flag sets one
    /// of its items aside.
    bool can_draw_and_query(NodeId leaf) const;

    /// Draws a leaf at once and counts its own samples: a test with the geometry itself.
    /// Precondition: can_draw_and_query(leaf), because items set aside would not be counted.
    Ticket draw_and_query(NodeId leaf, PlaneMask mask, Decision decision);

    /// Draws depth only from now on; finish() then shades all drawn items in one batch.
    void use_depth_only_pass() { pass_ = DrawPass::depth_only; }

    // --- testing ---

    /// Issues the collected tests as one batch, starts them, and writes their tickets. The method
    /// `automatic` is the device's own choice, except that a threshold above 0 needs counts and so
    /// queries.
    void query(const TestBatch& batch, std::vector<Ticket>& tickets,
               TestMethod method = TestMethod::automatic);
    /// Tests one node's box.
    Ticket query(NodeId node);

    Answer poll(Ticket ticket);
    Answer wait(Ticket ticket);
    /// Gives up the ticket: later frames spend it.
    void abandon(Ticket ticket) { record_.tickets.abandon(ticket); }

    /// How many more tests the device can hold (C11) if the culler has `held` unspent tickets.
    size_t free_tickets(size_t held) const;

    /// The sample positions of the device, for boxes that are compared with depth.
    SamplePositions samples() const;
    /// Reads back depth; see QueryDevice::read_depth.
    bool read_depth(const PixelRect& rect, std::span<float> out);
    /// Reads back the farthest depths of tiles; see QueryDevice::read_depth_tiles.
    bool read_depth_tiles(int tile_px, std::span<float> out);
    /// True if a read-back of this frame failed.
    bool depth_read_failed() const { return depth_read_failed_; }

    /// Logs a decision that draws nothing: the node was found hidden.
    void decide(NodeId node, Decision decision,
                DecisionLog::Scope scope = DecisionLog::Scope::subtree)
    {
        record_.decisions.add(node, decision, scope);
    }

    /// Logs such a decision about one item of node `owner`, by its position in Hierarchy::items().
    void decide_item(NodeId owner, ItemPosition at, Decision decision)
    {
        record_.decisions.add(owner, hierarchy_.item(at), decision);
    }

    /// Draws the queued items and the items set aside, shades after a depth-only pass, and ends the
    /// device's frame.
    void finish();

private:
    void draw_range(NodeId node, uint32_t first, uint32_t count, PlaneMask mask, Decision decision,
                    DecisionLog::Scope scope);
    void start_never_culled();
    bool set_aside(ItemPosition at);
    void queue(ItemPosition at);
    void draw_translucent();
    void enter_state(bool testing);
    TestMethod method_for(TestMethod asked) const;
    Answer counted(Answer answer);
    bool count_depth_read(bool read, size_t values);

    const Hierarchy& hierarchy_;
    FrameRecord& record_;
    const View& view_;
    QueryDevice& device_;
    FrameReport& report_;
    std::vector<ItemId>& drawn_; ///< record_.drawn_items: all items drawn or queued in this frame
    size_t flushed_ = 0;         ///< how many of `drawn_` the device has received
    uint64_t queued_triangles_ = 0;
    DrawPass pass_ = DrawPass::shade;
    bool testing_ = false;
    bool finished_ = false;
    bool depth_read_failed_ = false;
};

/// True if the answer counts more than `threshold` samples, or is unknown.
inline bool is_visible(const Answer& answer, uint64_t threshold)
{
    return answer.state != AnswerState::ready || answer.samples > threshold;
}

} // namespace occlude
