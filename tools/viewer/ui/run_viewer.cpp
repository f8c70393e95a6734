#include "viewer/ui/run_viewer.h"

#include "render/image.h"
#include "viewer/ui/app.h"
#include "viewer/ui/script_runner.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <ostream>
#include <thread>

namespace occlude::tools::viewer {

namespace {

// ImGui's context, before and after everything that uses it.
struct UiContext {
    UiContext() { ImGui::CreateContext(); }
    ~UiContext() { ImGui::DestroyContext(); }
    UiContext(const UiContext&) = delete;
    UiContext& operator=(const UiContext&) = delete;
};

// Frames of a run without a window come at even times, so that runs repeat.
constexpr double kHeadlessFrame = 1.0 / 60.0;
constexpr double kLongestStep = 0.1; // seconds: a slow frame is no leap

Settings chosen_settings(const ViewOptions& options)
{
    Settings settings = options.headless ? Settings{} : load_settings(settings_file());
    if (options.size) {
        settings.window_size = *options.size;
    }
    if (!options.algorithm.empty()) {
        settings.algorithms[0] = options.algorithm;
    }
    if (options.scale) {
        settings.scale = *options.scale;
    }
    return settings;
}

void report_timing(const App& app, std::ostream& out)
{
    constexpr double kMsPerSecond = 1000.0;
    const App::Timing& timing = app.timing();
    if (timing.frames == 0) {
        return;
    }
    const auto count = static_cast<double>(timing.frames);
    out << fmt::format(
        "{} frames, {:.2f} ms each; panels {:.2f} ms, {:.1f}%, made {} times\n", timing.frames,
        kMsPerSecond * timing.frames_s / count, kMsPerSecond * timing.panels_s / count,
        100.0 * timing.panels_s / std::max(timing.frames_s, 1e-9), timing.panel_frames);
}

// Frames until the script, the number of frames or the user ends them.
Result<bool> run_frames(App& app, const ViewOptions& options, ScriptRunner* script)
{
    const SecondsClock clock = steady_seconds_clock();
    double last = clock();
    size_t frames = 0;
    while (!app.window().closed() && !app.viewer().requests().quit) {
        const bool loading = app.viewer().loader().loading();
        if (options.headless && loading) {
            std::this_thread::sleep_for(std::chrono::milliseconds{2});
        }
        if (script != nullptr) {
            if (const auto stepped =
                    script->step(app.window(), {.loading = loading}, screen_notes());
                !stepped) {
                return stepped.error();
            }
        }
        const double now = clock();
        app.frame(options.headless ? kHeadlessFrame : std::min(now - last, kLongestStep));
        last = now;
        if (script != nullptr) {
            if (const std::string file = script->take_screenshot(); !file.empty()) {
                if (const auto written = write_png(file, app.screenshot()); !written) {
                    return written.error();
                }
            }
            if (script->done()) {
                break;
            }
        }
        frames += loading ? 0 : 1;
        if (options.frames && frames >= *options.frames) {
            break;
        }
    }
    return true;
}

} // namespace

Result<bool> run_viewer(const ViewOptions& options, std::ostream& out)
{
    std::optional<ScriptRunner> script;
    if (!options.script.empty()) {
        auto steps = read_script(options.script);
        if (!steps) {
            return steps.error();
        }
        script.emplace(std::move(*steps), options.script);
    }
    const UiContext ui;
    const Settings settings = chosen_settings(options);
    auto window = options.headless
                      ? open_headless_window(settings.window_size)
                      : open_desktop_window(settings.window_size, "occlude view " + options.scene);
    if (!window) {
        return window.error();
    }
    screen_notes().reading = script.has_value();
    StageOptions stage = options.stage;
    App app{std::move(*window), stage, settings, settings.scale};
    if (!options.scene.empty()) {
        app.viewer().open(options.scene);
    }
    const auto ran = run_frames(app, options, script ? &*script : nullptr);
    if (!ran) {
        return ran.error();
    }
    if (!options.screenshot.empty()) {
        if (const auto written = write_png(options.screenshot, app.screenshot()); !written) {
            return written.error();
        }
    }
    if (app.gl_errors() > 0) {
        return Error{ErrorCode::device_failed,
                     fmt::format("OpenGL reported {} errors", app.gl_errors())};
    }
    if (options.headless) {
        report_timing(app, out);
        return true;
    }
    Settings remembered = app.viewer().remembered();
    remembered.window_size = app.window().size();
    remembered.scale = settings.scale;
    return save_settings(settings_file(), remembered);
}

} // namespace occlude::tools::viewer
