// What a report says first: whether culling pays here, and by how much.
#pragma once

#include "report/bench_document.h"

#include <optional>
#include <string>

namespace occlude::tools {

/// The run that a user would choose: `adaptive` if it ran, else the exact algorithm that is fastest
/// against frustum culling. Yardsticks (frustum, opt, ideal) do not count. Nothing if none was
/// timed beside frustum culling. An index into the document's runs.
std::optional<size_t> chosen_run(const BenchDocument& document);

/// The run of `ideal`, the limit of what culling can reach, on the hierarchy of `beside`.
std::optional<size_t> ideal_run(const BenchDocument& document, size_t beside);

/// The places of the slowest frames of a run against frustum culling, worst first, at most `count`.
std::vector<size_t> worst_frames(const AlgorithmRun& run, size_t count);

} // namespace occlude::tools
