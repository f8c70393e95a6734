// View frustum culling alone: the baseline that all other algorithms are compared with.
//
// Implements  hierarchical view frustum culling with plane masking, near to far.
// Deviations  none: one draw batch for the whole frame, so that the engine can sort as it likes.
// Guarantees  exact: it defines the image that all exact methods must reproduce.
// Cost        O(visited nodes) frustum tests; no tests on the device.
#pragma once

#include <occlude/cull/culler.h>
#include <occlude/cull/parts/frustum_walk.h>

namespace occlude {

class FrustumCuller final : public Culler {
public:
    static constexpr AlgorithmTraits kTraits{
        .name = "frustum",
        .paper = "baseline",
        .summary = "draws everything in the view frustum",
        .remembers = false,
    };

    using Culler::Culler;

private:
    void cull_frame(CullFrame& frame) override { walk_.draw_all(frame); }
    void reset_state() override {}

    FrustumWalk walk_;
};

} // namespace occlude
