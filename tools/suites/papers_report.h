// The results of the suite `papers` as a page that sets every published figure beside ours.
#pragma once

#include "suites/suite_results.h"

#include <string>

namespace occlude::tools {

/// Markdown: the papers with their figures, ours, whether they are reached and why not; then the
/// runs themselves. Follows from `results` alone: the same results give the same page.
std::string papers_report(const SuiteResults& results);

} // namespace occlude::tools
