// The proof: every culled frame against the image of everything in the frustum, colour and depth,
// bit by bit.
//
// The reference draws the items in the frustum in ascending order. A frame that equals it is right.
// A frame that does not may still be: where surfaces of equal depth meet, the image depends on the
// order of draws, though nothing was culled wrongly. So the frame's own items are drawn again
// without tests, twice: in the order the culler drew them, which must give the culled frame (or a
// test left a trace in the image), and in ascending order, which must give the reference (or an
// item is missing). Pixels that differ in either are differing; the rest are tied. A tied pixel is
// no fault of culling, but a user sees it flicker: the verdict names the items whose surfaces
// coincide.
#pragma once

#include "measure/run.h"
#include "measure/stage.h"

#include <occlude/core/result.h>

namespace occlude::tools {

/// What a frame is compared with: everything in the frustum. Draws on the stage's renderer.
Capture reference_image(const Stage& stage, const View& view);

/// Compares the frame that `culled` shows, which drew `drawn`, with the reference. Draws on the
/// stage's renderer. `decisions` are those of the frame, on the stage's tree. Costs up to four more
/// frames.
Verdict judge_frame(const Stage& stage, const View& view, const Capture& reference,
                    const Capture& culled, std::span<const ItemId> drawn,
                    const DecisionLog& decisions);

/// One run per contender, with a verdict and counters in every frame and no times. Fails if a
/// contender cannot be made.
Result<std::vector<AlgorithmRun>> verify(const Stage& stage, std::span<const Contender> contenders,
                                         std::span<const View> views,
                                         const ProgressCallback& progress = {});

/// True if every run that promises exact images kept the promise.
bool promises_kept(std::span<const AlgorithmRun> runs);

/// The differences of a run in words, one line per frame: the frame, the pixels, the items missing
/// and the nodes that hid them. At most `max_lines` lines, then how many more there are.
std::vector<std::string> describe_differences(const AlgorithmRun& run, size_t max_lines);

} // namespace occlude::tools
