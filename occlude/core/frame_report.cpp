#include <occlude/core/frame_report.h>

#include <cstdio>

namespace occlude {

std::string to_string(const Guarantee& guarantee)
{
    switch (guarantee.kind) {
    case Guarantee::Kind::latent:
        return "latent(" + std::to_string(guarantee.frames) + ")";
    case Guarantee::Kind::approximate:
        if (guarantee.threshold == Guarantee::kAnySamples) {
            return "approximate";
        }
        return "approximate(" + std::to_string(guarantee.threshold) + ")";
    case Guarantee::Kind::exact:
        break;
    }
    return "exact";
}

FrameCounters& FrameCounters::operator+=(const FrameCounters& other)
{
    nodes_visited += other.nodes_visited;
    queries += other.queries;
    boxes += other.boxes;
    multiqueries += other.multiqueries;
    multiqueries_failed += other.multiqueries_failed;
    batches += other.batches;
    state_changes += other.state_changes;
    draw_calls += other.draw_calls;
    items_drawn += other.items_drawn;
    triangles_drawn += other.triangles_drawn;
    waits += other.waits;
    lost_answers += other.lost_answers;
    depth_reads += other.depth_reads;
    pixels_read += other.pixels_read;
    cells_asked += other.cells_asked;
    return *this;
}

const char* name(FramePlan::Kind kind)
{
    switch (kind) {
    case FramePlan::Kind::draw_all:
        return "draw_all";
    case FramePlan::Kind::queries:
        return "queries";
    case FramePlan::Kind::raster:
        return "raster";
    case FramePlan::Kind::pyramid:
        return "pyramid";
    case FramePlan::Kind::fixed:
        break;
    }
    return "fixed";
}

static const char* sentence(FramePlan::Reason reason)
{
    switch (reason) {
    case FramePlan::Reason::first_look:
        return "first look";
    case FramePlan::Reason::saves:
        return "pays";
    case FramePlan::Reason::saves_too_little:
        return "tests would not pay";
    case FramePlan::Reason::probe:
        return "tests did not pay, looked again";
    case FramePlan::Reason::no_tests:
        return "the device cannot test";
    case FramePlan::Reason::chosen:
        return "as the option says";
    case FramePlan::Reason::useless_clock:
        return "by hints: the clock stands still or is too coarse";
    case FramePlan::Reason::none:
        break;
    }
    return "";
}

std::string to_string(const FramePlan& plan)
{
    if (plan.kind == FramePlan::Kind::fixed) {
        return {};
    }
    constexpr float kUsPerMs = 1000.0f;
    char text[160];
    const int length = std::snprintf(
        text, sizeof text, "%s (%s): hides %.2f ms of drawing at %.2f ms, draws %.2f ms",
        name(plan.kind), sentence(plan.reason), static_cast<double>(plan.saved_us / kUsPerMs),
        static_cast<double>(plan.spent_us / kUsPerMs),
        static_cast<double>(plan.drawn_us / kUsPerMs));
    return {text, static_cast<size_t>(length)};
}

} // namespace occlude
