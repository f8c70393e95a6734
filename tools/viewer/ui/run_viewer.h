// Runs the viewer until the user, or a script, is done with it.
#pragma once

#include "options/options.h"

#include <occlude/core/result.h>

#include <iosfwd>

namespace occlude::tools::viewer {

/// What was run, for tests and for those who want to know what it costs.
Result<bool> run_viewer(const ViewOptions& options, std::ostream& out);

} // namespace occlude::tools::viewer
