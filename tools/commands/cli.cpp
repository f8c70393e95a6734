#include "commands/cli.h"

#include "commands/cli_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>
#include <ostream>

namespace occlude::tools {

static int fail(const Streams& streams, std::string_view message)
{
    streams.err << "occlude: " << message << '\n';
    return kFailed;
}

// The error in the first word; none if it is a command or an option.
static std::optional<std::string> problem_of_command(int argc, const char* const* argv,
                                                     const std::vector<std::string>& names)
{
    if (argc <= 1) {
        return "no command given";
    }
    const bool known =
        argv[1][0] == '-' || std::find(names.begin(), names.end(), argv[1]) != names.end();
    return known ? std::optional<std::string>{} : fmt::format("there is no command '{}'", argv[1]);
}

static int run_command(int argc, const char* const* argv, const Streams& streams)
{
    try {
        CommandLine line{"occlude: measure and check occlusion culling on your scenes",
                         std::string{"occlude "} + OCCLUDE_VERSION};
        add_compare_commands(line);
        add_scene_commands(line);
        add_file_commands(line);
        if (const auto problem = problem_of_command(argc, argv, line.names())) {
            return fail(streams, fmt::format("{}; choose one of {}; see 'occlude --help'", *problem,
                                             fmt::join(line.names(), ", ")));
        }
        const Result<int> code = line.run(argc, argv, streams);
        return code ? *code : fail(streams, code.error().message);
    } catch (const std::bad_alloc&) {
        return fail(streams, "out of memory; choose a smaller scene, size or number of frames");
    } catch (const std::exception& error) {
        return fail(streams, fmt::format("unexpected failure: {}", error.what()));
    }
}

int run_program(int argc, const char* const* argv, const Streams& streams)
{
    const int code = run_command(argc, argv, streams);
    streams.out.flush();
    if (!streams.out) { // a script that reads the table must not take half of it for the whole
        return fail(streams, "cannot write to the standard output; is the disk full?");
    }
    return code;
}

} // namespace occlude::tools
