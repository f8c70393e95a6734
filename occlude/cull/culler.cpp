#include <occlude/cull/culler.h>

#include <occlude/core/assert.h>
#include <occlude/cull/parts/cull_frame.h>

namespace occlude {

FrameReport Culler::cull(const View& view, QueryDevice& device)
{
    OCCLUDE_ASSERT(!hierarchy_.moved_from(), "the culler's hierarchy was moved away: make a culler "
                                             "over the hierarchy that it was moved to");
    if (in_frame_) {
        reset(); // the device threw in the last frame
    }
    if (seen_structure_ != hierarchy_.structure_version()) {
        structure_changed();
        seen_structure_ = hierarchy_.structure_version();
    }
    FrameReport report;
    report.frame = next_frame_++;
    report.guarantee = guarantee();
    in_frame_ = true;
    CullFrame frame(hierarchy_, record_, view, device, report);
    if (!hierarchy_.empty()) {
        cull_frame(frame);
    }
    frame.finish();
    in_frame_ = false;
    return report;
}

void Culler::reset()
{
    next_frame_ = 0;
    in_frame_ = false;
    reset_state();
    record_.tickets.abandon_all();
}

void Culler::release(QueryDevice& device)
{
    reset();
    record_.tickets.wait_for_abandoned(device);
}

} // namespace occlude
