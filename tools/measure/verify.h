// The proof: compares every culled frame with the image of everything in the frustum, colour and
// depth, bit by bit.
//
// The reference draws the items in the frustum in ascending order. A frame that equals it is right.
// A frame that differs may still be right: where surfaces of equal depth meet, the image depends on
// the order of draws, although nothing was culled wrongly. So the frame's own items are drawn again
// without tests, twice. In the order in which the culler drew them, they must give the culled
// frame; otherwise a test left a trace in the image. In ascending order, they must give the
// reference; otherwise an item is missing. Pixels that fail either comparison are differing; all
// other unequal pixels are tied. A tied pixel is not a fault of culling, but a user sees it
// flicker: the verdict names the items whose surfaces coincide.
#pragma once

#include "measure/run.h"
#include "measure/stage.h"

#include <occlude/core/result.h>

namespace occlude::tools {

/// The image that a frame is compared with: everything in the frustum. Draws on the stage's
/// renderer.
Capture reference_image(const Stage& stage, const View& view);

/// Compares the frame that `culled` shows, which drew `drawn`, with the reference. Draws on the
/// stage's renderer. `decisions` are the decisions of the frame on the stage's tree. Draws up to
/// four more frames.
Verdict judge_frame(const Stage& stage, const View& view, const Capture& reference,
                    const Capture& culled, std::span<const ItemId> drawn,
                    const DecisionLog& decisions);

/// One run per contender, with a verdict and counters in every frame and no times. Fails if a
/// contender cannot be made.
Result<std::vector<AlgorithmRun>> verify(const Stage& stage, std::span<const Contender> contenders,
                                         std::span<const View> views,
                                         const ProgressCallback& progress = {});

/// True if every run that promises exact images kept its promise.
bool promises_kept(std::span<const AlgorithmRun> runs);

/// The differences of a run in words, one line per frame: the frame, the pixels, the missing items
/// and the nodes that hid them. At most `max_lines` lines, then the number of further ones.
std::vector<std::string> describe_differences(const AlgorithmRun& run, size_t max_lines);

} // namespace occlude::tools
