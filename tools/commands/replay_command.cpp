#include "commands/commands.h"

#include "files/json.h"
#include "files/output_file.h"
#include "replay/replay.h"
#include "report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <ostream>

namespace occlude::tools {

namespace {

Result<RunRecording> read_recording(const std::string& file)
{
    std::ifstream stream{file, std::ios::binary};
    if (!stream) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: cannot be read; give a file that 'occlude bench SCENE "
                                 "--record FILE' wrote",
                                 file)};
    }
    const std::string bytes{std::istreambuf_iterator<char>{stream}, {}};
    return from_bytes(bytes, file);
}

Result<std::vector<const RecordedRun*>> choose_runs(const RunRecording& recording,
                                                    const std::string& algorithms)
{
    std::vector<const RecordedRun*> chosen;
    if (algorithms == "all") {
        for (const RecordedRun& run : recording.runs) {
            chosen.push_back(&run);
        }
        return chosen;
    }
    for (const std::string& name : split_commas(algorithms)) {
        const size_t before = chosen.size();
        std::string known;
        for (const RecordedRun& run : recording.runs) {
            known += (known.empty() ? "" : ", ") + run.name;
            if (run.name == name || run.algorithm == name) {
                chosen.push_back(&run);
            }
        }
        if (chosen.size() == before) {
            return Error{ErrorCode::not_found,
                         fmt::format("--algorithms: no run of '{}' was recorded; there are {}",
                                     name, known)};
        }
    }
    return chosen;
}

Result<std::vector<ReplayedRun>> replay_all(const RunRecording& recording,
                                            std::span<const RecordedRun* const> chosen,
                                            const Streams& streams)
{
    Progress progress{streams.err, streams.watcher, "replaying " + recording.scene};
    std::vector<ReplayedRun> runs;
    for (const RecordedRun* run : chosen) {
        auto replayed = replay(recording, *run, [&](double share) {
            progress.show((static_cast<double>(runs.size()) + share) /
                          static_cast<double>(chosen.size()));
        });
        if (!replayed) {
            return replayed.error();
        }
        runs.push_back(std::move(*replayed));
    }
    return runs;
}

std::string table_of(std::span<const ReplayedRun> runs)
{
    std::vector<std::vector<std::string>> rows{
        {"algorithm", "hierarchy", "frames", "items drawn", "decisions"}};
    for (const ReplayedRun& run : runs) {
        rows.push_back({run.name, run.tree, std::to_string(run.frames),
                        std::to_string(run.items_drawn),
                        run.identical() ? "as recorded" : run.mismatch});
    }
    return align_columns(rows);
}

std::string json_of(const RunRecording& recording, std::span<const ReplayedRun> runs)
{
    Json list = Json::array();
    for (const ReplayedRun& run : runs) {
        list.push_back(Json::object({{"algorithm", run.name},
                                     {"hierarchy", run.tree},
                                     {"frames", run.frames},
                                     {"items_drawn", run.items_drawn},
                                     {"identical", run.identical()},
                                     {"mismatch", run.mismatch}}));
    }
    return Json::object({{"version", 1}, {"scene", recording.scene}, {"runs", std::move(list)}})
               .dump(1) +
           '\n';
}

} // namespace

Result<int> replay_command(const ReplayOptions& options, const Streams& streams)
{
    std::optional<OutputFile> json;
    if (!options.json.empty()) {
        auto file = OutputFile::open(options.json);
        if (!file) {
            return file.error();
        }
        json = std::move(*file);
    }
    const auto recording = read_recording(options.file);
    if (!recording) {
        return recording.error();
    }
    const auto chosen = choose_runs(*recording, options.algorithms);
    if (!chosen) {
        return chosen.error();
    }
    auto replayed = replay_all(*recording, *chosen, streams);
    if (!replayed) {
        return replayed.error();
    }
    const std::vector<ReplayedRun>& runs = *replayed;
    streams.out << recording->scene << '\n' << table_of(runs);
    if (json) {
        if (const auto written = json->commit(json_of(*recording, runs)); !written) {
            return written.error();
        }
    }
    const bool all = std::all_of(runs.begin(), runs.end(),
                                 [](const ReplayedRun& run) { return run.identical(); });
    return all ? kDone : kDiffers;
}

} // namespace occlude::tools
