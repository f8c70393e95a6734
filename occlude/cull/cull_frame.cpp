#include <occlude/cull/cull_frame.h>

#include <occlude/core/assert.h>

namespace occlude {

CullFrame::CullFrame(Culler& culler, const View& view, QueryDevice& device, FrameReport& report)
    : culler_(culler)
    , hierarchy_(culler.hierarchy())
    , view_(view)
    , device_(device)
    , report_(report)
    , drawn_(culler.drawn_items_)
{
    drawn_.clear();
    culler_.decisions_.clear();
    device_.begin_frame(view_);
}

bool CullFrame::visit(NodeId node, PlaneMask& mask)
{
    ++report_.counters.nodes_visited;
    if (view_.frustum().classify(hierarchy_.node(node).box, mask) == Containment::outside) {
        culler_.decisions_.add(node, Decision::outside);
        return false;
    }
    return true;
}

bool CullFrame::near(NodeId node) const
{
    return view_.touches_near(test_box(node));
}

void CullFrame::draw_range(NodeId node, uint32_t first, uint32_t count, PlaneMask mask,
                           Decision decision)
{
    culler_.decisions_.add(node, decision);
    for (uint32_t i = first; i < first + count; ++i) {
        const ItemBounds& bounds = hierarchy_.item_bounds()[i];
        PlaneMask item_mask = mask;
        if (view_.frustum().classify(bounds.box, item_mask) == Containment::outside) {
            continue;
        }
        drawn_.push_back(hierarchy_.items()[i]);
        queued_triangles_ += bounds.triangles;
    }
}

void CullFrame::draw_leaf(NodeId leaf, PlaneMask mask, Decision decision)
{
    const Node& n = hierarchy_.node(leaf);
    draw_range(leaf, n.first_item, n.subtree_items, mask, decision);
}

void CullFrame::draw_own(NodeId node, PlaneMask mask, Decision decision)
{
    const Node& n = hierarchy_.node(node);
    if (n.own_items > 0) {
        draw_range(node, n.first_item, n.own_items, mask, decision);
    }
}

void CullFrame::draw_item(NodeId owner, uint32_t place, PlaneMask mask, Decision decision)
{
    const ItemBounds& bounds = hierarchy_.item_bounds()[place];
    if (view_.frustum().classify(bounds.box, mask) == Containment::outside) {
        decision = Decision::outside;
    } else {
        drawn_.push_back(hierarchy_.items()[place]);
        queued_triangles_ += bounds.triangles;
    }
    culler_.decisions_.add(owner, hierarchy_.items()[place], decision);
}

void CullFrame::draw_items(std::span<const ItemId> items, uint64_t triangles)
{
    drawn_.insert(drawn_.end(), items.begin(), items.end());
    queued_triangles_ += triangles;
}

void CullFrame::enter_state(bool testing)
{
    if (testing_ != testing) {
        testing_ = testing;
        ++report_.counters.state_changes;
    }
}

void CullFrame::flush_draws()
{
    if (flushed_ == drawn_.size()) {
        return;
    }
    enter_state(false);
    device_.draw(std::span<const ItemId>{drawn_}.subspan(flushed_), pass_);
    ++report_.counters.draw_calls;
    report_.counters.items_drawn += drawn_.size() - flushed_;
    report_.counters.triangles_drawn += queued_triangles_;
    flushed_ = drawn_.size();
    queued_triangles_ = 0;
}

Ticket CullFrame::draw_and_query(NodeId leaf, PlaneMask mask, Decision decision)
{
    flush_draws();
    draw_leaf(leaf, mask, decision);
    enter_state(false);
    const Ticket ticket =
        device_.draw_and_query(std::span<const ItemId>{drawn_}.subspan(flushed_), pass_);
    ++report_.counters.draw_calls;
    ++report_.counters.queries;
    report_.counters.items_drawn += drawn_.size() - flushed_;
    report_.counters.triangles_drawn += queued_triangles_;
    flushed_ = drawn_.size();
    queued_triangles_ = 0;
    return ticket;
}

void CullFrame::query(const TestBatch& batch, std::vector<Ticket>& tickets)
{
    OCCLUDE_ASSERT(!batch.empty(), "a batch has at least one test");
    enter_state(true);
    tickets.resize(batch.test_count());
    device_.query({batch.boxes(), batch.test_ends(), TestMethod::automatic}, tickets);
    ++report_.counters.batches;
    report_.counters.queries += batch.test_count();
    report_.counters.boxes += batch.boxes().size();
    device_.flush();
}

Ticket CullFrame::query(NodeId node)
{
    enter_state(true);
    const QueryBox box{test_box(node), nullptr, node};
    const uint32_t end = 1;
    Ticket ticket;
    device_.query({{&box, 1}, {&end, 1}, TestMethod::automatic}, {&ticket, 1});
    ++report_.counters.batches;
    ++report_.counters.queries;
    ++report_.counters.boxes;
    device_.flush();
    return ticket;
}

Answer CullFrame::counted(Answer answer)
{
    if (answer.state == AnswerState::lost) {
        ++report_.counters.lost_answers;
    }
    return answer;
}

Answer CullFrame::poll(Ticket ticket)
{
    return counted(device_.poll(ticket));
}

Answer CullFrame::wait(Ticket ticket)
{
    ++report_.counters.waits;
    return counted(device_.wait(ticket));
}

bool CullFrame::read_depth(const PixelRect& rect, std::span<float> out)
{
    if (!device_.read_depth(rect, out)) {
        return false;
    }
    ++report_.counters.depth_reads;
    report_.counters.pixels_read += out.size();
    return true;
}

void CullFrame::finish()
{
    flush_draws();
    if (pass_ == DrawPass::depth_only && !drawn_.empty()) {
        enter_state(false);
        device_.draw(drawn_, DrawPass::shade_equal);
        ++report_.counters.draw_calls;
    }
    device_.end_frame();
}

} // namespace occlude
