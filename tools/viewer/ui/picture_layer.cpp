// The picture in the middle of the window, and what is written over it.
#include "viewer/ui/panels.h"

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools::viewer {

namespace {

ImTextureID texture_of(const Canvas& canvas)
{
    return reinterpret_cast<ImTextureID>(static_cast<intptr_t>(canvas.texture()));
}

// Text with a shadow, so that it is read on any picture; noted for scripts.
void label(ImDrawList& list, ImVec2 at, const std::string& line)
{
    list.AddText({at.x + 1.0f, at.y + 1.0f}, IM_COL32(0, 0, 0, 220), line.c_str());
    list.AddText(at, IM_COL32(255, 255, 255, 255), line.c_str());
    if (screen_notes().reading) {
        screen_notes().text += line + "\n";
    }
}

// A dark box with lines in it, each with a swatch if it has a colour; `at` is its upper left.
void box_of_lines(ImDrawList& list, ImVec2 at, std::span<const LegendLine> lines)
{
    const float height = ImGui::GetFontSize() + scaled(3.0f);
    const float side = ImGui::GetFontSize() - scaled(3.0f);
    float width = 0.0f;
    for (const LegendLine& line : lines) {
        width = std::max(width, ImGui::CalcTextSize(line.text.c_str()).x);
    }
    const float pad = scaled(6.0f);
    list.AddRectFilled(at,
                       {at.x + width + side + 3.0f * pad,
                        at.y + height * static_cast<float>(lines.size()) + 2.0f * pad},
                       IM_COL32(15, 17, 20, 210), scaled(4.0f));
    float y = at.y + pad;
    for (const LegendLine& line : lines) {
        list.AddRectFilled({at.x + pad, y + scaled(2.0f)},
                           {at.x + pad + side, y + scaled(2.0f) + side}, to_u32(line.color),
                           scaled(2.0f));
        label(list, {at.x + 2.0f * pad + side, y}, line.text);
        y += height;
    }
}

void image(ImDrawList& list, const Canvas& canvas, const Layout& layout, float from, float to)
{
    if (canvas.empty()) {
        return;
    }
    const float width = layout.picture_size().x;
    list.AddImage(texture_of(canvas), {layout.picture_min.x + from * width, layout.picture_min.y},
                  {layout.picture_min.x + to * width, layout.picture_max.y}, {from, 1.0f},
                  {to, 0.0f});
}

void marks(ImDrawList& list, const Viewer& viewer, const Layout& layout)
{
    const glm::ivec2 size = viewer.canvas(0).size();
    if (size.x == 0) {
        return;
    }
    const ImVec2 scale{layout.picture_size().x / static_cast<float>(size.x),
                       layout.picture_size().y / static_cast<float>(size.y)};
    for (const ScreenMark& mark : viewer.marks()) {
        const ImVec2 low{layout.picture_min.x + scale.x * static_cast<float>(mark.rect.x),
                         layout.picture_max.y -
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
    const PictureState& picture = viewer.state().picture;
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
    add(picture.difference, "orange: the two images differ");
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
    const std::string line =
        shown ? state.message : "drag: look   WASD: fly   click: why?   F: freeze   F1: keys";
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

void picture_layer(Viewer& viewer, const Layout& layout)
{
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect(layout.picture_min, layout.picture_max);
    const PictureState& picture = viewer.state().picture;
    if (viewer.session() != nullptr) {
        if (picture.difference) {
            image(list, viewer.difference(), layout, 0.0f, 1.0f);
        } else if (picture.split) {
            image(list, viewer.canvas(0), layout, 0.0f, picture.divider);
            image(list, viewer.canvas(1), layout, picture.divider, 1.0f);
            const float x = layout.picture_min.x + picture.divider * layout.picture_size().x;
            list.AddLine({x, layout.picture_min.y}, {x, layout.picture_max.y},
                         IM_COL32(255, 255, 255, 255), scaled(2.0f));
            const float y = 0.5f * (layout.picture_min.y + layout.picture_max.y);
            list.AddCircleFilled({x, y}, scaled(7.0f), IM_COL32(255, 255, 255, 255));
        } else {
            image(list, viewer.canvas(0), layout, 0.0f, 1.0f);
        }
        marks(list, viewer, layout);
        flare(list, viewer, layout);
        captions(list, viewer, layout);
        const std::vector<LegendLine> lines =
            legend(picture.fill, picture.overlays, viewer.pane(0));
        if (!lines.empty()) {
            const float pad = scaled(8.0f);
            box_of_lines(list,
                         {layout.picture_min.x + pad,
                          layout.picture_min.y + pad + 3.0f * ImGui::GetFontSize()},
                         lines);
        }
    }
    message(list, viewer, layout);
    list.PopClipRect();
}

} // namespace occlude::tools::viewer
