// The measuring core: every algorithm on every frame, interleaved frame by frame in rotating order.
// Machines drift, so only measurements close in time can be compared.
//
// One timed frame is: finish; start; cull(); finish; stop. Everything else (telling `opt` and
// `ideal` what is visible, the id buffer, hashes) happens outside it. Each algorithm has its own
// culler, so that no algorithm sees another's frames. If things move, all algorithms see the same
// state of a frame, and every repeat plays the motion from its beginning.
#pragma once

#include "measure/run.h"
#include "measure/stage.h"
#include "measure/timing_device.h"

#include <occlude/core/result.h>

namespace occlude::tools {

struct MeasureOptions {
    /// How many times the whole interleaved path is walked, with reset cullers. The figure of a
    /// frame is the median over these walks.
    size_t repeat = 1;
    /// Only one in this many frames of the path is measured: the last of each stretch. The frames
    /// between are culled, untimed, by the algorithms that remember earlier frames, so that these
    /// see the whole path. For scenes in which a frame without culling takes seconds. At most the
    /// number of views.
    size_t sample_every = 1;
    /// Compares the image of one in this many measured frames with the reference, after the frame
    /// was timed; 0: compares none.
    size_t verify_every = 0;
    SecondsClock clock = steady_seconds_clock();
    ProgressCallback progress = {};
};

/// One run per contender, in their order, compared with the references (compare_with_references()).
/// Fails if a contender cannot be made. Preconditions: views not empty, repeat > 0.
Result<std::vector<AlgorithmRun>> measure(const Stage& stage, std::span<const Contender> contenders,
                                          std::span<const View> views,
                                          const MeasureOptions& options = {});

/// The order in which `count` contenders run in a frame. It rotates by one from frame to frame, and
/// from repeat to repeat.
std::vector<size_t> contender_order(size_t count, size_t frame, size_t repeat);

/// The number of items in `drawn` that own no pixel, per item of `owners` (ascending). Without
/// owners, the number of items drawn.
double overdraw_items(std::span<const ItemId> drawn, std::span<const ItemId> owners);

/// Computes the ratios to `frustum`, `opt` and `ideal` in every frame of all runs; a ratio stays
/// unmeasured if there is no run of that name. There may be several runs of a name. The baseline is
/// the `frustum` with the shortest median frame of all hierarchies, so that a tree that is bad for
/// the baseline flatters no algorithm. The perfect tester is the `opt` on the run's own hierarchy,
/// or the first if there is none. `ideal` uses no tree.
void compare_with_references(std::span<AlgorithmRun> runs);

} // namespace occlude::tools
