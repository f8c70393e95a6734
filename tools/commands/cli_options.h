// Arguments that several commands take, and the commands with their arguments.
#pragma once

#include "commands/arguments.h"
#include "options/options.h"

#include <cstdint>
#include <string>

namespace occlude::tools {

/// The stage options, with the values that arrive as text because they need more than the parser's
/// own conversions.
struct RawStage {
    StageOptions stage;
    std::string size = "1280x720";
};

/// The largest number of frames of a path.
inline constexpr uint64_t kMaxFrames = 1000000;

/// The arguments of every command with a scene. `several`: whether --hierarchy takes more than one.
void add_stage_arguments(Command& command, RawStage& raw, bool several);
void add_frames_argument(Command& command, StageOptions& stage);

/// The heading of options for scenes that are files, in the help.
inline constexpr const char* kFileGroup = "Scenes that are files";

/// --origin, --unit, --up and the limits of reading.
void add_file_arguments(Command& command, FileOptions& file);

/// Converts the texts into options.
Result<StageOptions> finish_stage(const RawStage& raw, const Command& command);

/// bench and verify.
void add_compare_commands(CommandLine& line);

/// render, view and info.
void add_scene_commands(CommandLine& line);

/// list, generate, convert and replay.
void add_file_commands(CommandLine& line);

} // namespace occlude::tools
