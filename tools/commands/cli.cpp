#include "commands/cli.h"

#include "commands/cli_options.h"
#include "session/hierarchies.h"
#include "suites/suite.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <exception>
#include <ostream>

namespace occlude::tools {

namespace {

constexpr uint64_t kMaxRepeats = 10000;
constexpr std::array kCommands = {"bench", "verify",   "render",  "view",  "info",
                                  "list",  "generate", "convert", "replay"};

void add_compare_options(CLI::App& app, RawStage& raw, CompareOptions& compare)
{
    app.add_option("scenes", compare.scenes, "Files, or scenes of 'occlude list scenes'")
        ->type_name("SCENE...");
    app.add_option(
           "--algorithms", compare.algorithms,
           "all, exact, or names between commas; NAME:OPTION=VALUE is one with its own option")
        ->capture_default_str();
    add_stage_options(app, raw, true);
    add_frames_option(app, raw.stage);
    app.add_option("--repeat", compare.repeat, "Walks along the path; figures are medians of them")
        ->capture_default_str()
        ->check(whole_number(1, kMaxRepeats));
    app.add_flag("--verify", compare.verify, "Compare every frame with the frustum-only image");
    app.add_option("--json", compare.json, "Write the measurements as JSON")
        ->type_name("FILE")
        ->check(file_name());
    app.add_option("--csv", compare.csv, "Write one row per algorithm as CSV")
        ->type_name("FILE")
        ->check(file_name());
    app.add_option("--html", compare.html, "Write a report for the browser")
        ->type_name("FILE")
        ->check(file_name());
}

void add_suite_options(CLI::App& app, SuiteOptions& suite)
{
    const std::string group =
        "A suite instead of scenes (only --device, --cache and the files go with it)";
    app.add_option("--suite", suite.suite, "What is measured, and how: " + suite_names())
        ->group(group);
    app.add_option("--scale", suite.scale, "small, or full: as large as published")
        ->capture_default_str()
        ->group(group);
    app.add_option("--only", suite.only, "Entries of the suite, between commas")
        ->type_name("ENTRY,...")
        ->group(group);
    app.add_flag("--add", suite.add, "Keep the other entries that the file of --json holds")
        ->group(group);
    app.add_option("--from", suite.from, "Measure nothing: report on the results in FILE")
        ->type_name("FILE")
        ->check(file_name())
        ->group(group);
    app.add_option(
           "--report", suite.report,
           "Markdown that sets the results beside the published figures (papers; default: " +
               std::string{kDefaultReport} + ")")
        ->type_name("FILE")
        ->check(file_name())
        ->group(group);
}

// A suite says itself what it measures, and without one there must be scenes. Throws
// CLI::ValidationError.
void check_suite_or_scenes(const CLI::App& bench, bool suite)
{
    if (!suite && bench.count("scenes") == 0) {
        throw CLI::ValidationError{"scenes: give at least one SCENE, or --suite"};
    }
    const std::initializer_list<const char*> of_suites = {"--scale", "--only", "--add", "--from",
                                                          "--report"};
    const std::initializer_list<const char*> of_scenes = {
        "scenes",           "--algorithms", "--hierarchy", "--test",         "--path",
        "--size",           "--msaa",       "--set",       "--frames",       "--leaf-triangles",
        "--item-triangles", "--split",      "--repeat",    "--verify",       "--origin",
        "--unit",           "--up",         "--strict",    "--load-seconds", "--load-memory",
        "--record"};
    for (const char* option : suite ? of_scenes : of_suites) {
        if (bench.count(option) > 0) {
            throw CLI::ValidationError{
                suite ? fmt::format("{}: a suite decides this itself; leave it away", option)
                      : fmt::format("{}: goes with --suite only", option)};
        }
    }
}

void add_render_options(CLI::App& app, RawStage& raw, RenderOptions& render)
{
    app.add_option("scene", render.scene, "A file, or a scene of 'occlude list scenes'")
        ->required()
        ->type_name("SCENE");
    app.add_option("--algorithm", render.algorithm, "The algorithm that culls")
        ->capture_default_str();
    add_stage_options(app, raw, false);
    app.add_option("--path-frames", raw.stage.frames, "Frames of the whole path")
        ->capture_default_str()
        ->check(whole_number(1, kMaxFrames));
    CLI::Option* frame =
        app.add_option(
               "--frame", render.frame,
               "The frame of the path to draw, from 0; the 30 frames before it are culled first")
            ->check(whole_number(0, kMaxFrames - 1));
    app.add_option("--frames", render.frame_range, "The frames FIRST:LAST to draw into a directory")
        ->excludes(frame);
    app.add_option("--out", render.out, "FILE.png, or a directory for --frames")
        ->required()
        ->check(file_name());
    app.add_option("--show", render.show,
                   "visible, hidden, boxes or states (default: visible; overview: states)");
    app.add_option("--camera", render.camera, "path, or overview: from high above")
        ->capture_default_str();
}

void add_view_options(CLI::App& app, RawStage& raw, ViewOptions& view)
{
    app.add_option("scene", view.scene,
                   "A file, or a scene of 'occlude list scenes'; without one, drop a file")
        ->type_name("SCENE");
    app.add_option("--algorithm", view.algorithm,
                   "The algorithm that culls at first (default: that of the last time)");
    add_stage_options(app, raw, false);
    app.add_option("--path-frames", raw.stage.frames, "Frames of the whole path")
        ->capture_default_str()
        ->check(whole_number(1, kMaxFrames));
    app.add_option("--scale", view.scale,
                   "Size of panels; 1 is 96 dots per inch (default: the "
                   "screen's)")
        ->check(CLI::Range(0.5f, 4.0f));
    app.add_flag("--headless", view.headless, "Without a window; ends after --frames or --script");
    app.add_option("--frames", view.frames, "Ends after so many frames")
        ->check(whole_number(1, kMaxFrames));
    app.add_option("--screenshot", view.screenshot, "Write the last frame of the window")
        ->type_name("FILE.png");
    app.add_option("--script", view.script, "Play the inputs in FILE, then end")->type_name("FILE");
}

class Program {
public:
    Program()
        : app_("occlude: what a renderer need not draw, and the proof of it", "occlude")
    {
        app_.require_subcommand(1);
        app_.set_version_flag("--version", std::string{"occlude "} + OCCLUDE_VERSION);
        bench_ = app_.add_subcommand(
            "bench", "Measure algorithms side by side on scenes, or a whole suite of them");
        add_compare_options(*bench_, compare_stage_, compare_);
        add_suite_options(*bench_, suite_);
        bench_
            ->add_option("--record", compare_.record,
                         "Write what 'occlude replay' needs to repeat the run without a graphics "
                         "card: tree, cameras, draws and answers (one SCENE that stands still)")
            ->type_name("FILE")
            ->check(file_name());
        verify_ = app_.add_subcommand(
            "verify", "Compare every culled frame with the frustum-only image; exit code 1 if an "
                      "exact algorithm differs, 3 if nothing was in view or nothing hidden. Walks "
                      "the paths auto and teleport unless --path "
                      "names one");
        add_compare_options(*verify_, compare_stage_, compare_);
        verify_->get_option("scenes")->required();
        verify_->add_flag("--nothing-hidden-is-fine", compare_.nothing_hidden_is_fine,
                          "Exit with 0 though nothing is hidden in any frame");
        render_ = app_.add_subcommand("render", "Draw culled frames as PNG");
        add_render_options(*render_, render_stage_, render_options_);
        view_ = app_.add_subcommand("view", "Look at culling in an interactive viewer");
        add_view_options(*view_, view_stage_, view_options_);
        info_ = app_.add_subcommand("info",
                                    "Say what is in a scene and whether culling is likely to pay");
        info_->add_option("scene", info_options_.scene, "A file or a generated scene")
            ->required()
            ->type_name("SCENE");
        info_stage_.stage.frames = 8;
        add_stage_options(*info_, info_stage_, false);
        add_frames_option(*info_, info_stage_.stage);
        list_ = app_.add_subcommand("list", "List what there is to choose from");
        list_
            ->add_option("what", list_options_.what,
                         "algorithms, hierarchies, devices, scenes or paths")
            ->required();
        list_->add_option("scene", list_options_.scene, "For paths: the scene whose paths to list");
        replay_ = app_.add_subcommand(
            "replay", "Repeat a run that 'bench --record' wrote, without its scene or a graphics "
                      "card; exit code 1 if an algorithm decides differently");
        replay_->add_option("file", replay_options_.file, "What 'bench --record' wrote")
            ->required()
            ->type_name("FILE");
        replay_
            ->add_option("--algorithms", replay_options_.algorithms,
                         "all, or names of recorded runs between commas")
            ->capture_default_str();
        replay_->add_option("--json", replay_options_.json, "Write the outcome as JSON")
            ->type_name("FILE")
            ->check(file_name());
        generate_ = app_.add_subcommand("generate", "Write a generated scene as a file");
        generate_->add_option("scene", generate_options_.scene, "A scene of 'occlude list scenes'")
            ->required()
            ->type_name("KIND[:KEY=VALUE,...]");
        generate_->add_option("--out", generate_options_.out, "FILE.glb")
            ->required()
            ->check(file_name());
        convert_ = app_.add_subcommand(
            "convert", "Write the scene of a file as GLB: in metres, +y up, and fast to load");
        convert_->add_option("scene", convert_options_.scene, "A file")
            ->required()
            ->type_name("FILE");
        convert_->add_option("--out", convert_options_.out, "FILE.glb")
            ->required()
            ->check(file_name());
        add_file_options(*convert_, convert_options_.file);
    }

    CLI::App& app() { return app_; }

    /// Runs the subcommand that was parsed. Throws CLI::ParseError.
    Result<int> run(const Streams& streams)
    {
        if (bench_->parsed()) {
            check_suite_or_scenes(*bench_, !suite_.suite.empty());
            if (!suite_.suite.empty()) {
                return suite_command(finish_suite(), streams);
            }
        }
        if (bench_->parsed() || verify_->parsed()) {
            const CLI::App& parsed = bench_->parsed() ? *bench_ : *verify_;
            compare_.stage = finish_stage(compare_stage_, parsed);
            compare_.path_given = parsed.count("--path") > 0;
            return bench_->parsed() ? bench_command(compare_, streams)
                                    : verify_command(compare_, streams);
        }
        if (render_->parsed()) {
            render_options_.stage = finish_stage(render_stage_, *render_);
            return render_command(render_options_, streams);
        }
        if (view_->parsed()) {
            view_options_.stage = finish_stage(view_stage_, *view_);
            if (view_->count("--size") > 0) {
                view_options_.size = view_options_.stage.size;
            }
            return view_command(view_options_, streams);
        }
        if (info_->parsed()) {
            info_options_.stage = finish_stage(info_stage_, *info_);
            return info_command(info_options_, streams);
        }
        if (convert_->parsed()) {
            return convert_command(convert_options_, streams);
        }
        if (replay_->parsed()) {
            return replay_command(replay_options_, streams);
        }
        if (generate_->parsed()) {
            return generate_command(generate_options_, streams);
        }
        return list_command(list_options_, streams);
    }

private:
    SuiteOptions finish_suite() const
    {
        SuiteOptions suite = suite_;
        const StageOptions stage = finish_stage(compare_stage_, *bench_);
        suite.device = stage.device;
        suite.cache_folder = stage.cache_folder;
        suite.json = compare_.json;
        suite.csv = compare_.csv;
        suite.html = compare_.html;
        return suite;
    }

    CLI::App app_;
    CLI::App* bench_ = nullptr;
    CLI::App* verify_ = nullptr;
    CLI::App* render_ = nullptr;
    CLI::App* view_ = nullptr;
    CLI::App* info_ = nullptr;
    CLI::App* list_ = nullptr;
    CLI::App* generate_ = nullptr;
    CLI::App* convert_ = nullptr;
    CLI::App* replay_ = nullptr;
    RawStage compare_stage_;
    RawStage render_stage_;
    RawStage view_stage_;
    RawStage info_stage_;
    CompareOptions compare_;
    RenderOptions render_options_;
    SuiteOptions suite_;
    ViewOptions view_options_;
    InfoOptions info_options_;
    ListOptions list_options_;
    GenerateOptions generate_options_;
    ConvertOptions convert_options_;
    ReplayOptions replay_options_;
};

// The command the user named, if there is such a one; for "see 'occlude X --help'".
std::string named_command(int argc, const char* const* argv)
{
    for (const char* command : kCommands) {
        if (argc > 1 && std::string_view{argv[1]} == command) {
            return std::string{" "} + command;
        }
    }
    return {};
}

bool is_unknown_command(int argc, const char* const* argv)
{
    return argc > 1 && argv[1][0] != '-' && named_command(argc, argv).empty();
}

int fail(const Streams& streams, std::string_view message)
{
    streams.err << "occlude: " << message << '\n';
    return kFailed;
}

int parse_and_run(int argc, const char* const* argv, const Streams& streams)
{
    Program program;
    try {
        program.app().parse(argc, argv);
        const Result<int> code = program.run(streams);
        return code ? *code : fail(streams, code.error().message);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) { // --help, --version
            program.app().exit(error, streams.out, streams.err);
            return kDone;
        }
        return fail(streams, fmt::format("{}; see 'occlude{} --help'", error.what(),
                                         named_command(argc, argv)));
    }
}

} // namespace

static int run_command(int argc, const char* const* argv, const Streams& streams)
{
    if (argc <= 1 || is_unknown_command(argc, argv)) {
        const std::string problem =
            argc <= 1 ? "no command given" : fmt::format("there is no command '{}'", argv[1]);
        return fail(streams, fmt::format("{}; choose one of {}; see 'occlude --help'", problem,
                                         fmt::join(kCommands, ", ")));
    }
    try {
        return parse_and_run(argc, argv, streams);
    } catch (const std::bad_alloc&) {
        return fail(streams, "out of memory; choose a smaller scene, size or number of frames");
    } catch (const std::exception& error) {
        return fail(streams, fmt::format("unexpected failure: {}", error.what()));
    }
}

int run_program(int argc, const char* const* argv, const Streams& streams)
{
    const int code = run_command(argc, argv, streams);
    streams.out.flush();
    if (!streams.out) { // a script that reads the table must not take half of it for all
        return fail(streams, "cannot write to the standard output; is the disk full?");
    }
    return code;
}

} // namespace occlude::tools
