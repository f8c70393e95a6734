// The frames of `adaptive` that test against depth that was read back. This file decides when to
// read, and learns the cost of drawing from the time of each read. depth_traversal.h has the tests.
#pragma once

#include <occlude/cull/adaptive/method_trials.h>
#include <occlude/cull/adaptive/shared.h>

#include <vector>

namespace occlude {

class TestingByDepth {
public:
    TestingByDepth(AdaptiveShared& shared, MethodTrials& trials)
        : shared_(shared)
        , trials_(trials)
    {
    }

    void start_frame();

    /// Tests the candidates, draws the visible ones, and tests what was drawn for the next frame.
    /// Precondition: the entries that were visible in the last frame are drawn.
    void test(CullFrame& frame);

    /// Tests the finished frame from the root down to nodes of `min_units`, to estimate how much
    /// tests would hide.
    void probe(CullFrame& frame, double min_units);

private:
    bool read(CullFrame& frame);
    bool time_drawing_and_read(CullFrame& frame);
    double idle_since_us(CullFrame& frame) const;
    void reveal(CullFrame& frame);
    void account(double testing_us);

    AdaptiveShared& shared_;
    MethodTrials& trials_;

    double drawing_since_us_ = 0.0;
    double units_at_read_ = 0.0;         ///< units drawn before depth was last read
    double hidden_at_read_ = 0.0;        ///< units found hidden before depth was last read
    std::vector<CutCandidate> to_probe_; ///< scratch
};

} // namespace occlude
