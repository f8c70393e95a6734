// What one frame of a culler leaves behind: the items it drew and why, and the tests whose answers
// nobody wants. A CullFrame fills it; the culler keeps it between frames, so that a frame allocates
// nothing once its vectors have grown.
#pragma once

#include <occlude/core/ids.h>
#include <occlude/cull/parts/back_to_front.h>
#include <occlude/cull/parts/decision_log.h>

#include <cstdint>
#include <vector>

namespace occlude {

struct FrameRecord {
    std::vector<ItemId> drawn_items;                ///< in draw order, each once
    std::vector<TranslucentItem> translucent_items; ///< drawn last, back to front
    std::vector<uint32_t> late_items; ///< never_occlude items, as places in Hierarchy::items()
    DecisionLog decisions;
    std::vector<Ticket> abandoned_tickets; ///< to be spent; they outlive frames

    /// Leaves the abandoned tickets.
    void clear()
    {
        drawn_items.clear();
        translucent_items.clear();
        late_items.clear();
        decisions.clear();
    }
};

} // namespace occlude
