// Checks a culled frame for missing items, in the engine and over any device.
//
// Culls a frame, draws it again without tests, and draws every item that the culler left out on top
// of it, one by one and near to far. An item of which a sample passes the depth test is missing.
// Items outside the frustum are drawn, too, so that a wrong frustum shows. The culler's decisions
// give the reason: the decision about the nearest node above the item.
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/core/result.h>
#include <occlude/cull/culler.h>

#include <cstdint>
#include <string>
#include <vector>

namespace occlude {

/// An item that is visible and was not drawn.
struct MissedItem {
    ItemId item;
    uint64_t samples = 0;                    ///< samples that it would have added to the image
    NodeId node;                             ///< the node that the decision is about; invalid if
                                             ///< there is none
    Decision decision = Decision::undecided; ///< the decision
    std::string text;                        ///< a sentence
};

struct FrameCheck {
    FrameReport report;              ///< of the culled frame
    std::vector<MissedItem> missing; ///< near to far; empty if the frame is complete
    size_t items_checked = 0;        ///< number of items that the culler had left out
};

/// Culls one frame, which advances the culler by a frame, and looks for missing items. Fails if the
/// device can neither draw_and_query nor read depth, or if it loses an answer. Takes a draw per
/// item that is left out: seconds for tens of thousands of items.
Result<FrameCheck> verify_frame(Culler& culler, const View& view, QueryDevice& device);

} // namespace occlude
