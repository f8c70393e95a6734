// Pictures of the frames in which culling saved least, for reports.
#pragma once

#include "measure/stage.h"
#include "report/bench_document.h"
#include "session/session.h"

#include <span>
#include <vector>

namespace occlude::tools {

/// Three pictures (the image, the hidden items, the boxes with a decision) of each of the worst
/// `count` frames of `run`, which is a run of `contender` along `cameras`. The frames are culled
/// again, after the frames before them, so that an algorithm that measures time may decide
/// otherwise.
Result<std::vector<FramePicture>> picture_worst_frames(Session& session, const Contender& contender,
                                                       const AlgorithmRun& run,
                                                       std::span<const Camera> cameras,
                                                       size_t count);

} // namespace occlude::tools
