// The program around the viewer: a window, its input, panels, and the order of a frame.
#pragma once

#include "viewer/ui/panels.h"
#include "viewer/ui/window.h"
#include "viewer/viewer.h"

#include <memory>
#include <set>

namespace occlude::tools::viewer {

class App {
public:
    /// How long parts of the last frames took, in seconds.
    struct Timing {
        double frames_s = 0.0; ///< all of them together
        double panels_s = 0.0; ///< ... of that, panels and what is written over the picture
        uint64_t frames = 0;
    };

    /// ImGui must have a context. `scale`: of panels; 0: the window's. `always_panels`: draws the
    /// panels in every frame, also where nothing happens to them.
    App(std::unique_ptr<Window> window, StageOptions options, Settings settings, float scale,
        bool always_panels);
    ~App();
    App(const App&) = delete;
    App& operator=(const App&) = delete;

    Viewer& viewer() { return *viewer_; }
    Window& window() { return *window_; }

    /// One frame: input, culling, panels, and showing it all. `seconds` since the last one.
    void frame(double seconds);

    /// What the window shows.
    Image screenshot() const { return screen_.read(); }
    const Timing& timing() const { return timing_; }
    /// The errors that OpenGL has reported so far; there should be none.
    uint64_t gl_errors() const { return gl_errors_; }

private:
    /// What the mouse is doing to the picture.
    enum class Drag : uint8_t { none, look, orbit, divider };

    void handle(const InputEvent& event);
    void handle_button(const InputEvent& event);
    void handle_move(glm::vec2 at);
    void handle_key(const InputEvent& event);
    FlyInput fly_input() const;
    bool near_divider(glm::vec2 at) const;
    glm::ivec2 picture_pixels() const;
    void draw_ui(double seconds);
    void write_screenshot();

    std::unique_ptr<Window> window_;
    std::unique_ptr<Viewer> viewer_;
    bool always_panels_ = false;
    Layout layout_;
    Canvas screen_;
    std::set<int> keys_down_;
    Drag drag_ = Drag::none;
    glm::vec2 mouse_{0.0f};
    float dragged_ = 0.0f; ///< pixels since the button went down
    Timing timing_;
    double panels_age_s_ = 0.0;
    bool input_came_ = true; ///< since the panels were drawn
    uint64_t gl_errors_ = 0;
};

} // namespace occlude::tools::viewer
