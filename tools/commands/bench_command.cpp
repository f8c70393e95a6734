#include "commands/comparison.h"
#include "commands/open_session.h"
#include "measure/measure.h"
#include "measure/verify.h"
#include "replay/replay.h"
#include "report/headline.h"
#include "report/table.h"
#include "session/worst_frames.h"

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

// Walks the path once more and records everything that `replay` needs.
Result<bool> record_scene(Session& session, std::span<const Contender> contenders,
                          std::span<const View> views, const OutputFile& file,
                          const Streams& streams)
{
    std::vector<RunToRecord> runs;
    for (const Contender& contender : contenders) {
        const NamedEntry entry = parse_entry(contender.name).value_or(NamedEntry{});
        std::vector<OptionValue> values = settings_of(entry.name, session.options().sets);
        values.insert(values.end(), entry.options.begin(), entry.options.end());
        runs.push_back({contender.name, entry.name, values, contender.hierarchy,
                        contender.tree != nullptr ? contender.tree : &session.hierarchy()});
    }
    Progress progress{streams.err, streams.watcher, "recording " + session.model().name};
    const auto recording = record(session.stage(), session.model().name, runs, views,
                                  [&](double share) { progress.show(share); });
    if (!recording) {
        return recording.error();
    }
    const auto bytes = to_bytes(*recording);
    return bytes ? OutputFile{file}.commit(*bytes) : Result<bool>{bytes.error()};
}

Result<std::optional<OutputFile>> open_record(const CompareOptions& options)
{
    if (options.record.empty()) {
        return std::optional<OutputFile>{};
    }
    if (options.scenes.size() != 1) {
        return Error{ErrorCode::invalid_argument, "--record: give one SCENE"};
    }
    auto file = OutputFile::open(options.record);
    if (!file) {
        return file.error();
    }
    return std::optional<OutputFile>{std::move(*file)};
}

// Pictures of the worst frames of the run that the report describes.
Result<bool> add_pictures(Session& session, std::span<const Contender> contenders,
                          BenchDocument& document)
{
    constexpr size_t kFrames = 2;
    const auto chosen = chosen_run(document);
    const auto cameras = session.cameras(document.path);
    if (!chosen || !cameras) {
        return true;
    }
    auto pictures = picture_worst_frames(session, contenders[*chosen], document.runs[*chosen],
                                         *cameras, kFrames);
    if (!pictures) {
        return pictures.error();
    }
    document.pictures = std::move(*pictures);
    return true;
}

Result<BenchDocument> bench_scene(const std::string& scene, const CompareOptions& options,
                                  const std::optional<OutputFile>& record_file,
                                  const Streams& streams)
{
    const auto session = open_session(scene, options.stage, streams);
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
    if (record_file && stage.go_to) {
        return Error{ErrorCode::unsupported,
                     "--record: '" + scene + "' moves; recordings hold static scenes"};
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
        document.preparation = (*session)->preparation(); // the document now includes the times of
                                                          // the trees that followed the motion
    }
    if (options.verify) {
        Progress progress{streams.err, streams.watcher, "verifying " + document.scene};
        const auto verified =
            verify(stage, *contenders, *views, [&](double share) { progress.show(share); });
        if (!verified) {
            return verified.error();
        }
        take_verdicts(document.runs, *verified);
        document.coincident = coincident_objects(**session, document.runs);
    }
    if (!options.html.empty()) {
        if (const auto pictured = add_pictures(**session, *contenders, document); !pictured) {
            return pictured.error();
        }
    }
    if (record_file) {
        const auto recorded = record_scene(**session, *contenders, *views, *record_file, streams);
        if (!recorded) {
            return recorded.error();
        }
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
    const auto record_file = open_record(options);
    if (!record_file) {
        return record_file.error();
    }
    std::vector<BenchDocument> documents;
    int code = kDone;
    for (const std::string& scene : options.scenes) {
        auto document = bench_scene(scene, options, *record_file, streams);
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
