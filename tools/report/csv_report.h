// The measurements as CSV: one row per scene, path and algorithm, for spreadsheets.
#pragma once

#include "report/bench_document.h"

#include <span>

namespace occlude::tools {

/// A header line, then one row per run. Figures that were not measured are empty.
std::string csv_report(std::span<const BenchDocument> documents);

} // namespace occlude::tools
