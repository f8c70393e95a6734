// The report of a frame as sentences.
#pragma once

#include <occlude/core/frame_report.h>

#include <string>
#include <vector>

namespace occlude::tools::viewer {

/// What a guarantee means for the picture.
std::string guarantee_in_words(const Guarantee& guarantee);

/// What the frame did and cost, a sentence each; what did not happen is left out.
std::vector<std::string> report_in_words(const FrameReport& report);

/// How `adaptive` went about the frame, and why; empty for others.
std::vector<std::string> plan_in_words(const FramePlan& plan);

} // namespace occlude::tools::viewer
