// The tables of entries, one file each; suite.h names them.
#pragma once

#include "suites/suite.h"

namespace occlude::tools {

/// The experiments of the papers that the algorithms come from.
std::vector<SuiteEntry> papers_entries(Scale scale);

/// Kinds of trees and sizes of leaves beside each other, on all kinds of scenes.
std::vector<SuiteEntry> trees_entries(Scale scale);

/// A little of everything, for every day; the same at every scale.
std::vector<SuiteEntry> quick_entries(Scale scale);

} // namespace occlude::tools
