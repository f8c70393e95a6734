// Opens a session for a command, with a line of progress for a person who watches.
#pragma once

#include "commands/commands.h"
#include "session/session.h"

namespace occlude::tools {

/// Session::open(), with the progress of reading, cutting and building on `streams.err`.
Result<std::unique_ptr<Session>> open_session(const std::string& scene, const StageOptions& options,
                                              const Streams& streams);

} // namespace occlude::tools
