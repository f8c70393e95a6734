// The measurements as JSON, version 1. Later versions only add keys.
#pragma once

#include "report/bench_document.h"

#include <span>

namespace occlude::tools {

/// One document as an object; several as an array of such objects. Figures that were not measured
/// are null.
std::string json_report(std::span<const BenchDocument> documents);

} // namespace occlude::tools
