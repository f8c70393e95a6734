// A session for a command, with a line of progress for whoever watches.
#pragma once

#include "commands/commands.h"
#include "session/session.h"

namespace occlude::tools {

/// Session::open() that shows on `streams.err` how far reading, cutting and building are.
Result<std::unique_ptr<Session>> open_session(const std::string& scene, const StageOptions& options,
                                              const Streams& streams);

} // namespace occlude::tools
