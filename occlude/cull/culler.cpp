#include <occlude/cull/culler.h>

#include <occlude/cull/parts/cull_frame.h>

namespace occlude {

FrameReport Culler::cull(const View& view, QueryDevice& device)
{
    if (seen_structure_ != hierarchy_.structure_version()) {
        structure_changed();
        seen_structure_ = hierarchy_.structure_version();
    }
    FrameReport report;
    report.frame = next_frame_++;
    report.guarantee = guarantee();
    CullFrame frame(hierarchy_, record_, view, device, report);
    if (!hierarchy_.empty()) {
        cull_frame(frame);
    }
    frame.finish();
    return report;
}

void Culler::reset()
{
    next_frame_ = 0;
    reset_state();
}

void Culler::release(QueryDevice& device)
{
    reset();
    for (const Ticket ticket : record_.abandoned_tickets) {
        device.wait(ticket);
    }
    record_.abandoned_tickets.clear();
}

} // namespace occlude
