// Replays a recording, and makes one.
#pragma once

#include "measure/stage.h"
#include "replay/run_recording.h"

#include <occlude/core/result.h>

#include <span>
#include <string>

namespace occlude::tools {

/// The result of a replayed run.
struct ReplayedRun {
    std::string name;
    std::string tree;
    size_t frames = 0;        ///< number of frames with the recorded decisions
    uint64_t items_drawn = 0; ///< over all frames
    std::string mismatch;     ///< the first difference as a sentence; empty: there was none

    bool identical() const { return mismatch.empty(); }
};

/// Runs one of the recording's runs with the recorded answers of its device. Error: this version
/// does not have the algorithm or an option.
Result<ReplayedRun> replay(const RunRecording& recording, const RecordedRun& run,
                           const ProgressCallback& progress = {});

/// An algorithm to be recorded.
struct RunToRecord {
    std::string name;      ///< as in tables
    std::string algorithm; ///< as in the registry
    std::vector<OptionValue> options;
    std::string tree_name; ///< as in --hierarchy
    const Hierarchy* tree = nullptr;
};

/// Walks the path once with each algorithm on the stage's device, and records everything. Error: an
/// algorithm cannot be made, or the scene moves (recordings hold static scenes).
Result<RunRecording> record(const Stage& stage, const std::string& scene,
                            std::span<const RunToRecord> runs, std::span<const View> views,
                            const ProgressCallback& progress = {});

} // namespace occlude::tools
