// Does a culled frame lack something? The library's own answer, in the engine, over any device.
//
// Culls a frame, draws it again without tests, and draws on top of it, one by one and near to far,
// every item that the culler left out: an item of which a sample passes the depth test is missing.
// Items outside of the frustum are drawn, too, so that a wrong frustum shows. The reason is found
// in the culler's decisions: the nearest node above the item for which one was made.
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/core/result.h>
#include <occlude/cull/culler.h>

#include <cstdint>
#include <string>
#include <vector>

namespace occlude {

/// An item that would have been seen and was not drawn.
struct MissedItem {
    ItemId item;
    uint64_t samples = 0;                    ///< that it would have added to the image
    NodeId node;                             ///< for which it was decided; invalid if for none
    Decision decision = Decision::undecided; ///< ... and what
    std::string text;                        ///< a sentence
};

struct FrameCheck {
    FrameReport report;              ///< of the culled frame
    std::vector<MissedItem> missing; ///< near to far; empty if the frame is complete
    size_t items_checked = 0;        ///< that the culler had left out
};

/// Culls one frame, which advances the culler by a frame, and looks for what it lacks. Fails if the
/// device can neither draw_and_query nor read depth, or loses an answer. A draw per item that is
/// left out: seconds for tens of thousands.
Result<FrameCheck> verify_frame(Culler& culler, const View& view, QueryDevice& device);

} // namespace occlude
