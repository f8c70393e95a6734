// Measures what test methods cost that are not in use: now and then one round of one method, on a
// device that is idle, over boxes that are to be tested anyway. The answers are not used.
//
// Guarantees  One trial in a frame at most, of at most 16 tests or one read-back; none without a
//             clock, and none that the contract of the device forbids (C5, C11).
#pragma once

#include <occlude/cull/adaptive/shared.h>

#include <span>
#include <vector>

namespace occlude {

class MethodTrials {
public:
    explicit MethodTrials(AdaptiveShared& shared, bool chooses)
        : shared_(shared)
        , chooses_(chooses)
    {
    }

    /// Tries the first method that may be the best and is not fully known. Precondition: the device
    /// is idle. `free_tickets`: how many more tests the device can take.
    void try_one(CullFrame& frame, std::span<const CutCandidate> candidates, size_t free_tickets);

    /// Is it worth a look at how long a read-back takes?
    bool read_is_due(const CullFrame& frame) const;
    /// Reads depth, in the tiles that are to be measured next, and measures how long it takes. The
    /// target was not read since it was drawn to: a second time it would come from a cache.
    bool read_and_measure(CullFrame& frame);

private:
    void try_round(CullFrame& frame, TestMethod method, CostModel::RoundSize size,
                   std::span<const CutCandidate> candidates);

    AdaptiveShared& shared_;
    bool chooses_; ///< false: an option prescribes the method, and the others are of no interest
    TestBatch batch_;
    std::vector<Ticket> tickets_;
};

} // namespace occlude
