// The tables of entries, one file each; suite.h names them.
#pragma once

#include "suites/suite.h"

namespace occlude::tools {

/// The experiments of the papers that the algorithms come from.
std::vector<SuiteEntry> papers_entries(Scale scale);

/// A little of everything, for every day; the same at every scale.
std::vector<SuiteEntry> quick_entries(Scale scale);

} // namespace occlude::tools
