#include "commands/commands.h"
#include "session/session.h"

#include <occlude/cull/registry.h>

#include <fmt/format.h>

#ifdef OCCLUDE_HAS_VIEWER
#include "viewer/ui/run_viewer.h"
#endif

namespace occlude::tools {

static Result<bool> check_view_options(const ViewOptions& options)
{
    if (const auto checked = check_one_hierarchy(options.stage); !checked) {
        return checked.error();
    }
    if (!options.algorithm.empty() && find_algorithm(options.algorithm) == nullptr) {
        return Error{ErrorCode::not_found,
                     fmt::format("--algorithm: there is no algorithm '{}'; 'occlude list "
                                 "algorithms' names them",
                                 options.algorithm)};
    }
    if (options.headless && !options.frames && options.script.empty()) {
        return Error{ErrorCode::invalid_argument,
                     "--headless: the viewer would never end; give --frames or --script, too"};
    }
    return true;
}

Result<int> view_command(const ViewOptions& options, [[maybe_unused]] const Streams& streams)
{
    if (const auto checked = check_view_options(options); !checked) {
        return checked.error();
    }
#ifdef OCCLUDE_HAS_VIEWER
    const auto ran = viewer::run_viewer(options, streams.out);
    return ran ? Result<int>{kDone} : Result<int>{ran.error()};
#else
    return Error{ErrorCode::unsupported,
                 "this build has no viewer: install GLFW and Dear ImGui (Debian: libglfw3-dev "
                 "and libimgui-dev) and build again; 'occlude render' makes pictures without them"};
#endif
}

} // namespace occlude::tools
