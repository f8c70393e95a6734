#include "viewer/ui/panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace occlude::tools::viewer {

// A legend that would take too much of the picture is cut, and says so.
static std::vector<LegendLine> legend_that_fits(std::vector<LegendLine> lines, ImVec2 place)
{
    constexpr float kMostOfHeight = 0.4f;
    const LegendLine rest{{0.0f, 0.0f, 0.0f, 0.0f}, "... the rest needs a larger window"};
    bool cut = false;
    while (lines.size() > 1 && legend_height(lines, place.x) > kMostOfHeight * place.y) {
        lines.resize(lines.size() - (cut ? 2 : 1));
        lines.push_back(rest);
        cut = true;
    }
    return lines;
}

Layout make_layout(const PanelState& panels, ImVec2 window, std::vector<LegendLine> legend)
{
    constexpr float kControls = 300.0f;
    constexpr float kInspector = 340.0f;
    constexpr float kTimeline = 150.0f;
    constexpr float kNarrowestPicture = 320.0f;
    Layout layout;
    layout.window = window;
    layout.controls = panels.controls;
    layout.inspector = panels.inspector;
    const float both = scaled(kControls + kInspector + kNarrowestPicture);
    layout.narrow = window.x < both;
    if (layout.controls && layout.inspector && layout.narrow) {
        layout.controls = !panels.inspector_wins;
        layout.inspector = panels.inspector_wins;
    }
    layout.controls_width = layout.controls ? scaled(kControls) : 0.0f;
    layout.inspector_width = layout.inspector ? scaled(kInspector) : 0.0f;
    layout.timeline = panels.timeline;
    layout.timeline_height = panels.timeline ? std::min(scaled(kTimeline), 0.4f * window.y) : 0.0f;
    layout.picture_min = {layout.controls_width, 0.0f};
    layout.picture_max = {std::max(window.x - layout.inspector_width, layout.picture_min.x + 1.0f),
                          std::max(window.y - layout.timeline_height, 1.0f)};
    layout.legend = legend_that_fits(std::move(legend), layout.picture_size());
    layout.legend_height = legend_height(layout.legend, layout.picture_size().x);
    layout.picture_max.y = std::max(layout.picture_max.y - layout.legend_height, 1.0f);
    return layout;
}

void help_window(Viewer& viewer, const Layout& layout)
{
    const ImVec2 size{std::min(scaled(620.0f), layout.window.x - scaled(20.0f)),
                      std::min(scaled(700.0f), layout.window.y - scaled(20.0f))};
    const PanelScope scope{
        "Keys", {0.5f * (layout.window.x - size.x), 0.5f * (layout.window.y - size.y)}, size, true};
    ImGui::SetWindowFocus();
    faint("Drag the picture to look around, with the right button to orbit the selected object; "
          "click an object to select it; the wheel changes the speed; drop a file to open it. "
          "Gamepad: the left stick flies, the right one looks, triggers sink and rise.");
    ImGui::Columns(2, "keys", false);
    ImGui::SetColumnWidth(0, scaled(110.0f));
    const auto line = [](std::string_view key, std::string_view description) {
        text(std::string{key});
        ImGui::NextColumn();
        wrapped(std::string{description});
        ImGui::NextColumn();
    };
    line("W A S D", "fly forward, left, back, right");
    line("E Q", "rise, sink");
    line("arrows", "look around");
    line("Shift, Alt", "fly faster, slower");
    for (const KeyBinding& binding : key_bindings()) {
        line(binding.shown, binding.description);
    }
    ImGui::Columns(1);
    if (button("Close")) {
        viewer.state().panels.help = false;
    }
}

void loading_window(Viewer& viewer, const Layout& layout)
{
    const ImVec2 size{std::min(scaled(420.0f), layout.window.x), scaled(110.0f)};
    const PanelScope scope{"Loading",
                           {0.5f * (layout.window.x - size.x), 0.5f * (layout.window.y - size.y)},
                           size,
                           true};
    const Loader& loader = viewer.loader();
    wrapped(loader.scene());
    const double share = loader.share();
    const bool known = std::isfinite(share);
    text(known
             ? fmt::format("{}: {:.0f}%, {:.0f} s", loader.phase(), 100.0 * share, loader.seconds())
             : fmt::format("{}: {:.0f} s", loader.phase(), loader.seconds()));
    // Where nobody knows how much is left, a running mark shows that the program lives.
    const auto turn = static_cast<float>(loader.seconds() - std::floor(loader.seconds()));
    const float from = known ? 0.0f : 0.8f * turn;
    const float to = known ? static_cast<float>(share) : 0.8f * turn + 0.2f;
    const float width = ImGui::GetContentRegionAvail().x - scaled(80.0f);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + width, at.y + scaled(18.0f)},
                                              ImGui::GetColorU32(ImGuiCol_FrameBg));
    ImGui::GetWindowDrawList()->AddRectFilled({at.x + from * width, at.y},
                                              {at.x + to * width, at.y + scaled(18.0f)},
                                              ImGui::GetColorU32(ImGuiCol_PlotHistogram));
    ImGui::Dummy({width, scaled(18.0f)});
    ImGui::SameLine();
    if (button("Cancel")) {
        viewer.loader().cancel();
        viewer.say("Loading was cancelled. Drop a file on the window to open it.");
    }
}

void show_panels(Viewer& viewer, const Layout& layout)
{
    if (layout.controls) {
        controls_panel(viewer, layout);
    }
    if (layout.inspector) {
        inspector_panel(viewer, layout);
    }
    if (layout.timeline) {
        timeline_panel(viewer, layout);
    }
    if (viewer.loader().loading()) {
        loading_window(viewer, layout);
    }
    if (viewer.state().panels.help) {
        help_window(viewer, layout);
    }
}

} // namespace occlude::tools::viewer
