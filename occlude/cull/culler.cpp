#include <occlude/cull/culler.h>

#include <occlude/core/assert.h>
#include <occlude/cull/parts/cull_frame.h>

#include <string>

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
    report_faults(frame, report);
    return report;
}

void Culler::report_faults(const CullFrame& frame, const FrameReport& report)
{
    const glm::ivec2 size = frame.view().size_px();
    if ((size.x <= 0 || size.y <= 0) && messages_.due("culler.empty_view")) {
        messages_.report(Severity::note, "culler.empty_view",
                         "the view is " + std::to_string(size.x) + "x" + std::to_string(size.y) +
                             " pixels, so nothing can be culled: give View::from_clip the "
                             "size of the viewport");
    }
    if (report.counters.lost_answers > 0 && messages_.due("culler.lost_answers")) {
        messages_.report(Severity::warning, "culler.lost_answers",
                         "the device lost " + std::to_string(report.counters.lost_answers) +
                             " answers in frame " + std::to_string(report.frame) +
                             ", which count as visible: it ran out of query objects "
                             "(caps.max_outstanding), or its tests failed");
    }
    if (frame.depth_read_failed() && messages_.due("culler.depth_read")) {
        messages_.report(Severity::warning, "culler.depth_read",
                         "the device can read depth by its caps, but a read failed in frame " +
                             std::to_string(report.frame) +
                             ": the nodes that needed it are drawn untested");
    }
    if (report.plan.reason == FramePlan::Reason::useless_clock &&
        messages_.due("culler.useless_clock")) {
        messages_.report(
            Severity::note, "culler.useless_clock",
            "the clock does not advance while the culler waits for the device, so costs "
            "are taken from the device's hints: give a clock of at least a "
            "microsecond's resolution that moves within a frame, such as "
            "steady_seconds_clock()");
    }
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
