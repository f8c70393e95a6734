#include "commands/open_session.h"

namespace occlude::tools {

Result<std::unique_ptr<Session>> open_session(const std::string& scene, const StageOptions& options,
                                              const Streams& streams)
{
    Progress progress{streams.err, streams.watcher, scene};
    return Session::open(scene, options, streams.err, [&](const std::string& phase, double share) {
        progress.show(phase, share);
    });
}

} // namespace occlude::tools
