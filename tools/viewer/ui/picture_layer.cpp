// The picture in the middle of the window, what is written over it, and the legend below it.
#include "viewer/ui/panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace occlude::tools::viewer {

namespace {

// Text with a shadow, so that it is read on any picture; noted for scripts.
void label(ImDrawList& list, ImVec2 at, const std::string& line)
{
    list.AddText({at.x + 1.0f, at.y + 1.0f}, IM_COL32(0, 0, 0, 220), line.c_str());
    list.AddText(at, IM_COL32(255, 255, 255, 255), line.c_str());
    if (screen_notes().reading) {
        screen_notes().text += line + "\n";
    }
}

// A part of the picture's place: from and to, 0 to 1 from the upper left.
struct Place {
    ImVec2 min;
    ImVec2 max;
};

PixelRect framebuffer_rect(const Place& place, float ratio, glm::ivec2 screen)
{
    const auto pixel = [&](float at) { return static_cast<int>(std::lround(at * ratio)); };
    const int left = pixel(place.min.x);
    const int top = pixel(place.min.y);
    return {left, screen.y - pixel(place.max.y), pixel(place.max.x) - left,
            pixel(place.max.y) - top};
}

// Copies the columns from `from` to `to` (0 to 1) of a picture to where they belong.
void copy_columns(const Canvas& canvas, const Canvas& screen, const Layout& layout, float ratio,
                  float from, float to)
{
    const glm::ivec2 size = canvas.size();
    PixelRect target =
        framebuffer_rect({layout.picture_min, layout.picture_max}, ratio, screen.size());
    const auto column = [&](float share) {
        return static_cast<int>(std::lround(share * static_cast<float>(size.x)));
    };
    const PixelRect source{column(from), 0, column(to) - column(from), size.y};
    // The picture has as many pixels as its place, but for one that may be lost by rounding.
    target.width = target.width == size.x || from > 0.0f || to < 1.0f ? source.width : target.width;
    target.x += source.x;
    canvas.copy_part(source, screen, target);
}

// Where the picture of the culling camera stands while the observer's fills the place.
Place inset_place(const Layout& layout)
{
    constexpr float kShare = 0.36f;
    const ImVec2 size = layout.picture_size();
    const float right = layout.picture_max.x - scaled(8.0f);
    const float top = layout.picture_min.y + scaled(8.0f) + 3.0f * ImGui::GetFontSize();
    return {{right - kShare * size.x, top}, {right, top + kShare * size.y}};
}

bool has_inset(const Viewer& viewer)
{
    return !viewer.eye().empty();
}

void marks(ImDrawList& list, const Viewer& viewer, const Place& place)
{
    const glm::ivec2 size = viewer.canvas(0).size();
    if (size.x == 0) {
        return;
    }
    const ImVec2 scale{(place.max.x - place.min.x) / static_cast<float>(size.x),
                       (place.max.y - place.min.y) / static_cast<float>(size.y)};
    for (const ScreenMark& mark : viewer.marks()) {
        const ImVec2 low{place.min.x + scale.x * static_cast<float>(mark.rect.x),
                         place.max.y -
                             scale.y * static_cast<float>(mark.rect.y + mark.rect.height)};
        const ImVec2 high{low.x + scale.x * static_cast<float>(mark.rect.width),
                          low.y + scale.y * static_cast<float>(mark.rect.height)};
        if (mark.filled) {
            list.AddRectFilled(low, high, to_u32(mark.color));
        } else {
            list.AddRect(low, {high.x - 1.0f, high.y - 1.0f}, to_u32(mark.color));
        }
    }
}

// Overlays that lie on the screen of the culling camera: over its picture, wherever that is.
void screen_overlays(ImDrawList& list, const Viewer& viewer, const Layout& layout)
{
    const PictureState& picture = viewer.state().picture;
    if (has_inset(viewer)) {
        const Place inset = inset_place(layout);
        marks(list, viewer, inset);
        list.AddRect({inset.min.x - 1.0f, inset.min.y - 1.0f},
                     {inset.max.x + 1.0f, inset.max.y + 1.0f}, IM_COL32_WHITE);
        label(list, {inset.min.x + scaled(4.0f), inset.min.y + scaled(2.0f)},
              "what the culling camera sees");
    } else if (!viewer.state().camera.frozen && !picture.difference) {
        Place shown{layout.picture_min, layout.picture_max};
        const float divider = picture.split ? picture.divider : 1.0f;
        list.PushClipRect(shown.min, {shown.min.x + divider * layout.picture_size().x, shown.max.y},
                          true);
        marks(list, viewer, shown);
        list.PopClipRect();
    }
}

void flare(ImDrawList& list, const Viewer& viewer, const Layout& layout)
{
    const auto flare = viewer.flare();
    if (!flare) {
        return;
    }
    const ImVec2 size = layout.picture_size();
    const ImVec2 at{layout.picture_min.x + flare->at.x * size.x,
                    layout.picture_max.y - flare->at.y * size.y};
    const ImVec2 middle{0.5f * (layout.picture_min.x + layout.picture_max.x),
                        0.5f * (layout.picture_min.y + layout.picture_max.y)};
    struct Ghost {
        float along; ///< from the light through the middle of the picture
        float radius;
        float alpha;
    };
    constexpr std::array<Ghost, 5> kGhosts = {{{0.0f, 46.0f, 0.45f},
                                               {0.0f, 18.0f, 0.9f},
                                               {0.6f, 14.0f, 0.3f},
                                               {1.3f, 26.0f, 0.22f},
                                               {1.8f, 44.0f, 0.15f}}};
    for (const Ghost& ghost : kGhosts) {
        list.AddCircleFilled(
            {at.x + ghost.along * (middle.x - at.x), at.y + ghost.along * (middle.y - at.y)},
            scaled(ghost.radius), to_u32({1.0f, 0.95f, 0.75f, ghost.alpha * flare->brightness}),
            32);
    }
}

std::string caption(Viewer& viewer, size_t index)
{
    const Pane& pane = viewer.pane(index);
    return fmt::format("{}  {:.1f} ms  {} tests", pane.algorithm(),
                       pane.figures().frame_ms.median(), pane.report().counters.queries);
}

void captions(ImDrawList& list, Viewer& viewer, const Layout& layout)
{
    const float pad = scaled(8.0f);
    label(list, {layout.picture_min.x + pad, layout.picture_min.y + pad}, caption(viewer, 0));
    if (viewer.pane_count() > 1) {
        const std::string right = caption(viewer, 1);
        label(list,
              {layout.picture_max.x - pad - ImGui::CalcTextSize(right.c_str()).x,
               layout.picture_min.y + pad},
              right);
    }
    std::string status;
    const auto add = [&](bool on, const char* word) {
        if (on) {
            status += (status.empty() ? "" : "  -  ") + std::string{word};
        }
    };
    add(viewer.state().camera.frozen, "culling camera frozen");
    add(viewer.state().time.paused, "paused");
    add(viewer.state().camera.playing, "playing the path");
    add(viewer.state().camera.recording, "recording the path");
    if (!status.empty()) {
        label(
            list,
            {layout.picture_min.x + pad, layout.picture_min.y + pad + ImGui::GetFontSize() * 1.4f},
            status);
    }
}

// The message of the last command, in the middle of the lower edge.
void message(ImDrawList& list, const Viewer& viewer, const Layout& layout)
{
    constexpr double kShownSeconds = 6.0;
    const ViewerState& state = viewer.state();
    const bool shown =
        !state.message.empty() && (state.message_is_error || state.message_age_s < kShownSeconds);
    const std::string line = shown ? state.message
                             : layout.narrow
                                 ? "click: why?   F: freeze   F1: keys   F2, F3: panels"
                                 : "drag: look   WASD: fly   click: why?   F: freeze   F1: keys";
    const float pad = scaled(8.0f);
    const float width = std::max(layout.picture_size().x - 4.0f * pad, 1.0f);
    const ImVec2 size = ImGui::CalcTextSize(line.c_str(), nullptr, false, width);
    const ImVec2 at{0.5f * (layout.picture_min.x + layout.picture_max.x - size.x),
                    layout.picture_max.y - size.y - 2.0f * pad};
    list.AddRectFilled(
        {at.x - pad, at.y - 0.5f * pad}, {at.x + size.x + pad, at.y + size.y + 0.5f * pad},
        shown && state.message_is_error ? IM_COL32(120, 40, 0, 230) : IM_COL32(15, 17, 20, 190),
        scaled(4.0f));
    list.AddText(nullptr, 0.0f, at, IM_COL32(255, 255, 255, 255), line.c_str(), nullptr, width);
    if (screen_notes().reading) {
        screen_notes().text += line + "\n";
    }
}

} // namespace

namespace {

struct LegendFlow {
    float row_height = 0.0f;
    float height = 0.0f; ///< of all rows
};

// Calls `place` with each line and its upper left, row by row, from (0, 0).
template <class Function>
LegendFlow flow_legend(std::span<const LegendLine> lines, float width, const Function& place)
{
    const float swatch_width = ImGui::GetFontSize() + scaled(4.0f);
    const float gap = scaled(14.0f);
    LegendFlow flow{.row_height = ImGui::GetFontSize() + scaled(4.0f)};
    ImVec2 at{0.0f, 0.0f};
    for (const LegendLine& line : lines) {
        const float needed = swatch_width + ImGui::CalcTextSize(line.text.c_str()).x;
        if (at.x > 0.0f && at.x + needed > width) {
            at = {0.0f, at.y + flow.row_height};
        }
        place(line, at);
        at.x += needed + gap;
    }
    flow.height = lines.empty() ? 0.0f : at.y + flow.row_height;
    return flow;
}

float legend_pad()
{
    return scaled(6.0f);
}

// Below the picture, so that it covers nothing of it.
void legend_strip(ImDrawList& list, const Layout& layout)
{
    const ImVec2 low{layout.picture_min.x, layout.picture_max.y};
    const ImVec2 high{layout.picture_max.x, layout.picture_max.y + layout.legend_height};
    const float pad = legend_pad();
    const float side = ImGui::GetFontSize() - scaled(2.0f);
    list.AddRectFilled(low, high, ImGui::GetColorU32(ImGuiCol_WindowBg));
    list.PushClipRect(low, high, true);
    flow_legend(layout.legend, high.x - low.x - 2.0f * pad,
                [&](const LegendLine& line, ImVec2 offset) {
                    const ImVec2 at{low.x + pad + offset.x, low.y + pad + offset.y};
                    list.AddRectFilled({at.x, at.y + scaled(1.0f)},
                                       {at.x + side, at.y + scaled(1.0f) + side},
                                       to_u32(line.color), scaled(2.0f));
                    list.AddText({at.x + ImGui::GetFontSize() + scaled(4.0f), at.y}, IM_COL32_WHITE,
                                 line.text.c_str());
                    if (screen_notes().reading) {
                        screen_notes().text += line.text + "\n";
                    }
                });
    list.PopClipRect();
}

} // namespace

float legend_height(std::span<const LegendLine> lines, float width)
{
    if (lines.empty()) {
        return 0.0f;
    }
    const float pad = legend_pad();
    return flow_legend(lines, width - 2.0f * pad, [](const LegendLine&, ImVec2) {}).height +
           2.0f * pad;
}

void copy_pictures(const Viewer& viewer, const Layout& layout, const Canvas& screen)
{
    if (layout.window.x < 1.0f) {
        return;
    }
    const float ratio = static_cast<float>(screen.size().x) / layout.window.x;
    const PictureState& picture = viewer.state().picture;
    if (picture.difference) {
        copy_columns(viewer.difference(), screen, layout, ratio, 0.0f, 1.0f);
    } else if (picture.split) {
        copy_columns(viewer.canvas(0), screen, layout, ratio, 0.0f, picture.divider);
        copy_columns(viewer.canvas(1), screen, layout, ratio, picture.divider, 1.0f);
    } else {
        copy_columns(viewer.canvas(0), screen, layout, ratio, 0.0f, 1.0f);
    }
    if (has_inset(viewer)) {
        const glm::ivec2 size = viewer.eye().size();
        viewer.eye().copy_part({0, 0, size.x, size.y}, screen,
                               framebuffer_rect(inset_place(layout), ratio, screen.size()));
    }
}

void picture_layer(Viewer& viewer, const Layout& layout, ImDrawList& list)
{
    if (layout.legend_height > 0.0f) {
        legend_strip(list, layout);
    }
    list.PushClipRect(layout.picture_min, layout.picture_max);
    const PictureState& picture = viewer.state().picture;
    if (viewer.session() != nullptr) {
        if (picture.split && !picture.difference) {
            const float x = layout.picture_min.x + picture.divider * layout.picture_size().x;
            list.AddLine({x, layout.picture_min.y}, {x, layout.picture_max.y},
                         IM_COL32(255, 255, 255, 255), scaled(2.0f));
            const float y = 0.5f * (layout.picture_min.y + layout.picture_max.y);
            list.AddCircleFilled({x, y}, scaled(7.0f), IM_COL32(255, 255, 255, 255));
        }
        screen_overlays(list, viewer, layout);
        flare(list, viewer, layout);
        captions(list, viewer, layout);
    }
    message(list, viewer, layout);
    list.PopClipRect();
}

} // namespace occlude::tools::viewer
