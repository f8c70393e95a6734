#include <occlude/cull/parts/cull_frame.h>

#include <occlude/core/assert.h>
#include <occlude/core/bounding_sphere.h>

#include <algorithm>

namespace occlude {

CullFrame::CullFrame(const Hierarchy& hierarchy, FrameRecord& record, const View& view,
                     QueryDevice& device, FrameReport& report)
    : hierarchy_(hierarchy)
    , record_(record)
    , view_(view)
    , device_(device)
    , report_(report)
    , drawn_(record.drawn_items)
{
    record_.clear();
    device_.begin_frame(view_);
    record_.tickets.start_frame(device_);
    start_never_culled();
}

CullFrame::~CullFrame()
{
    if (!finished_) {
        device_.end_frame();
    }
}

void CullFrame::queue(ItemPosition at)
{
    drawn_.push_back(hierarchy_.item(at));
    queued_triangles_ += hierarchy_.item_bounds(at).triangles;
}

// Keeps an item that its flags set aside for the end of the frame. False if no flag does.
bool CullFrame::set_aside(ItemPosition at)
{
    const ItemBounds& bounds = hierarchy_.item_bounds(at);
    if (has_flag(bounds.flags, ItemFlags::translucent)) {
        record_.translucent_items.push_back(
            {view_.distance_key(bounds.box), hierarchy_.item(at), bounds.triangles});
        return true;
    }
    if (has_flag(bounds.flags, ItemFlags::never_occlude)) {
        record_.late_items.push_back(at);
        return true;
    }
    return false;
}

void CullFrame::start_never_culled()
{
    for (const Hierarchy::FlaggedItem& flagged : hierarchy_.flagged_items()) {
        const ItemBounds& bounds = hierarchy_.item_bounds(flagged.position);
        const bool wanted = has_flag(bounds.flags, ItemFlags::never_cull) && !bounds.box.is_empty();
        if (wanted && !set_aside(flagged.position)) {
            queue(flagged.position);
        }
    }
}

bool CullFrame::visit(NodeId node, PlaneMask& mask)
{
    OCCLUDE_ASSERT(node.value < hierarchy_.nodes().size(),
                   "the visited node belongs to another tree");
    ++report_.counters.nodes_visited;
    if (view_.frustum().classify(hierarchy_.node(node).box, mask) == Containment::outside) {
        record_.decisions.add(node, Decision::outside);
        return false;
    }
    return true;
}

bool CullFrame::visit_item(NodeId owner, ItemPosition at, PlaneMask& mask)
{
    ++report_.counters.nodes_visited;
    if (view_.frustum().classify(hierarchy_.item_bounds(at).box, mask) == Containment::outside) {
        decide_item(owner, at, Decision::outside);
        return false;
    }
    return true;
}

bool CullFrame::visit_sphere_first(NodeId node, PlaneMask& mask, float elongation)
{
    OCCLUDE_ASSERT(node.value < hierarchy_.nodes().size(),
                   "the visited node belongs to another tree");
    ++report_.counters.nodes_visited;
    const Aabb& box = hierarchy_.node(node).box;
    if (classify_sphere_first(view_.frustum(), bounding_sphere(box), box, mask, elongation) ==
        Containment::outside) {
        record_.decisions.add(node, Decision::outside);
        return false;
    }
    return true;
}

bool CullFrame::near(NodeId node) const
{
    return view_.touches_near(test_box(node));
}

void CullFrame::draw_range(NodeId node, uint32_t first, uint32_t count, PlaneMask mask,
                           Decision decision, DecisionLog::Scope scope)
{
    record_.decisions.add(node, decision, scope);
    const bool has_flags = hierarchy_.has_flags();
    for (uint32_t i = first; i < first + count; ++i) {
        const ItemPosition at{i};
        const ItemBounds& bounds = hierarchy_.item_bounds(at);
        PlaneMask item_mask = mask;
        if (view_.frustum().classify(bounds.box, item_mask) == Containment::outside) {
            continue;
        }
        if (has_flags && (has_flag(bounds.flags, ItemFlags::never_cull) || set_aside(at))) {
            continue;
        }
        queue(at);
    }
}

void CullFrame::draw_leaf(NodeId leaf, PlaneMask mask, Decision decision)
{
    OCCLUDE_ASSERT(leaf.value < hierarchy_.nodes().size(),
                   "the drawn leaf belongs to another tree");
    OCCLUDE_ASSERT(is_drawn(decision), "a drawn node has a decision that draws");
    const Node& n = hierarchy_.node(leaf);
    draw_range(leaf, n.first_item, n.subtree_items, mask, decision, DecisionLog::Scope::subtree);
}

void CullFrame::draw_own(NodeId node, PlaneMask mask, Decision decision)
{
    OCCLUDE_ASSERT(node.value < hierarchy_.nodes().size(),
                   "the drawn node belongs to another tree");
    OCCLUDE_ASSERT(is_drawn(decision), "a drawn node has a decision that draws");
    const Node& n = hierarchy_.node(node);
    if (n.own_items > 0) {
        draw_range(node, n.first_item, n.own_items, mask, decision, DecisionLog::Scope::own_items);
    }
}

void CullFrame::draw_item(NodeId owner, ItemPosition at, PlaneMask mask, Decision decision)
{
    const ItemBounds& bounds = hierarchy_.item_bounds(at);
    if (view_.frustum().classify(bounds.box, mask) == Containment::outside) {
        decision = Decision::outside;
    } else if (!has_flag(bounds.flags, ItemFlags::never_cull) && !set_aside(at)) {
        queue(at);
    }
    record_.decisions.add(owner, hierarchy_.item(at), decision);
}

void CullFrame::draw_items(std::span<const ItemId> items, uint64_t triangles)
{
    queued_triangles_ += triangles;
    if (!hierarchy_.has_flags()) {
        drawn_.insert(drawn_.end(), items.begin(), items.end());
        return;
    }
    const auto flagged = hierarchy_.flagged_items();
    for (const ItemId item : items) {
        const auto found = std::lower_bound(flagged.begin(), flagged.end(),
                                            Hierarchy::FlaggedItem{item, ItemPosition{0u}});
        if (found == flagged.end() || found->item != item) {
            drawn_.push_back(item);
            continue;
        }
        const ItemBounds& bounds = hierarchy_.item_bounds(found->position);
        queued_triangles_ -= bounds.triangles;
        if (!has_flag(bounds.flags, ItemFlags::never_cull)) {
            set_aside(found->position);
        }
    }
}

bool CullFrame::can_draw_and_query(NodeId leaf) const
{
    if (!device_.caps().draw_and_query || !hierarchy_.has_flags()) {
        return device_.caps().draw_and_query;
    }
    const Node& n = hierarchy_.node(leaf);
    const auto bounds = hierarchy_.item_bounds().subspan(n.first_item, n.subtree_items);
    return std::none_of(bounds.begin(), bounds.end(), [](const ItemBounds& item) {
        return has_flag(item.flags, kDrawnOutOfTurn);
    });
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
    OCCLUDE_ASSERT(can_draw_and_query(leaf), "items set aside by a flag would not be counted");
    flush_draws();
    draw_leaf(leaf, mask, decision);
    enter_state(false);
    const Ticket ticket =
        device_.draw_and_query(std::span<const ItemId>{drawn_}.subspan(flushed_), pass_);
    record_.tickets.issued(ticket);
    ++report_.counters.draw_calls;
    ++report_.counters.queries;
    report_.counters.items_drawn += drawn_.size() - flushed_;
    report_.counters.triangles_drawn += queued_triangles_;
    flushed_ = drawn_.size();
    queued_triangles_ = 0;
    return ticket;
}

// Thresholds count samples, which only queries report.
TestMethod CullFrame::method_for(TestMethod asked) const
{
    const auto counts = [](const TestCost& cost) { return cost.method == TestMethod::queries; };
    const bool needs_counts = asked == TestMethod::automatic && report_.guarantee.threshold > 0 &&
                              !caps().exact_counts && std::ranges::any_of(caps().methods, counts);
    return needs_counts ? TestMethod::queries : asked;
}

void CullFrame::query(const TestBatch& batch, std::vector<Ticket>& tickets, TestMethod method)
{
    OCCLUDE_ASSERT(!batch.empty(), "a batch has at least one test");
    enter_state(true);
    tickets.resize(batch.test_count());
    device_.query({batch.boxes(), batch.test_ends(), method_for(method)}, tickets);
    record_.tickets.issued(tickets);
    ++report_.counters.batches;
    report_.counters.queries += batch.test_count();
    report_.counters.boxes += batch.boxes().size();
    device_.flush();
}

Ticket CullFrame::query(NodeId node)
{
    OCCLUDE_ASSERT(!near(node), "a box that the near plane may touch is not tested (R1)");
    enter_state(true);
    const QueryBox box{test_box(node), nullptr, node};
    const uint32_t end = 1;
    Ticket ticket;
    device_.query({{&box, 1}, {&end, 1}, method_for(TestMethod::automatic)}, {&ticket, 1});
    record_.tickets.issued(ticket);
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
    const bool some = answer.state == AnswerState::ready && answer.samples > 0;
    if (some && !caps().exact_counts && method_for(TestMethod::automatic) != TestMethod::queries) {
        answer.samples = Answer::kUnknownSamples; // more than any threshold
    }
    return answer;
}

Answer CullFrame::poll(Ticket ticket)
{
    const Answer answer = device_.poll(ticket);
    if (answer.state != AnswerState::pending) {
        record_.tickets.answered(ticket);
    }
    return counted(answer);
}

Answer CullFrame::wait(Ticket ticket)
{
    ++report_.counters.waits;
    const Answer answer = device_.wait(ticket);
    record_.tickets.answered(ticket);
    return counted(answer);
}

size_t CullFrame::free_tickets(size_t held) const
{
    const size_t taken = held + record_.tickets.abandoned_count();
    return caps().max_outstanding - std::min<size_t>(caps().max_outstanding, taken);
}

SamplePositions CullFrame::samples() const
{
    return caps().samples_at_pixel_centers ? SamplePositions::center : SamplePositions::anywhere;
}

bool CullFrame::count_depth_read(bool read, size_t values)
{
    if (!read) {
        depth_read_failed_ = caps().read_depth;
        return false;
    }
    ++report_.counters.depth_reads;
    report_.counters.pixels_read += values;
    return true;
}

bool CullFrame::read_depth(const PixelRect& rect, std::span<float> out)
{
    OCCLUDE_ASSERT(is_inside(rect, view_.size_px()), "depth is read inside the target");
    // There is no buffer for a target that is too large (DepthPyramid::kMaxPixels).
    return out.size() == pixel_count(rect) &&
           count_depth_read(device_.read_depth(rect, out), out.size());
}

bool CullFrame::read_depth_tiles(int tile_px, std::span<float> out)
{
    return out.size() == pixel_count(tiles_in(view_.size_px(), tile_px)) &&
           count_depth_read(device_.read_depth_tiles(tile_px, out), out.size());
}

void CullFrame::draw_translucent()
{
    std::sort(record_.translucent_items.begin(), record_.translucent_items.end(), blended_before);
    for (const TranslucentItem& translucent : record_.translucent_items) {
        drawn_.push_back(translucent.item);
        queued_triangles_ += translucent.triangles;
    }
    pass_ = DrawPass::shade;
    flush_draws();
}

void CullFrame::finish()
{
    OCCLUDE_ASSERT(!finished_, "a frame is finished once");
    for (const ItemPosition at : record_.late_items) {
        queue(at);
    }
    flush_draws();
    if (pass_ == DrawPass::depth_only && !drawn_.empty()) {
        enter_state(false);
        device_.draw(drawn_, DrawPass::shade_equal);
        ++report_.counters.draw_calls;
    }
    draw_translucent();
    finished_ = true;
    device_.end_frame();
}

} // namespace occlude
