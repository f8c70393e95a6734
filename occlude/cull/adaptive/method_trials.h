// Measures the cost of test methods that are not in use. A trial is one round by one method on an
// idle device, over boxes that will be tested anyway. Its answers are ignored.
//
// Guarantees  At most one trial per frame, of at most 16 tests or one read-back. There is none
//             without a clock, and none that the device's contract forbids (C5, C11).
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

    /// Tries the first method that may be the cheapest and is not fully measured. Precondition: the
    /// device is idle. `free_tickets`: how many more tests the device can take.
    void try_one(CullFrame& frame, std::span<const CutCandidate> candidates, size_t free_tickets);

    /// True if the cost of a read-back is worth measuring in this frame.
    bool read_is_due(const CullFrame& frame) const;
    /// Reads depth in the tiles that are next to be measured, and records the time. Precondition:
    /// the target has not been read since the last draw, because a second read would come from a
    /// cache.
    bool read_and_measure(CullFrame& frame);

private:
    void try_round(CullFrame& frame, TestMethod method, CostModel::RoundSize size,
                   std::span<const CutCandidate> candidates);

    AdaptiveShared& shared_;
    bool chooses_; ///< false: an option prescribes the method, so that the costs of the others do
                   ///< not matter
    TestBatch batch_;
    std::vector<Ticket> tickets_;
};

} // namespace occlude
