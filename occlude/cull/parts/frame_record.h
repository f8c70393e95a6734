// The results of one frame of a culler: the drawn items and the decisions. A CullFrame fills it.
// The culler keeps it between frames, so that a frame allocates nothing once the vectors have
// grown.
#pragma once

#include <occlude/core/ids.h>
#include <occlude/cull/parts/back_to_front.h>
#include <occlude/cull/parts/decision_log.h>
#include <occlude/cull/parts/ticket_ledger.h>

#include <cstdint>
#include <vector>

namespace occlude {

struct FrameRecord {
    std::vector<ItemId> drawn_items;                ///< in draw order, each once
    std::vector<TranslucentItem> translucent_items; ///< drawn last, back to front
    std::vector<ItemPosition> late_items;           ///< never_occlude items
    DecisionLog decisions;
    TicketLedger tickets; ///< kept over frames

    /// Forgets the last frame, but keeps its tickets.
    void clear()
    {
        drawn_items.clear();
        translucent_items.clear();
        late_items.clear();
        decisions.clear();
    }
};

} // namespace occlude
