// The measuring core: every algorithm on every frame, interleaved frame by frame in rotating
// order, because machines drift and only neighbours in time compare.
//
// One timed frame is: finish; start; cull(); finish; stop. Everything else (telling `opt` and
// `ideal` the answer, the id buffer, hashes) happens outside of it. Each algorithm has its own
// culler, so no algorithm sees another's frames. Where things move, all algorithms see the same
// state of a frame, and every repeat plays the motion from its beginning.
#pragma once

#include "measure/run.h"
#include "measure/stage.h"
#include "measure/timing_device.h"

#include <occlude/core/result.h>

namespace occlude::tools {

struct MeasureOptions {
    /// Times the whole interleaved path is walked, with reset cullers; the figure of a frame is the
    /// median over them.
    size_t repeat = 1;
    /// Only one in this many frames of the path is measured, the last of each stretch; frames
    /// between them are culled, untimed, by the algorithms that remember earlier frames, so that
    /// these see the whole path. For scenes in which a frame without culling takes seconds. At most
    /// the number of views.
    size_t sample_every = 1;
    /// Compares the image of one in this many measured frames with the reference, after the frame
    /// was timed; 0: of none.
    size_t verify_every = 0;
    SecondsClock clock = steady_seconds_clock();
    ProgressCallback progress = {};
};

/// One run per contender, in their order, compared with the references (compare_with_references()).
/// Fails if a contender cannot be made. Preconditions: views not empty, repeat > 0.
Result<std::vector<AlgorithmRun>> measure(const Stage& stage, std::span<const Contender> contenders,
                                          std::span<const View> views,
                                          const MeasureOptions& options = {});

/// The order in which `count` contenders run in a frame: rotated by one from frame to frame, and
/// from repeat to repeat.
std::vector<size_t> contender_order(size_t count, size_t frame, size_t repeat);

/// Items of `drawn` that own no pixel, per item of `owners` (ascending); 0 if there are no owners
/// and nothing was drawn, the number of items drawn if there are no owners.
double overdraw_items(std::span<const ItemId> drawn, std::span<const ItemId> owners);

/// Forms the figures against `frustum`, `opt` and `ideal` in every frame of all runs; they stay
/// unmeasured if there are no runs of these names. Where there are several: what must be beaten is
/// the `frustum` on the hierarchy on which its median frame is shortest, so that no algorithm is
/// flattered by a bad tree under its baseline; a perfect tester is one on the same tree, so `opt`
/// is that of the run's own hierarchy, or the first if there is none; `ideal` uses no tree.
void compare_with_references(std::span<AlgorithmRun> runs);

} // namespace occlude::tools
