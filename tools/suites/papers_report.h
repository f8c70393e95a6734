// The results of the suite `papers` as a page that sets every published figure beside ours.
#pragma once

#include "suites/suite_results.h"

#include <string>

namespace occlude::tools {

/// Markdown: the papers with their figures, our values, whether they are reached and the reason if
/// not; then the runs themselves. Depends only on `results`: the same results give the same page.
std::string papers_report(const SuiteResults& results);

} // namespace occlude::tools
