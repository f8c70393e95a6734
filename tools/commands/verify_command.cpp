#include "commands/comparison.h"
#include "commands/open_session.h"
#include "measure/verify.h"
#include "report/table.h"

#include <ostream>

namespace occlude::tools {

namespace {

// Walks the path `repeat` times with new cullers, and keeps the worst verdict of every frame.
Result<std::vector<AlgorithmRun>> verify_repeatedly(const Stage& stage,
                                                    std::span<const Contender> contenders,
                                                    std::span<const View> views, size_t repeat,
                                                    Progress& progress)
{
    std::vector<AlgorithmRun> worst;
    for (size_t walk = 0; walk < repeat; ++walk) {
        auto runs = verify(stage, contenders, views, [&](double share) {
            progress.show((static_cast<double>(walk) + share) / static_cast<double>(repeat));
        });
        if (!runs || worst.empty()) {
            if (!runs) {
                return runs.error();
            }
            worst = std::move(*runs);
            continue;
        }
        for (size_t i = 0; i < worst.size(); ++i) {
            for (size_t frame = 0; frame < views.size(); ++frame) {
                FrameFigures& kept = worst[i].frames[frame];
                FrameFigures& next = (*runs)[i].frames[frame];
                if (next.verdict->differing_pixels > kept.verdict->differing_pixels) {
                    kept = std::move(next);
                }
            }
        }
    }
    return worst;
}

Result<BenchDocument> verify_path(Session& session, const CompareOptions& options,
                                  const std::string& path, const Streams& streams)
{
    const auto views = session.views(path);
    if (!views) {
        return views.error();
    }
    const Stage stage = session.stage();
    const auto contenders = contenders_of(session, options, References::if_asked);
    if (!contenders) {
        return contenders.error();
    }
    BenchDocument document = describe(session, options, path, views->size());
    Progress progress{streams.err, streams.watcher, "verifying " + document.scene + ", " + path};
    auto runs = verify_repeatedly(stage, *contenders, *views, options.repeat, progress);
    if (!runs) {
        return runs.error();
    }
    document.runs = std::move(*runs);
    document.coincident = coincident_objects(session, document.runs);
    return document;
}

} // namespace

Result<int> verify_command(const CompareOptions& options, const Streams& streams)
{
    if (const auto checked = check_compare_options(options, streams.err); !checked) {
        return checked.error();
    }
    auto files = ReportFiles::open(options);
    if (!files) {
        return files.error();
    }
    // By default: a smooth path, on which temporal state pays, and one that defeats it.
    const std::vector<std::string> paths = options.path_given
                                               ? std::vector<std::string>{options.stage.path}
                                               : std::vector<std::string>{"auto", "teleport"};
    std::vector<BenchDocument> documents;
    int code = kDone;
    for (const std::string& scene : options.scenes) {
        const auto session = open_session(scene, options.stage, streams);
        if (!session) {
            return session.error();
        }
        streams.out << load_summary((*session)->model());
        for (const std::string& path : paths) {
            auto document = verify_path(**session, options, path, streams);
            if (!document) {
                return document.error();
            }
            streams.out << verify_table(*document) << std::endl;
            print_differences(document->runs, streams.out);
            code = worse(code, promises_kept(document->runs) ? kDone : kDiffers);
            code = worse(code, judge_evidence(*document, !options.nothing_hidden_is_fine,
                                              options.stage.strict, streams.out));
            documents.push_back(std::move(*document));
        }
    }
    if (const auto written = files->write(documents); !written) {
        return written.error();
    }
    return code;
}

} // namespace occlude::tools
