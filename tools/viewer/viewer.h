// The viewer without its window: a scene, a camera, one or two algorithms, and their pictures.
#pragma once

#include "session/session.h"
#include "viewer/canvas.h"
#include "viewer/keys.h"
#include "viewer/loader.h"
#include "viewer/pane.h"
#include "viewer/settings.h"
#include "viewer/state.h"

#include <occlude/device/recording_device.h>
#include <occlude/effects/flare_visibility.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace occlude::tools::viewer {

/// What commands ask of the window around the viewer.
struct Requests {
    bool screenshot = false;
    bool quit = false;
};

class Viewer {
public:
    /// Everything with OpenGL happens in `context`, by the thread that calls. `options` are those
    /// of every scene that is opened.
    Viewer(std::shared_ptr<GlContext> context, StageOptions options, Settings settings);
    ~Viewer();

    ViewerState& state() { return state_; }
    const ViewerState& state() const { return state_; }
    Settings& settings() { return settings_; }
    Requests& requests() { return requests_; }
    Loader& loader() { return loader_; }

    /// Starts to load a scene; the old one stays until it is there.
    void open(const std::string& scene);
    /// Null until a scene was loaded.
    Session* session() { return session_.get(); }
    Pane& pane(size_t index) { return *panes_[index]; }
    size_t pane_count() const { return state_.picture.split || state_.picture.difference ? 2 : 1; }
    /// frustum, opt and ideal, as far as they were measured.
    const Pane& reference(size_t index) const { return *references_.panes[index]; }
    static constexpr std::array<const char*, 3> kReferences = {"frustum", "opt", "ideal"};

    void execute(Command command);
    void say(const std::string& message, bool is_error = false);

    void choose_algorithm(size_t pane, const std::string& algorithm);
    void choose_hierarchy(const std::string& text);
    void choose_test(const std::string& method);
    void choose_device(const std::string& device);
    void choose_path(const std::string& name);
    void go_to_bookmark(size_t index);

    /// Steers the camera, plays paths, takes over loaded scenes. `seconds` since the last call.
    void advance(double seconds, const FlyInput& input);
    /// Turns the camera after the mouse was dragged, in radians; around the selected object if
    /// `orbit`.
    void look(glm::vec2 right_up, bool orbit);
    /// Culls what must be culled and makes the pictures, `size` pixels large.
    void draw(glm::ivec2 size);
    /// The finished pictures: of each pane, and where they differ.
    const Canvas& canvas(size_t pane) const { return pictures_.finished[pane]; }
    const Canvas& difference() const { return pictures_.difference; }
    /// What the culling camera sees, while it is frozen and something lies on its screen; else
    /// empty.
    const Canvas& eye() const { return pictures_.eye; }
    const std::vector<ScreenMark>& marks() const { return pictures_.marks; }

    /// The legend of what is shown; empty before a scene is there.
    std::vector<LegendLine> legend_lines() const;

    /// The view that is shown, and the one that is culled.
    View shown_view() const;
    View culling_view() const;
    /// Selects what is seen at a pixel of the shown picture, row 0 at the bottom; nothing in the
    /// sky.
    void pick(glm::ivec2 pixel);
    void select(std::optional<uint32_t> instance);
    /// The first instance after the selected one whose name contains `text`, ignoring case.
    std::optional<uint32_t> find_by_name(const std::string& text) const;
    std::string instance_name(uint32_t instance) const;
    void move_selected(const glm::vec3& by);
    bool is_deleted(uint32_t instance) const;

    /// Where the light of the flare is on the shown picture, and how bright; nothing without one.
    struct Flare {
        glm::vec2 at{0.0f}; ///< 0 to 1 from the lower left
        float brightness = 0.0f;
    };
    std::optional<Flare> flare() const;

    /// Frames culled since the program started.
    uint64_t frame() const { return frame_; }
    /// The instance of each item.
    std::span<const uint32_t> instance_of() const { return instance_of_; }
    /// What is remembered for the next start, the state of now included.
    Settings remembered() const;

private:
    // viewer.cpp
    void take_over(std::unique_ptr<Session> session);
    void remake(SceneModel model);
    void forget_trees();
    void fly(double seconds, const FlyInput& input);
    void toggle_freeze();
    void toggle_path_recording();
    void toggle_trace_recording();
    void toggle_playing();
    void toggle_flare();
    void cycle_algorithm(int by);
    void cycle_fill(int by);
    void execute_on_scene(Command command);
    void execute_on_camera(Command command);
    Camera shown_camera() const;
    Camera with_depth_range(Camera camera) const;

    // viewer_draw.cpp
    void cull_panes(bool cull);
    void cull_pane(size_t index, const Stage& stage, const View& view);
    void measure_references(const Stage& stage, const View& view);
    void check_exactness(const Stage& stage, const View& view);
    void present(size_t index);
    void take_eye();
    void fill(const Pane& pane, const View& view);
    void draw_overlays(size_t index, const View& view);
    std::vector<ItemId> hidden_items(const Pane& pane) const;

    // viewer_scene.cpp
    void find_occluders();
    void delete_selected();
    void duplicate_selected();
    void note_instances();
    float suggested_speed() const;

    /// The yardsticks, measured now and then.
    struct References {
        std::array<std::unique_ptr<Pane>, 3> panes;
        size_t next = 0;
        double debt_s = 0.0; ///< frames must take so long before the next measurement
    };
    struct Pictures {
        std::optional<Compositor> compositor;
        std::array<Canvas, 2> finished;
        Canvas scratch;
        Canvas tinted;
        Canvas difference;
        Canvas eye;
        std::vector<ScreenMark> marks;
        std::vector<float> depth; ///< of the culled frame, for the pyramid
        glm::ivec2 size{0};
    };
    struct Light {
        FlareVisibility visibility;
        FlareLight light;
    };
    /// What the next draw() must do besides.
    struct Pending {
        bool check = false;
        bool redraw = true;                ///< something changed while paused
        std::optional<Camera> keep_camera; ///< a scene is made again: the camera stays
    };

    std::shared_ptr<GlContext> context_;
    StageOptions options_;
    Settings settings_;
    ViewerState state_;
    Requests requests_;
    Loader loader_;
    std::unique_ptr<Session> session_;
    std::array<std::unique_ptr<Pane>, 2> panes_;
    References references_;
    Pictures pictures_;
    Light light_;
    std::unique_ptr<RecordingDevice> recorder_;
    std::vector<uint32_t> instance_of_;
    uint64_t frame_ = 0;
    Pending pending_;
};

} // namespace occlude::tools::viewer
