// The arguments of list, generate, convert and replay.
#include "commands/cli_options.h"
#include "commands/commands.h"

namespace occlude::tools {

namespace {

// Adds a command whose options need only parsing: `command` runs on them.
template <class Options>
Command& add_plain(CommandLine& line, const std::string& name, const std::string& help,
                   const std::shared_ptr<Options>& options,
                   Result<int> (*command)(const Options&, const Streams&))
{
    return line.add(name, help, [options, command](const Command&, const Streams& streams) {
        return command(*options, streams);
    });
}

Argument output_glb(std::string& out)
{
    return {.name = "--out", .target = &out, .help = "FILE.glb", .required = true, .is_file = true};
}

void add_list(CommandLine& line)
{
    const auto options = std::make_shared<ListOptions>();
    add_plain(line, "list", "List the available choices", options, &list_command)
        .add({{.name = "what",
               .target = &options->what,
               .help = "algorithms, hierarchies, devices, scenes or paths",
               .required = true},
              {.name = "scene",
               .target = &options->scene,
               .help = "With paths: also list the paths of this scene"}});
}

void add_generate(CommandLine& line)
{
    const auto options = std::make_shared<GenerateOptions>();
    add_plain(line, "generate", "Write a generated scene as a file", options, &generate_command)
        .add({{.name = "scene",
               .target = &options->scene,
               .help = "A scene from 'occlude list scenes'",
               .type = "KIND[:KEY=VALUE,...]",
               .required = true},
              output_glb(options->out)});
}

void add_convert(CommandLine& line)
{
    const auto options = std::make_shared<ConvertOptions>();
    Command& convert = add_plain(
        line, "convert", "Write the scene of a file as GLB: in metres, +y up, and fast to load",
        options, &convert_command);
    convert.add({{.name = "scene",
                  .target = &options->scene,
                  .help = "A file",
                  .type = "FILE",
                  .required = true},
                 output_glb(options->out)});
    add_file_arguments(convert, options->file);
    convert.add({.name = "--strict",
                 .target = &options->strict,
                 .help = "Refuse files of which something is left out",
                 .group = kFileGroup});
}

void add_replay(CommandLine& line)
{
    const auto options = std::make_shared<ReplayOptions>();
    add_plain(line, "replay",
              "Repeat a run that 'bench --record' wrote, without its scene or a graphics card; "
              "exit code 1 if an algorithm decides differently",
              options, &replay_command)
        .add({{.name = "file",
               .target = &options->file,
               .help = "A file that 'bench --record' wrote",
               .type = "FILE",
               .required = true},
              {.name = "--algorithms",
               .target = &options->algorithms,
               .help = "all, or names of recorded runs between commas",
               .shows_default = true},
              {.name = "--json",
               .target = &options->json,
               .help = "Write the outcome as JSON",
               .type = "FILE",
               .is_file = true}});
}

} // namespace

void add_file_commands(CommandLine& line)
{
    add_list(line);
    add_generate(line);
    add_convert(line);
    add_replay(line);
}

} // namespace occlude::tools
