// The measurements as one HTML file that needs nothing else: no network, no other files.
#pragma once

#include "report/bench_document.h"

#include <span>

namespace occlude::tools {

/// Per document: a sentence that sums it up, times and pixels by algorithm, plots over the path,
/// the worst frames with the document's pictures, scene, device and settings, how it was measured,
/// all counters. The numbers are in it as JSON too (the element with id "occlude-data"), and can be
/// saved from it as JSON and CSV.
std::string html_report(std::span<const BenchDocument> documents);

} // namespace occlude::tools
