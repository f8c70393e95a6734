// Options that several commands take, for the command line.
#pragma once

#include "options/options.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>

namespace occlude::tools {

/// The heading of options about scenes that are files.
inline constexpr const char* kFileGroup = "Scenes that are files";

/// Accepts whole numbers in a range; larger ones than memory could hold are typing errors.
CLI::Validator whole_number(uint64_t low, uint64_t high);

/// Refuses an empty name: one that was left out in a script, as in --json "$UNSET", is an error.
CLI::Validator file_name();

/// Options that need more than CLI11's own conversions arrive as text first.
struct RawStage {
    StageOptions stage;
    std::string device;
    std::string size = "1280x720";
    std::string cache_folder;
};

/// The most frames of a path.
inline constexpr uint64_t kMaxFrames = 1000000;

/// The options of every command with a scene. `several`: whether --hierarchy takes more than one.
void add_stage_options(CLI::App& app, RawStage& raw, bool several);
void add_frames_option(CLI::App& app, StageOptions& stage);

/// Turns what came as text into options. Throws CLI::ValidationError.
StageOptions finish_stage(const RawStage& raw, const CLI::App& app);

/// --origin, --unit, --up and the limits of reading.
void add_file_options(CLI::App& app, FileOptions& file);

} // namespace occlude::tools
