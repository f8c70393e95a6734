#include "viewer/ui/widgets.h"

#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace occlude::tools::viewer {

static float ui_scale = 1.0f;

ScreenNotes& screen_notes()
{
    static ScreenNotes notes;
    return notes;
}

float scaled(float pixels)
{
    return pixels * ui_scale;
}

void set_up_style(float scale)
{
    constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    constexpr float kFontSize = 14.0f;
    constexpr float kBuiltInFontSize = 13.0f;
    ui_scale = scale;
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = 0.0f;
    style.WindowBorderSize = 0.0f;
    style.FrameRounding = 3.0f;
    style.GrabRounding = 3.0f;
    style.ItemSpacing = {7.0f, 5.0f};
    style.Colors[ImGuiCol_WindowBg] = {0.10f, 0.11f, 0.13f, 1.0f};
    style.Colors[ImGuiCol_PopupBg] = {0.07f, 0.08f, 0.09f, 1.0f};
    style.Colors[ImGuiCol_Header] = {0.18f, 0.24f, 0.31f, 1.0f};
    style.Colors[ImGuiCol_TextDisabled] = {0.66f, 0.68f, 0.72f, 1.0f};
    style.ScaleAllSizes(scale);
    ImGuiIO& io = ImGui::GetIO();
    io.Fonts->Clear();
    std::error_code ignored;
    if (std::filesystem::exists(kFont, ignored)) {
        io.Fonts->AddFontFromFileTTF(kFont, std::floor(kFontSize * scale));
    } else {
        ImFontConfig config;
        config.SizePixels = std::floor(kBuiltInFontSize * scale);
        io.Fonts->AddFontDefault(&config);
    }
}

PanelScope::PanelScope(const char* title, ImVec2 place, ImVec2 size, bool titled)
{
    ImGui::SetNextWindowPos(place);
    ImGui::SetNextWindowSize(size);
    ImGuiWindowFlags flags = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                             ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                             ImGuiWindowFlags_NoBringToFrontOnFocus |
                             ImGuiWindowFlags_NoFocusOnAppearing;
    if (!titled) {
        flags |= ImGuiWindowFlags_NoTitleBar;
    }
    ImGui::Begin(title, nullptr, flags);
    if (screen_notes().reading) {
        ImGui::LogToBuffer(0);
    }
}

PanelScope::~PanelScope()
{
    if (screen_notes().reading) {
        screen_notes().text += GImGui->LogBuffer.c_str();
        screen_notes().text += '\n';
        ImGui::LogFinish();
    }
    ImGui::End();
}

void note_item(std::string_view label)
{
    if (!screen_notes().reading || !ImGui::IsItemVisible()) {
        return; // nobody can click what is scrolled out of its panel
    }
    const ImVec2 low = ImGui::GetItemRectMin();
    const ImVec2 high = ImGui::GetItemRectMax();
    // A checkbox and a combo end with their label: their own left part is what is clicked.
    const float reach = std::min(high.x - low.x, scaled(40.0f));
    screen_notes().places[std::string{label.substr(0, label.find("##"))}] = {
        low.x + 0.5f * reach, 0.5f * (low.y + high.y)};
}

bool button(const char* label)
{
    const bool pressed = ImGui::Button(label);
    note_item(label);
    return pressed;
}

bool checkbox(const char* label, bool* value)
{
    const bool changed = ImGui::Checkbox(label, value);
    note_item(label);
    return changed;
}

bool combo(const char* label, const std::string& choice, const char* const* names, size_t count,
           std::string& chosen, const std::string* descriptions)
{
    bool changed = false;
    const bool open = ImGui::BeginCombo(label, choice.c_str(), ImGuiComboFlags_HeightLargest);
    note_item(label);
    if (!open) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        if (ImGui::Selectable(names[i], choice == names[i]) && choice != names[i]) {
            chosen = names[i];
            changed = true;
        }
        note_item(names[i]);
        if (descriptions != nullptr) {
            hint(descriptions[i]);
        }
    }
    ImGui::EndCombo();
    return changed;
}

bool slider(const char* label, int* value, int least, int most)
{
    const bool changed = ImGui::SliderInt(label, value, least, most);
    note_item(label);
    return changed;
}

bool slider(const char* label, float* value, float least, float most, const char* format)
{
    const bool changed =
        ImGui::SliderFloat(label, value, least, most, format, ImGuiSliderFlags_Logarithmic);
    note_item(label);
    return changed;
}

bool header(const char* label, bool open)
{
    const bool shown = ImGui::CollapsingHeader(label, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
    note_item(label);
    return shown;
}

void text(const std::string& line)
{
    ImGui::TextUnformatted(line.c_str(), line.c_str() + line.size());
}

void wrapped(const std::string& line)
{
    ImGui::PushTextWrapPos(0.0f);
    text(line);
    ImGui::PopTextWrapPos();
}

void faint(const std::string& line)
{
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    wrapped(line);
    ImGui::PopStyleColor();
}

void hint(const std::string& line)
{
    if (ImGui::IsItemHovered()) {
        ImGui::BeginTooltip();
        ImGui::PushTextWrapPos(scaled(320.0f));
        text(line);
        ImGui::PopTextWrapPos();
        ImGui::EndTooltip();
    }
}

void swatch(const glm::vec4& color, const std::string& line)
{
    const float side = ImGui::GetTextLineHeight();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + side, at.y + side}, to_u32(color),
                                              scaled(2.0f));
    ImGui::Dummy({side, side});
    ImGui::SameLine();
    wrapped(line);
}

ImU32 to_u32(const glm::vec4& color)
{
    return ImGui::ColorConvertFloat4ToU32({color.r, color.g, color.b, color.a});
}

} // namespace occlude::tools::viewer
