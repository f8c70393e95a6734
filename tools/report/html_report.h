// The measurements as one HTML file that needs nothing else: no network, no other files.
#pragma once

#include "report/bench_document.h"

#include <span>

namespace occlude::tools {

/// Per document: what was measured on, bars of medians, lines of frame times, a table of counters,
/// and what differed. The numbers are in it as JSON too (the element with id "occlude-data").
std::string html_report(std::span<const BenchDocument> documents);

/// `text` with the characters that mean something in HTML replaced.
std::string html_escaped(std::string_view text);

} // namespace occlude::tools
