// Running a recording again, and making one.
#pragma once

#include "measure/stage.h"
#include "replay/run_recording.h"

#include <occlude/core/result.h>

#include <span>
#include <string>

namespace occlude::tools {

/// How a run went that was repeated.
struct ReplayedRun {
    std::string name;
    std::string tree;
    size_t frames = 0;        ///< whose decisions were the recorded ones
    uint64_t items_drawn = 0; ///< over all frames
    std::string mismatch;     ///< what differed first, as a sentence; empty: nothing did

    bool identical() const { return mismatch.empty(); }
};

/// Runs one of the recording's runs over what its device answered. Error: this version does not
/// have the algorithm or an option.
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

/// Walks the path once with each algorithm, on the stage's device, and keeps everything. Error: an
/// algorithm cannot be made, or the scene moves (recordings hold scenes that stand still).
Result<RunRecording> record(const Stage& stage, const std::string& scene,
                            std::span<const RunToRecord> runs, std::span<const View> views,
                            const ProgressCallback& progress = {});

} // namespace occlude::tools
