// The subcommands. Each returns the exit code, or the error with which the program ends.
#pragma once

#include "commands/progress.h"
#include "options/options.h"

#include <occlude/core/result.h>

#include <iosfwd>

namespace occlude::tools {

/// 0: done. 1: an exact algorithm's image differs. 2: the command could not be carried out. 3: it
/// was carried out, but its frames prove nothing: they are empty, or none hides anything.
enum ExitCode : int { kDone = 0, kDiffers = 1, kFailed = 2, kNothingProven = 3 };

struct Streams {
    std::ostream& out;
    std::ostream& err;
    Watcher watcher = Watcher::none; ///< watches `err`
};

Result<int> bench_command(const CompareOptions& options, const Streams& streams);
Result<int> suite_command(const SuiteOptions& options, const Streams& streams);
Result<int> verify_command(const CompareOptions& options, const Streams& streams);
Result<int> render_command(const RenderOptions& options, const Streams& streams);
Result<int> view_command(const ViewOptions& options, const Streams& streams);
Result<int> info_command(const InfoOptions& options, const Streams& streams);
Result<int> generate_command(const GenerateOptions& options, const Streams& streams);
Result<int> convert_command(const ConvertOptions& options, const Streams& streams);
Result<int> replay_command(const ReplayOptions& options, const Streams& streams);
Result<int> list_command(const ListOptions& options, const Streams& streams);

} // namespace occlude::tools
