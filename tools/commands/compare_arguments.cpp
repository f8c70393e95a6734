// The arguments of bench and verify.
#include "commands/cli_options.h"
#include "commands/commands.h"
#include "suites/suite.h"

#include <fmt/core.h>

namespace occlude::tools {

namespace {

constexpr uint64_t kMaxRepeats = 10000;

struct CompareArguments {
    RawStage raw;
    CompareOptions compare;
    SuiteOptions suite; ///< bench only
};

void add_compare_arguments(Command& command, CompareArguments& arguments, bool scenes_required)
{
    CompareOptions& compare = arguments.compare;
    command.add(
        {{.name = "scenes",
          .target = &compare.scenes,
          .help = "Files, or scenes from 'occlude list scenes'",
          .type = "SCENE...",
          .required = scenes_required},
         {.name = "--algorithms",
          .target = &compare.algorithms,
          .help = "all, exact, or names between commas; NAME:OPTION=VALUE is one with its own "
                  "option",
          .shows_default = true}});
    add_stage_arguments(command, arguments.raw, true);
    add_frames_argument(command, arguments.raw.stage);
    command.add({{.name = "--repeat",
                  .target = &compare.repeat,
                  .help = "Number of walks along the path; figures are medians over the walks",
                  .shows_default = true,
                  .whole = {{1, kMaxRepeats}}},
                 {.name = "--verify",
                  .target = &compare.verify,
                  .help = "Compare every frame with the frustum-only image"},
                 {.name = "--json",
                  .target = &compare.json,
                  .help = "Write the measurements as JSON",
                  .type = "FILE",
                  .is_file = true},
                 {.name = "--csv",
                  .target = &compare.csv,
                  .help = "Write one row per algorithm as CSV",
                  .type = "FILE",
                  .is_file = true},
                 {.name = "--html",
                  .target = &compare.html,
                  .help = "Write a report for the browser",
                  .type = "FILE",
                  .is_file = true}});
}

void add_suite_arguments(Command& command, SuiteOptions& suite)
{
    const std::string group =
        "A suite instead of scenes (combines only with --device, --cache and output files)";
    command.add({{.name = "--suite",
                  .target = &suite.suite,
                  .help = "The suite to measure: " + suite_names(),
                  .group = group},
                 {.name = "--scale",
                  .target = &suite.scale,
                  .help = "small, or full (scenes as large as published)",
                  .group = group,
                  .shows_default = true},
                 {.name = "--only",
                  .target = &suite.only,
                  .help = "Measure only these entries of the suite, between commas",
                  .type = "ENTRY,...",
                  .group = group},
                 {.name = "--add",
                  .target = &suite.add,
                  .help = "Keep the other entries in the file of --json",
                  .group = group},
                 {.name = "--from",
                  .target = &suite.from,
                  .help = "Measure nothing: report on the results in FILE",
                  .type = "FILE",
                  .group = group,
                  .is_file = true},
                 {.name = "--report",
                  .target = &suite.report,
                  .help = "Markdown that sets the results beside the published figures (papers; "
                          "default: " +
                          std::string{kDefaultReport} + ")",
                  .type = "FILE",
                  .group = group,
                  .is_file = true}});
}

// A suite decides what to measure; without one there must be scenes.
std::optional<std::string> misused_suite(const Command& bench, bool suite)
{
    if (!suite && !bench.given("scenes")) {
        return "scenes: give at least one SCENE, or --suite";
    }
    const std::initializer_list<const char*> of_suites = {"--scale", "--only", "--add", "--from",
                                                          "--report"};
    const std::initializer_list<const char*> of_scenes = {
        "scenes",           "--algorithms", "--hierarchy", "--test",         "--path",
        "--size",           "--msaa",       "--set",       "--frames",       "--leaf-triangles",
        "--item-triangles", "--split",      "--repeat",    "--verify",       "--origin",
        "--unit",           "--up",         "--strict",    "--load-seconds", "--load-memory",
        "--record"};
    for (const char* argument : suite ? of_scenes : of_suites) {
        if (bench.given(argument)) {
            return suite ? fmt::format("{}: a suite decides this itself; omit it", argument)
                         : fmt::format("{}: goes with --suite only", argument);
        }
    }
    return {};
}

Result<CompareOptions> finish_compare(const CompareArguments& arguments, const Command& command)
{
    const auto stage = finish_stage(arguments.raw, command);
    if (!stage) {
        return stage.error();
    }
    CompareOptions compare = arguments.compare;
    compare.stage = *stage;
    compare.path_given = command.given("--path");
    return compare;
}

Result<int> run_suite(const CompareOptions& compare, SuiteOptions suite, const Streams& streams)
{
    suite.device = compare.stage.device;
    suite.cache_folder = compare.stage.cache_folder;
    suite.json = compare.json;
    suite.csv = compare.csv;
    suite.html = compare.html;
    return suite_command(suite, streams);
}

void add_bench(CommandLine& line)
{
    const auto arguments = std::make_shared<CompareArguments>();
    const auto run = [arguments](const Command& command, const Streams& streams) -> Result<int> {
        const bool suite = !arguments->suite.suite.empty();
        if (const auto problem = misused_suite(command, suite)) {
            return command.misused(*problem);
        }
        const auto compare = finish_compare(*arguments, command);
        if (!compare) {
            return compare.error();
        }
        return suite ? run_suite(*compare, arguments->suite, streams)
                     : bench_command(*compare, streams);
    };
    Command& bench = line.add(
        "bench", "Measure algorithms side by side on scenes, or a whole suite of them", run);
    add_compare_arguments(bench, *arguments, false);
    add_suite_arguments(bench, arguments->suite);
    bench.add(
        {.name = "--record",
         .target = &arguments->compare.record,
         .help =
             "Write a recording, with which 'occlude replay' repeats the run without a graphics "
             "card (one static SCENE): tree, cameras, draws and answers",
         .type = "FILE",
         .is_file = true});
}

void add_verify(CommandLine& line)
{
    const auto arguments = std::make_shared<CompareArguments>();
    const auto run = [arguments](const Command& command, const Streams& streams) -> Result<int> {
        const auto compare = finish_compare(*arguments, command);
        return compare ? verify_command(*compare, streams) : Result<int>{compare.error()};
    };
    Command& verify = line.add(
        "verify",
        "Compare every culled frame with the frustum-only image, on the paths auto and teleport "
        "unless --path names one. Exit code 1: an exact algorithm differs; 3: nothing was in view, "
        "or nothing was hidden",
        run);
    add_compare_arguments(verify, *arguments, true);
    verify.add({.name = "--nothing-hidden-is-fine",
                .target = &arguments->compare.nothing_hidden_is_fine,
                .help = "Exit with 0 even if no frame hides anything"});
}

} // namespace

void add_compare_commands(CommandLine& line)
{
    add_bench(line);
    add_verify(line);
}

} // namespace occlude::tools
