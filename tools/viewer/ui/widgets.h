// What the panels are made of: ImGui's widgets, whose labels and places are noted, so that scripts
// can click them and read what they say.
#pragma once

#include <imgui.h>

#include <glm/vec4.hpp>

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace occlude::tools::viewer {

/// What the last frame showed, for scripts.
struct ScreenNotes {
    std::string text;                     ///< of all panels and of the picture's texts
    std::map<std::string, ImVec2> places; ///< the middle of each widget, by its label
    bool reading = false;                 ///< whether somebody reads it: it costs time

    void clear()
    {
        text.clear();
        places.clear();
    }
};
ScreenNotes& screen_notes();

/// Fonts and sizes for a scale of the screen (1: 96 dots per inch). Before the first frame.
void set_up_style(float scale);
/// `pixels` at scale 1, in pixels of the window.
float scaled(float pixels);

/// A window of the program at a fixed place; everything between is in it.
class PanelScope {
public:
    PanelScope(const char* title, ImVec2 place, ImVec2 size, bool titled);
    ~PanelScope();
    PanelScope(const PanelScope&) = delete;
    PanelScope& operator=(const PanelScope&) = delete;
};

void note_item(std::string_view label);
bool button(const char* label);
bool checkbox(const char* label, bool* value);
/// Changes `choice` to what the user chose of the names; true if so.
bool combo(const char* label, const std::string& choice, const char* const* names, size_t count,
           std::string& chosen, const std::string* descriptions = nullptr);
bool slider(const char* label, int* value, int least, int most);
bool slider(const char* label, float* value, float least, float most, const char* format);
bool header(const char* label, bool open);
void text(const std::string& line);
void wrapped(const std::string& line);
void faint(const std::string& line);
/// A tooltip for the last widget, wrapped.
void hint(const std::string& line);
/// A small square of a colour, then a text.
void swatch(const glm::vec4& color, const std::string& line);

ImU32 to_u32(const glm::vec4& color);

} // namespace occlude::tools::viewer
