#include "viewer/viewer.h"

#include "viewer/numbered_file.h"
#include "walk/paths.h"

#include <occlude/cull/registry.h>

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools::viewer {

Viewer::Viewer(std::shared_ptr<GlContext> context, StageOptions options, Settings settings)
    : context_(std::move(context))
    , options_(std::move(options))
    , settings_(std::move(settings))
{
    const SecondsClock clock = steady_seconds_clock();
    for (size_t i = 0; i < panes_.size(); ++i) {
        panes_[i] = std::make_unique<Pane>(settings_.algorithms[i], clock);
        panes_[i]->set_option_sets(settings_.options[i]);
    }
    for (size_t i = 0; i < kReferences.size(); ++i) {
        references_.panes[i] = std::make_unique<Pane>(kReferences[i], clock);
    }
    state_.panels.controls = settings_.controls;
    state_.panels.inspector = settings_.inspector;
    state_.panels.timeline = settings_.timeline;
    state_.camera.speed = settings_.speed;
    state_.camera.path_name = options_.path;
    state_.measure_references = settings_.measure_references;
    context_->make_current();
    if (auto compositor = Compositor::create()) {
        pictures_.compositor = std::move(*compositor);
    }
}

Viewer::~Viewer()
{
    context_->make_current(); // the pictures die in it
}

void Viewer::open(const std::string& scene)
{
    loader_.start(scene, options_);
}

void Viewer::say(const std::string& message, bool is_error)
{
    state_.message = message;
    state_.message_is_error = is_error;
    state_.message_age_s = 0.0;
}

void Viewer::forget_trees()
{
    for (const auto& pane : panes_) {
        pane->forget_tree();
    }
    for (const auto& reference : references_.panes) {
        reference->forget_tree();
    }
    references_.debt_s = 0.0;
    pending_.redraw = true;
}

void Viewer::take_over(std::unique_ptr<Session> session)
{
    std::ostringstream notes;
    if (const auto started = session->start(context_, notes); !started) {
        say(started.error().message, true);
        return;
    }
    forget_trees(); // they refer to the old session
    recorder_.reset();
    light_.visibility.reset();
    session_ = std::move(session);
    pictures_.size = glm::ivec2{0};
    note_instances();
    session_->renderer().warm_up();
    state_.time.motion_frame = 0;
    state_.selection = {};
    const std::optional<Camera> kept = std::exchange(pending_.keep_camera, std::nullopt);
    auto cameras = session_->cameras(state_.camera.path_name);
    if (!cameras) { // the path of another scene
        state_.camera.path_name = "auto";
        cameras = session_->cameras("auto");
    }
    if (!cameras) {
        say(cameras.error().message, true);
        return;
    }
    state_.camera.path = std::move(*cameras);
    if (kept) {
        state_.camera.fly = FlyCamera{*kept, session_->model().up};
        return;
    }
    state_.camera.playing = false;
    state_.camera.frozen = false;
    state_.camera.path_frame = 0;
    state_.camera.fly = FlyCamera{state_.camera.path.front(), session_->model().up};
    const std::string note = notes.str();
    say(note.empty() ? fmt::format("{}: {} objects. F1 lists the keys.", session_->model().name,
                                   session_->model().instances.size())
                     : note,
        !note.empty());
}

void Viewer::remake(SceneModel model)
{
    StageOptions options = session_->options();
    options.device = options_.device;
    options.test = options_.test;
    auto session = Session::prepare(std::move(model), options);
    if (!session) {
        say(session.error().message, true);
        return;
    }
    pending_.keep_camera = state_.camera.fly.camera();
    take_over(std::move(*session));
}

void Viewer::choose_algorithm(size_t pane, const std::string& algorithm)
{
    panes_[pane]->choose_algorithm(algorithm);
    pending_.redraw = true;
}

void Viewer::choose_hierarchy(const std::string& text)
{
    if (!session_) {
        return;
    }
    forget_trees();
    if (const auto chosen = session_->use_hierarchies(text, {}); !chosen) {
        say(chosen.error().message, true);
        return;
    }
    options_.hierarchy = text;
    note_instances();
}

void Viewer::choose_test(const std::string& method)
{
    if (!session_) {
        return;
    }
    if (const auto chosen = session_->use_test(method); !chosen) {
        say(chosen.error().message, true);
        return;
    }
    options_.test = method;
    forget_trees();
}

void Viewer::choose_device(const std::string& device)
{
    if (!session_ || device == session_->device_name()) {
        return;
    }
    // Only gl has a flag buffer, and cpu_fast has one method.
    const bool change =
        options_.test == "raster" || device == "cpu_fast" || session_->device_name() == "cpu_fast";
    if (change) {
        options_.test = device == "cpu_fast" ? "pyramid" : "queries";
    }
    options_.device = device;
    remake(session_->model());
}

void Viewer::choose_path(const std::string& name)
{
    if (!session_) {
        return;
    }
    auto cameras = session_->cameras(name);
    if (!cameras) {
        say(cameras.error().message, true);
        return;
    }
    state_.camera.path = std::move(*cameras);
    state_.camera.path_name = name;
    state_.camera.path_frame = 0;
    execute(Command::home);
}

void Viewer::go_to_bookmark(size_t index)
{
    const auto& bookmarks = settings_.bookmarks[session_->model().name];
    if (index < bookmarks.size()) {
        state_.camera.playing = false;
        state_.camera.fly = FlyCamera{bookmarks[index], session_->model().up};
        state_.camera.bookmark = index + 1;
        say(fmt::format("bookmark {} of {}", index + 1, bookmarks.size()));
    }
}

Camera Viewer::with_depth_range(Camera camera) const
{
    choose_depth_range({&camera, 1}, session_->model());
    return camera;
}

View Viewer::shown_view() const
{
    return make_view(with_depth_range(state_.camera.fly.camera()), pictures_.size);
}

View Viewer::culling_view() const
{
    return state_.camera.frozen ? make_view(with_depth_range(state_.camera.culling), pictures_.size)
                                : shown_view();
}

void Viewer::fly(double seconds, const FlyInput& input)
{
    constexpr float kTurnPerSecond = 1.5f; // radians
    CameraState& camera = state_.camera;
    const bool steered = input.move != glm::vec3{0.0f} || input.turn != glm::vec2{0.0f};
    if (!steered || (state_.time.paused && !camera.frozen)) {
        return;
    }
    if (!camera.frozen) {
        camera.playing = false; // who steers takes over
    }
    const auto step = static_cast<float>(seconds);
    camera.fly.look(kTurnPerSecond * step * input.turn.x, kTurnPerSecond * step * input.turn.y);
    camera.fly.fly(suggested_speed() * camera.speed * input.pace * step * input.move);
    pending_.redraw = true;
}

void Viewer::look(glm::vec2 right_up, bool orbit)
{
    if (!session_ || (state_.time.paused && !state_.camera.frozen)) {
        return;
    }
    if (!state_.camera.frozen) {
        state_.camera.playing = false;
    }
    if (orbit && state_.selection.instance) {
        const Aabb& box = session_->scene().scene.item_bounds()[state_.selection.item.value].box;
        if (box.is_bounded() && !box.is_empty()) {
            state_.camera.fly.orbit(box.center(), right_up.x, right_up.y);
            pending_.redraw = true;
            return;
        }
    }
    state_.camera.fly.look(right_up.x, right_up.y);
    pending_.redraw = true;
}

void Viewer::advance(double seconds, const FlyInput& input)
{
    state_.message_age_s += seconds;
    references_.debt_s -= seconds;
    if (auto loaded = loader_.poll()) {
        if (*loaded) {
            take_over(std::move(**loaded));
        } else {
            say(loaded->error().message, true);
        }
    }
    if (!session_) {
        return;
    }
    fly(seconds, input);
    CameraState& camera = state_.camera;
    const bool goes_on = !state_.time.paused || state_.time.steps > 0;
    if (camera.playing && goes_on && !camera.path.empty()) {
        camera.path_frame = (camera.path_frame + 1) % camera.path.size();
        const Camera& at = camera.path[camera.path_frame];
        if (camera.frozen) {
            camera.culling = at;
        } else {
            camera.fly = FlyCamera{at, session_->model().up};
        }
    }
    if (camera.recording && goes_on) {
        camera.recorded.push_back(
            with_depth_range(camera.frozen ? camera.culling : camera.fly.camera()));
    }
}

void Viewer::toggle_freeze()
{
    CameraState& camera = state_.camera;
    camera.frozen = !camera.frozen;
    if (camera.frozen) {
        camera.culling = camera.fly.camera();
        say("The culling camera is frozen: fly around and look at what it culls.");
        if (state_.picture.fill == Fill::visible) {
            state_.picture.fill = Fill::states;
        }
    } else {
        camera.fly = FlyCamera{camera.culling, session_->model().up};
        if (state_.picture.fill == Fill::states) {
            state_.picture.fill = Fill::visible;
        }
        say("The culling camera moves again.");
    }
}

void Viewer::toggle_path_recording()
{
    CameraState& camera = state_.camera;
    camera.recording = !camera.recording;
    if (camera.recording) {
        camera.recorded.clear();
        say("Recording the camera's path: R again saves it.");
        return;
    }
    if (camera.recorded.empty()) {
        say("The path has no frame: nothing was saved.");
        return;
    }
    const auto file = numbered_file("occlude-path", "json");
    const auto written = write_path_file(file, camera.recorded);
    say(written ? fmt::format("{} frames are in {}: occlude bench {} --path {}",
                              camera.recorded.size(), file.string(), loader_.scene(), file.string())
                : written.error().message,
        !written);
}

void Viewer::toggle_trace_recording()
{
    if (!recorder_) {
        panes_[0]->forget_tree(); // a replay begins with an algorithm that has seen nothing
        recorder_ = std::make_unique<RecordingDevice>(session_->renderer().device());
        say("Recording every word between the algorithm and the device: Ctrl+R again saves it.");
        return;
    }
    const auto file = numbered_file("occlude-trace", "rec");
    const auto written = save_trace(recorder_->recording(), file);
    recorder_.reset();
    say(written ? fmt::format("The trace is in {}.", file.string()) : written.error().message,
        !written);
}

void Viewer::toggle_playing()
{
    CameraState& camera = state_.camera;
    camera.playing = !camera.playing;
    say(camera.playing ? fmt::format("Playing path '{}'.", camera.path_name) : "The path stops.");
}

// A sun ahead of the camera and above the horizon.
void Viewer::toggle_flare()
{
    constexpr float kHeight = 0.35f; // tangent of the angle above the line of sight
    constexpr float kRadiusPx = 12.0f;
    PictureState& picture = state_.picture;
    picture.flare = !picture.flare;
    light_.visibility.reset();
    if (picture.flare) {
        const glm::vec3 toward =
            glm::normalize(state_.camera.fly.forward() + kHeight * session_->model().up);
        light_.light = {.position_world = glm::vec4{toward, 0.0f}, .radius_px = kRadiusPx};
        light_.visibility.set_lights({&light_.light, 1});
    }
}

void Viewer::cycle_algorithm(int by)
{
    const auto all = algorithms();
    const auto found = std::find_if(all.begin(), all.end(), [&](const AlgorithmInfo& info) {
        return info.name == panes_[0]->algorithm();
    });
    const auto count = static_cast<int>(all.size());
    const int index = (static_cast<int>(found - all.begin()) + by + count) % count;
    choose_algorithm(0, all[static_cast<size_t>(index)].name);
    say(fmt::format("{}: {}", all[static_cast<size_t>(index)].name,
                    all[static_cast<size_t>(index)].summary));
}

void Viewer::cycle_fill(int by)
{
    const auto count = static_cast<int>(kFillNames.size());
    const int index = (static_cast<int>(state_.picture.fill) + by + count) % count;
    state_.picture.fill = static_cast<Fill>(index);
    say(fmt::format("Shown: {}.", kFillNames[static_cast<size_t>(index)]));
}

Settings Viewer::remembered() const
{
    Settings settings = settings_;
    settings.controls = state_.panels.controls;
    settings.inspector = state_.panels.inspector;
    settings.timeline = state_.panels.timeline;
    settings.speed = state_.camera.speed;
    settings.measure_references = state_.measure_references;
    for (size_t i = 0; i < panes_.size(); ++i) {
        settings.algorithms[i] = panes_[i]->algorithm();
        settings.options[i] = panes_[i]->option_sets();
    }
    return settings;
}

} // namespace occlude::tools::viewer
