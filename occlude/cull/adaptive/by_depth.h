// The frames of `adaptive` that test by depth that was read back: when depth is read, and what the
// time that this takes teaches about the cost of drawing. The tests are depth_traversal.h's.
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

    /// Tests the candidates, draws what shows, tests what was drawn for the next frame.
    /// Precondition: what was visible is drawn.
    void test(CullFrame& frame);

    /// Tests the finished frame, from the root down to nodes of `min_units`: what would tests hide?
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
    double units_at_read_ = 0.0;         ///< drawn, when depth was last read
    double hidden_at_read_ = 0.0;        ///< found hidden by then
    std::vector<CutCandidate> to_probe_; ///< scratch
};

} // namespace occlude
