#include <occlude/core/frame_report.h>

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

} // namespace occlude
