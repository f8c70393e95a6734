// The command line: from argv to a command's options, and from its result to an exit code.
#pragma once

#include "commands/commands.h"

namespace occlude::tools {

/// Runs the program. Prints at most one message to `streams.err` when it fails. Returns 0; 1 if an
/// exact algorithm's image differs; 2 for an error in the options, the files or the machine; 3 as
/// in commands.h. Throws nothing.
int run_program(int argc, const char* const* argv, const Streams& streams);

} // namespace occlude::tools
