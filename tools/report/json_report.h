// The measurements as JSON, version 1. Later versions only add keys.
#pragma once

#include "report/bench_document.h"

#include <span>

namespace occlude::tools {

/// One document as an object; several as an array of such objects. Figures that were not measured
/// are null.
std::string json_report(std::span<const BenchDocument> documents);

/// The results of a suite, to be kept and compared: an object with the suite's name, its scale and
/// the same documents without their single frames. "decision_hash_reproducible" says of a run
/// whether its hash depends on the frames alone: on a device whose answers come at once, or if the
/// algorithm never asked whether one had come.
std::string suite_report(const std::string& suite, const std::string& scale,
                         std::span<const BenchDocument> documents);

} // namespace occlude::tools
