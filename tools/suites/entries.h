// The tables of entries, one file each; suite.h names them.
#pragma once

#include "suites/suite.h"

namespace occlude::tools {

/// The experiments of the papers that the algorithms come from.
std::vector<SuiteEntry> papers_entries(Scale scale);

/// Kinds of trees and sizes of leaves side by side, on all kinds of scenes.
std::vector<SuiteEntry> trees_entries(Scale scale);

/// A quick mixture for daily use, the same at every scale.
std::vector<SuiteEntry> quick_entries(Scale scale);

} // namespace occlude::tools
