// Everything the user can change in the viewer, as plain data.
#pragma once

#include "viewer/explain.h"
#include "viewer/fly_camera.h"
#include "viewer/overlays.h"

#include <occlude/scene/camera_path.h>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace occlude::tools::viewer {

/// Which panels are open.
struct PanelState {
    bool help = false;
    bool controls = true;
    bool inspector = true;
    bool timeline = false;
    bool focus_search = false;   ///< the next frame puts the keyboard into the search field
    bool narrow = false;         ///< the window has no room for both controls and inspector
    bool inspector_wins = false; ///< ... and the inspector is the one that is shown

    /// Opens the inspector, in the place of the controls if need be.
    void show_inspector()
    {
        inspector = true;
        inspector_wins = true;
    }
};

struct CameraState {
    FlyCamera fly; ///< what the user steers: the observer while frozen
    bool frozen = false;
    Camera culling;     ///< what is culled for while frozen
    float speed = 1.0f; ///< in parts of what the scene suggests
    std::string path_name = "auto";
    std::vector<Camera> path;
    bool playing = false;
    size_t path_frame = 0;
    size_t bookmark = 0; ///< the next one to go to
    bool recording = false;
    std::vector<Camera> recorded;
};

struct PictureState {
    Fill fill = Fill::visible;
    OverlaySettings overlays;
    bool split = false;
    bool difference = false;
    float divider = 0.5f; ///< of the width
    bool flare = false;
};

struct TimeState {
    bool paused = false;
    int steps = 0; ///< frames still to be culled while paused
    bool moving = true;
    size_t motion_frame = 0;
};

/// The object that "why?" is about.
struct Selection {
    std::optional<uint32_t> instance;
    ItemId item;
    std::optional<Coverage> coverage; ///< what hides it, as far as it was asked
    std::array<char, 128> search{};   ///< what stands in the search field
};

struct ViewerState {
    PanelState panels;
    CameraState camera;
    PictureState picture;
    TimeState time;
    Selection selection;
    bool measure_references = true;
    uint64_t checked_frames = 0; ///< compared with drawing everything
    uint64_t wrong_frames = 0;   ///< ... that differed, though the algorithm is exact
    std::string message;         ///< shown over the picture for a while
    double message_age_s = 0.0;
    bool message_is_error = false;
};

/// What is steered in a frame, -1 to 1 each: from keys and gamepads together.
struct FlyInput {
    glm::vec3 move{0.0f}; ///< right, up, forward
    glm::vec2 turn{0.0f}; ///< right, up
    float pace = 1.0f;    ///< a factor of the speed
};

} // namespace occlude::tools::viewer
