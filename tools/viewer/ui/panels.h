// The panels around the viewer's picture, and what is drawn over it.
#pragma once

#include "viewer/ui/widgets.h"
#include "viewer/viewer.h"

namespace occlude::tools::viewer {

/// Where things are in the window, in its pixels from the upper left.
struct Layout {
    ImVec2 window{0, 0};
    ImVec2 picture_min{0, 0};
    ImVec2 picture_max{0, 0};
    bool controls = false;
    bool inspector = false;
    bool timeline = false;
    bool narrow = false; ///< no room for both controls and inspector
    float controls_width = 0.0f;
    float inspector_width = 0.0f;
    float timeline_height = 0.0f;
    float legend_height = 0.0f; ///< of the strip below the picture
    std::vector<LegendLine> legend = {};

    ImVec2 picture_size() const
    {
        return {picture_max.x - picture_min.x, picture_max.y - picture_min.y};
    }
    bool in_picture(ImVec2 at) const
    {
        return at.x >= picture_min.x && at.y >= picture_min.y && at.x < picture_max.x &&
               at.y < picture_max.y;
    }
};

/// Where everything goes: a window that is too narrow for both side panels has the one that was
/// asked for last. The legend goes below the picture.
Layout make_layout(const PanelState& panels, ImVec2 window, std::vector<LegendLine> legend = {});

/// How high a strip of this width must be to hold a legend.
float legend_height(std::span<const LegendLine> lines, float width);

/// All panels, in one ImGui frame.
void show_panels(Viewer& viewer, const Layout& layout);

void controls_panel(Viewer& viewer, const Layout& layout);
void inspector_panel(Viewer& viewer, const Layout& layout);
void timeline_panel(Viewer& viewer, const Layout& layout);
void help_window(Viewer& viewer, const Layout& layout);
void loading_window(Viewer& viewer, const Layout& layout);
/// Copies the finished pictures to their places on the screen.
void copy_pictures(const Viewer& viewer, const Layout& layout, const Canvas& screen);
/// What is written over the picture, and its legend: divider, marks, captions, messages.
void picture_layer(Viewer& viewer, const Layout& layout, ImDrawList& list);

/// Parts of the inspector.
void figures_tab(Viewer& viewer);
void report_tab(Viewer& viewer);
void why_tab(Viewer& viewer);

} // namespace occlude::tools::viewer
