// The measurements as text for a terminal.
#pragma once

#include "report/bench_document.h"

namespace occlude::tools {

/// A heading with the scene, size, device and path, then one line per algorithm: times and ratios.
/// Where runs are on several hierarchies, a column says which.
std::string bench_table(const BenchDocument& document);

/// The same heading, then one line per algorithm: what was compared and what differed.
std::string verify_table(const BenchDocument& document);

/// Columns as wide as their widest cell, the first one left-aligned, the others right-aligned.
std::string align_columns(const std::vector<std::vector<std::string>>& rows);

/// 12345678 as "12,345,678".
std::string grouped(uint64_t value);

} // namespace occlude::tools
