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
    /// How long parts of the frames with a scene took, in seconds.
    struct Timing {
        double frames_s = 0.0; ///< all of them together
        double panels_s = 0.0; ///< ... of that, panels and what is written over the picture
        uint64_t frames = 0;
        uint64_t panel_frames = 0; ///< ... in which the panels were made again
    };

    /// ImGui must have a context. `scale`: of panels; 0: the window's.
    App(std::unique_ptr<Window> window, StageOptions options, Settings settings, float scale);
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
    /// When the panels were made, and when they must be made again.
    struct PanelClock {
        double age_s = 0.0;
        double cost_s = 0.0;         ///< of making them the last time
        int frames_due = 0;          ///< frames in which they are made whatever happens
        glm::ivec2 screen{0};        ///< pixels that they were made for
        glm::vec2 picture_min{0.0f}; ///< the place of the picture between them
        glm::vec2 picture_max{0.0f};
    };

    /// What the mouse is doing to the picture.
    enum class Drag : uint8_t { none, look, orbit, divider };

    void handle(const InputEvent& event);
    bool concerns_panels(const InputEvent& event) const;
    void handle_button(const InputEvent& event);
    void handle_move(glm::vec2 at);
    void handle_key(const InputEvent& event);
    FlyInput fly_input() const;
    bool near_divider(glm::vec2 at) const;
    glm::ivec2 picture_pixels() const;
    bool panels_need_renewal(double seconds);
    void make_panels();
    void draw_panels(bool renewed);
    void clear_picture() const;
    void render(std::span<ImDrawList*> lists);
    void write_screenshot();

    std::unique_ptr<Window> window_;
    std::unique_ptr<Viewer> viewer_;
    Layout layout_;
    Canvas screen_;
    PanelClock panel_clock_;
    std::unique_ptr<ImDrawList> picture_list_;
    std::vector<ImDrawList*> lists_over_picture_; ///< parts of panels that reach over the picture
    std::set<int> keys_down_;
    Drag drag_ = Drag::none;
    glm::vec2 mouse_{0.0f};
    float dragged_ = 0.0f; ///< pixels since the button went down
    Timing timing_;
    uint64_t gl_errors_ = 0;
};

} // namespace occlude::tools::viewer
