// The arguments of render, view and info.
#include "commands/cli_options.h"
#include "commands/commands.h"

namespace occlude::tools {

namespace {

// The frames of the path, for commands in which --frames means something else.
Argument path_frames(StageOptions& stage)
{
    return {.name = "--path-frames",
            .target = &stage.frames,
            .help = "Number of frames on the whole path",
            .shows_default = true,
            .whole = {{1, kMaxFrames}}};
}

void add_render(CommandLine& line)
{
    struct Arguments {
        RawStage raw;
        RenderOptions render;
    };
    const auto arguments = std::make_shared<Arguments>();
    const auto run = [arguments](const Command& command, const Streams& streams) -> Result<int> {
        const auto stage = finish_stage(arguments->raw, command);
        if (!stage) {
            return stage.error();
        }
        arguments->render.stage = *stage;
        return render_command(arguments->render, streams);
    };
    Command& command = line.add("render", "Draw culled frames as PNG", run);
    RenderOptions& render = arguments->render;
    command.add({{.name = "scene",
                  .target = &render.scene,
                  .help = "A file, or a scene from 'occlude list scenes'",
                  .type = "SCENE",
                  .required = true},
                 {.name = "--algorithm",
                  .target = &render.algorithm,
                  .help = "The algorithm that culls",
                  .shows_default = true}});
    add_stage_arguments(command, arguments->raw, false);
    command.add(
        {path_frames(arguments->raw.stage),
         {.name = "--frame",
          .target = &render.frame,
          .help = "The frame of the path to draw, from 0; the 30 frames before it are culled first",
          .whole = {{0, kMaxFrames - 1}}},
         {.name = "--frames",
          .target = &render.frame_range,
          .help = "Draw the frames FIRST:LAST into a directory",
          .excludes = "--frame"},
         {.name = "--out",
          .target = &render.out,
          .help = "FILE.png, or a directory for --frames",
          .required = true,
          .is_file = true},
         {.name = "--show",
          .target = &render.show,
          .help = "visible, hidden, boxes or states (default: visible; overview: states)"},
         {.name = "--camera",
          .target = &render.camera,
          .help = "path, or overview (from high above)",
          .shows_default = true}});
}

void add_view(CommandLine& line)
{
    struct Arguments {
        RawStage raw;
        ViewOptions view;
    };
    const auto arguments = std::make_shared<Arguments>();
    const auto run = [arguments](const Command& command, const Streams& streams) -> Result<int> {
        const auto stage = finish_stage(arguments->raw, command);
        if (!stage) {
            return stage.error();
        }
        arguments->view.stage = *stage;
        if (command.given("--size")) {
            arguments->view.size = stage->size;
        }
        return view_command(arguments->view, streams);
    };
    Command& command = line.add("view", "Show culling in an interactive viewer", run);
    ViewOptions& view = arguments->view;
    command.add({{.name = "scene",
                  .target = &view.scene,
                  .help = "A file, or a scene from 'occlude list scenes'; without one, drop a file",
                  .type = "SCENE"},
                 {.name = "--algorithm",
                  .target = &view.algorithm,
                  .help = "The algorithm that culls at first (default: the one used last)"}});
    add_stage_arguments(command, arguments->raw, false);
    command.add({path_frames(arguments->raw.stage),
                 {.name = "--scale",
                  .target = &view.scale,
                  .help = "Scale of panels; 1 is 96 dots per inch (default: the screen's)",
                  .real = {{0.5f, 4.0f}}},
                 {.name = "--headless",
                  .target = &view.headless,
                  .help = "Run without a window; needs --frames or --script to end"},
                 {.name = "--frames",
                  .target = &view.frames,
                  .help = "End after this many frames",
                  .whole = {{1, kMaxFrames}}},
                 {.name = "--screenshot",
                  .target = &view.screenshot,
                  .help = "Write the last frame of the window",
                  .type = "FILE.png"},
                 {.name = "--script",
                  .target = &view.script,
                  .help = "Play the inputs in FILE, then end",
                  .type = "FILE"}});
}

void add_info(CommandLine& line)
{
    struct Arguments {
        RawStage raw;
        InfoOptions info;
    };
    const auto arguments = std::make_shared<Arguments>();
    const auto run = [arguments](const Command& command, const Streams& streams) -> Result<int> {
        const auto stage = finish_stage(arguments->raw, command);
        if (!stage) {
            return stage.error();
        }
        arguments->info.stage = *stage;
        return info_command(arguments->info, streams);
    };
    Command& command =
        line.add("info", "Say what is in a scene and whether culling is likely to pay", run);
    command.add({.name = "scene",
                 .target = &arguments->info.scene,
                 .help = "A file or a generated scene",
                 .type = "SCENE",
                 .required = true});
    constexpr size_t kSampledFrames = 8;
    arguments->raw.stage.frames = kSampledFrames;
    add_stage_arguments(command, arguments->raw, false);
    add_frames_argument(command, arguments->raw.stage);
    command.add({.name = "--json",
                 .target = &arguments->info.json,
                 .help = "Write all information as JSON",
                 .type = "FILE",
                 .is_file = true});
}

} // namespace

void add_scene_commands(CommandLine& line)
{
    add_render(line);
    add_view(line);
    add_info(line);
}

} // namespace occlude::tools
