#include "viewer/keys.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

namespace occlude::tools::viewer {

namespace {

// GLFW's codes of the keys that are no characters; tools/viewer/ui/glfw_window.cpp asserts them.
constexpr int kEscape = 256;
constexpr int kEnter = 257;
constexpr int kTab = 258;
constexpr int kBackspace = 259;
constexpr int kDelete = 261;
constexpr int kRight = 262;
constexpr int kLeft = 263;
constexpr int kDown = 264;
constexpr int kUp = 265;
constexpr int kPageUp = 266;
constexpr int kPageDown = 267;
constexpr int kHome = 268;
constexpr int kEnd = 269;
constexpr int kF1 = 290;
constexpr int kLeftShift = 340;
constexpr int kLeftControl = 341;
constexpr int kLeftAlt = 342;

constexpr std::array<KeyCode, 18> kNamedKeys = {{{' ', "space"},
                                                 {kEscape, "escape"},
                                                 {kEnter, "enter"},
                                                 {kTab, "tab"},
                                                 {kBackspace, "backspace"},
                                                 {kDelete, "delete"},
                                                 {kRight, "right"},
                                                 {kLeft, "left"},
                                                 {kDown, "down"},
                                                 {kUp, "up"},
                                                 {kPageUp, "page up"},
                                                 {kPageDown, "page down"},
                                                 {kHome, "home"},
                                                 {kEnd, "end"},
                                                 {kLeftShift, "shift"},
                                                 {kLeftControl, "control"},
                                                 {kLeftAlt, "alt"},
                                                 {'.', "period"}}};

constexpr std::array kBindings = {
    KeyBinding{kF1, false, "F1", Command::toggle_help, "list the keys"},
    KeyBinding{kF1 + 1, false, "F2", Command::toggle_controls, "show or hide the controls"},
    KeyBinding{kF1 + 2, false, "F3", Command::toggle_inspector, "show or hide the figures"},
    KeyBinding{kF1 + 3, false, "F4", Command::toggle_timeline,
               "show or hide the time line of the frame"},
    KeyBinding{'F', false, "F", Command::toggle_freeze,
               "freeze the culling camera and walk around as an observer"},
    KeyBinding{' ', false, "space", Command::toggle_pause, "pause: the frame stays as it is"},
    KeyBinding{'.', false, ".", Command::step, "step: cull one frame, then pause"},
    KeyBinding{'P', false, "P", Command::toggle_play, "play the camera path, or stop"},
    KeyBinding{'T', false, "T", Command::toggle_split, "split the screen between two algorithms"},
    KeyBinding{'X', false, "X", Command::toggle_difference,
               "show where the two algorithms' images differ"},
    KeyBinding{'V', false, "V", Command::next_fill, "next way to fill the picture"},
    KeyBinding{'V', true, "Ctrl+V", Command::previous_fill, "previous way to fill the picture"},
    KeyBinding{kPageDown, false, "Page down", Command::next_algorithm, "next algorithm"},
    KeyBinding{kPageUp, false, "Page up", Command::previous_algorithm, "previous algorithm"},
    KeyBinding{'C', false, "C", Command::cut,
               "cut: the algorithms forget everything, as at a change of scene"},
    KeyBinding{'M', false, "M", Command::toggle_motion, "let objects move, or stop them"},
    KeyBinding{'K', false, "K", Command::check_exactness,
               "check: compare this frame with drawing everything"},
    KeyBinding{'O', false, "O", Command::overview, "look at the whole scene from above"},
    KeyBinding{kHome, false, "Home", Command::home, "back to the beginning of the path"},
    KeyBinding{'B', true, "Ctrl+B", Command::save_bookmark, "remember this camera as a bookmark"},
    KeyBinding{'B', false, "B", Command::next_bookmark, "go to the next bookmark"},
    KeyBinding{'R', false, "R", Command::toggle_path_recording,
               "record the camera's path, or save it"},
    KeyBinding{'R', true, "Ctrl+R", Command::toggle_trace_recording,
               "record what the algorithm says to the device, or save it"},
    KeyBinding{kF1 + 11, false, "F12", Command::screenshot, "save a screenshot"},
    KeyBinding{'H', false, "H", Command::find_occluders, "what hides the selected object?"},
    KeyBinding{'F', true, "Ctrl+F", Command::search, "search an object by its name"},
    KeyBinding{kDelete, false, "Delete", Command::delete_object, "delete the selected object"},
    KeyBinding{'D', true, "Ctrl+D", Command::duplicate_object, "copy the selected object"},
    KeyBinding{'L', false, "L", Command::toggle_flare, "a light with a lens flare"},
    KeyBinding{kEscape, false, "Esc", Command::close, "close the help, or deselect, or unfreeze"},
    KeyBinding{'Q', true, "Ctrl+Q", Command::quit, "quit"},
};

bool same_name(std::string_view a, std::string_view b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
        return std::tolower(static_cast<unsigned char>(x)) ==
               std::tolower(static_cast<unsigned char>(y));
    });
}

} // namespace

std::optional<int> key_code(std::string_view name)
{
    for (const KeyCode& key : kNamedKeys) {
        if (same_name(name, key.name)) {
            return key.code;
        }
    }
    if (name.size() == 1 && std::isgraph(static_cast<unsigned char>(name[0])) != 0) {
        return std::toupper(static_cast<unsigned char>(name[0]));
    }
    constexpr int kFunctionKeys = 12;
    for (int number = 1; number <= kFunctionKeys; ++number) {
        std::string key{"F"};
        key += std::to_string(number);
        if (same_name(name, key)) {
            return kF1 + number - 1;
        }
    }
    return std::nullopt;
}

std::span<const KeyBinding> key_bindings()
{
    return kBindings;
}

std::optional<Command> command_of(int code, bool control)
{
    for (const KeyBinding& binding : kBindings) {
        if (binding.code == code && binding.control == control) {
            return binding.command;
        }
    }
    return std::nullopt;
}

const FlyKeys& fly_keys()
{
    static constexpr FlyKeys kKeys{'W',        'S',      'A',   'D',    'E', 'Q',
                                   kLeftShift, kLeftAlt, kLeft, kRight, kUp, kDown};
    return kKeys;
}

} // namespace occlude::tools::viewer
