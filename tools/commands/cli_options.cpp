#include "commands/cli_options.h"

#include "session/hierarchies.h"

namespace occlude::tools {

void add_file_arguments(Command& command, FileOptions& file)
{
    constexpr uint64_t kMaxSeconds = 1000000;
    constexpr uint64_t kMaxMebibytes = uint64_t{1} << 24;
    command.add(
        {{.name = "--origin",
          .target = &file.origin,
          .help = "X,Y,Z: the point of the file that becomes (0, 0, 0) (default: moved only if "
                  "single precision would distort it)",
          .group = kFileGroup},
         {.name = "--unit",
          .target = &file.unit,
          .help =
              "m, cm, mm, in, ft, or the number of units in a metre (default: as the file or its "
              "format says, else guessed)",
          .group = kFileGroup},
         {.name = "--up",
          .target = &file.up,
          .help = "x, y, z, or -x, -y, -z (default: as for --unit)",
          .group = kFileGroup},
         {.name = "--load-seconds",
          .target = &file.load_seconds,
          .help = "Seconds after which Assimp is stopped while it reads a file",
          .group = kFileGroup,
          .shows_default = true,
          .whole = {{1, kMaxSeconds}}},
         {.name = "--load-memory",
          .target = &file.load_memory_mib,
          .help = "Memory limit for reading a file, in MiB (default: half of the machine's memory)",
          .group = kFileGroup,
          .whole = {{1, kMaxMebibytes}}}});
}

void add_stage_arguments(Command& command, RawStage& raw, bool several)
{
    constexpr uint64_t kMaxSamples = 64;
    constexpr uint64_t kMaxTriangles = 0xffffffff;
    StageOptions& stage = raw.stage;
    command.add(
        {{.name = "--hierarchy",
          .target = &stage.hierarchy,
          .help = "The tree over the scene: " + hierarchy_names() +
                  (several ? "; several between commas, or all" : "") +
                  "; NAME:OPTION=VALUE is one with its own option",
          .shows_default = true},
         {.name = "--device",
          .target = &stage.device,
          .help = "The device that draws and tests: gl, cpu, or cpu_fast (gl draws, the CPU tests) "
                  "(default: gl, or cpu if there is no OpenGL)"},
         {.name = "--test",
          .target = &stage.test,
          .help = "How boxes are tested: queries, raster (only gl) or pyramid",
          .shows_default = true},
         {.name = "--path",
          .target = &stage.path,
          .help = "The camera's path: auto, a name from 'occlude list paths', or a FILE.json",
          .shows_default = true},
         {.name = "--size",
          .target = &raw.size,
          .help = "Size of the image in pixels, WIDTHxHEIGHT",
          .shows_default = true},
         {.name = "--msaa",
          .target = &stage.samples,
          .help = "Samples per pixel; drivers may give more, and the table shows the number",
          .shows_default = true,
          .whole = {{1, kMaxSamples}}},
         {.name = "--set",
          .target = &stage.sets,
          .help = "An option of an algorithm or a hierarchy: NAME.OPTION=VALUE"},
         {.name = "--leaf-triangles",
          .target = &stage.leaf_triangles,
          .help = "Nodes with at most this many triangles are leaves; 0: only nodes without "
                  "children are",
          .shows_default = true,
          .whole = {{0, kMaxTriangles}}},
         {.name = "--item-triangles",
          .target = &stage.item_triangles,
          .help = "Meshes with more triangles are divided into items of at most this many",
          .shows_default = true,
          .whole = {{1, kMaxTriangles}}},
         {.name = "--split",
          .target = &stage.split,
          .help = "How larger meshes are divided: centroid (between triangles) or exact (planes "
                  "cut triangles)",
          .shows_default = true},
         {.name = "--cache",
          .target = &stage.cache_folder,
          .help = "Folder for exactly split meshes (default: occlude in the user's cache)",
          .type = "DIR"}});
    add_file_arguments(command, stage.file);
    command.add({.name = "--strict",
                 .target = &stage.strict,
                 .help = "Refuse files that cannot be drawn completely; coincident surfaces count "
                         "as differences",
                 .group = kFileGroup});
}

void add_frames_argument(Command& command, StageOptions& stage)
{
    command.add({.name = "--frames",
                 .target = &stage.frames,
                 .help = "Number of frames on the path",
                 .shows_default = true,
                 .whole = {{1, kMaxFrames}}});
}

Result<StageOptions> finish_stage(const RawStage& raw, const Command& command)
{
    StageOptions stage = raw.stage;
    const auto size = parse_size(raw.size);
    if (!size) {
        return command.misused(size.error().message);
    }
    stage.size = *size;
    return stage;
}

} // namespace occlude::tools
