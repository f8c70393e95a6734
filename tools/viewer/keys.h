// What the keys of the viewer do: one table, which the key handler obeys and F1 lists.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace occlude::tools::viewer {

enum class Command : uint8_t {
    toggle_help,
    toggle_controls,
    toggle_inspector,
    toggle_timeline,
    toggle_freeze,
    toggle_pause,
    step,
    toggle_play,
    toggle_split,
    toggle_difference,
    next_fill,
    previous_fill,
    next_algorithm,
    previous_algorithm,
    cut,
    toggle_motion,
    check_exactness,
    overview,
    home,
    save_bookmark,
    next_bookmark,
    toggle_path_recording,
    toggle_trace_recording,
    screenshot,
    delete_object,
    duplicate_object,
    find_occluders,
    search,
    toggle_flare,
    close,
    quit,
};

/// A key by its code in GLFW: the upper-case ASCII character where there is one.
struct KeyCode {
    int code = 0;
    std::string_view name;
};

/// The code of a key by its name ("F1", "space", "a"), ignoring case.
std::optional<int> key_code(std::string_view name);

struct KeyBinding {
    int code = 0;
    bool control = false;   ///< with the control key held
    std::string_view shown; ///< how F1 calls it
    Command command = Command::toggle_help;
    std::string_view description;
};

/// Every command that has a key, in the order in which F1 lists them.
std::span<const KeyBinding> key_bindings();

/// The command of a key that goes down, if it has one.
std::optional<Command> command_of(int code, bool control);

/// The keys that act while they are held.
struct FlyKeys {
    int forward, back, left, right, up, down, fast, slow;
    int look_left, look_right, look_up, look_down;
};
const FlyKeys& fly_keys();

} // namespace occlude::tools::viewer
