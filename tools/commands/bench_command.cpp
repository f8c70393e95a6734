#include "commands/comparison.h"
#include "measure/measure.h"
#include "measure/verify.h"
#include "report/table.h"

#include <ostream>

namespace occlude::tools {

namespace {

// Copies the verdicts of a verifying walk into the timed runs of the same contenders.
void take_verdicts(std::span<AlgorithmRun> timed, std::span<const AlgorithmRun> verified)
{
    for (size_t i = 0; i < timed.size(); ++i) {
        for (size_t frame = 0; frame < timed[i].frames.size(); ++frame) {
            timed[i].frames[frame].verdict = verified[i].frames[frame].verdict;
        }
    }
}

Result<BenchDocument> bench_scene(const std::string& scene, const CompareOptions& options,
                                  const Streams& streams)
{
    const auto session = Session::open(scene, options.stage, streams.err);
    if (!session) {
        return session.error();
    }
    const auto views = (*session)->views(options.stage.path);
    if (!views) {
        return views.error();
    }
    streams.out << load_summary((*session)->model());
    const Stage stage = (*session)->stage();
    const auto contenders = contenders_of(**session, options, References::always);
    if (!contenders) {
        return contenders.error();
    }
    BenchDocument document = describe(**session, options, options.stage.path, views->size());
    {
        Progress progress{streams.err, streams.watcher, "measuring " + document.scene};
        auto runs = measure(
            stage, *contenders, *views,
            {.repeat = options.repeat, .progress = [&](double share) { progress.show(share); }});
        if (!runs) {
            return runs.error();
        }
        document.runs = std::move(*runs);
        document.preparation = (*session)->preparation(); // now it knows of the trees that followed
    }
    if (options.verify) {
        Progress progress{streams.err, streams.watcher, "verifying " + document.scene};
        const auto verified =
            verify(stage, *contenders, *views, [&](double share) { progress.show(share); });
        if (!verified) {
            return verified.error();
        }
        take_verdicts(document.runs, *verified);
    }
    return document;
}

} // namespace

Result<int> bench_command(const CompareOptions& options, const Streams& streams)
{
    if (const auto checked = check_compare_options(options, streams.err); !checked) {
        return checked.error();
    }
    auto files = ReportFiles::open(options);
    if (!files) {
        return files.error();
    }
    std::vector<BenchDocument> documents;
    int code = kDone;
    for (const std::string& scene : options.scenes) {
        auto document = bench_scene(scene, options, streams);
        if (!document) {
            return document.error();
        }
        streams.out << bench_table(*document) << std::endl;
        print_differences(document->runs, streams.out);
        code = worse(code, promises_kept(document->runs) ? kDone : kDiffers);
        code = worse(code, judge_evidence(*document, false, options.stage.strict, streams.out));
        documents.push_back(std::move(*document));
    }
    if (const auto written = files->write(documents); !written) {
        return written.error();
    }
    return code;
}

} // namespace occlude::tools
