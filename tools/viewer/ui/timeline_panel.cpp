// The time line of a frame: draws, tests, waits and the algorithm's own work, as the figures of
// the papers show them.
#include "viewer/ui/panels.h"

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools::viewer {

namespace {

enum class Lane : uint8_t { draw, test, wait, read };

struct LaneStyle {
    const char* name;
    glm::vec4 color;
};
constexpr std::array<LaneStyle, 4> kLanes = {{{"draw", palette::kGreen.color},
                                              {"test", palette::kSkyBlue.color},
                                              {"wait", palette::kYellow.color},
                                              {"read depth", palette::kPurple.color}}};

std::optional<Lane> lane_of(DeviceVerb verb)
{
    switch (verb) {
    case DeviceVerb::draw:
    case DeviceVerb::begin_frame:
    case DeviceVerb::draw_and_query:
        return Lane::draw;
    case DeviceVerb::query:
    case DeviceVerb::poll:
        return Lane::test;
    case DeviceVerb::wait:
    case DeviceVerb::flush:
    case DeviceVerb::end_frame:
        return Lane::wait;
    case DeviceVerb::read_depth:
    case DeviceVerb::read_depth_tiles:
        return Lane::read;
    }
    return std::nullopt;
}

std::string describe(const TracedCall& call, const FrameTrace& trace)
{
    constexpr double kMsPerSecond = 1000.0;
    std::string line =
        fmt::format("{}: {:.3f} ms", name(call.verb), kMsPerSecond * (call.end_s - call.begin_s));
    if (call.items > 0) {
        line += fmt::format("\n{} items", call.items);
    }
    if (call.test_count > 0) {
        size_t hidden = 0;
        size_t boxes = 0;
        for (uint32_t i = call.first_test; i < call.first_test + call.test_count; ++i) {
            hidden += trace.tests[i].found_nothing() ? 1 : 0;
            boxes += trace.tests[i].boxes.size();
        }
        line +=
            fmt::format("\n{} tests of {} boxes; {} found nothing", call.test_count, boxes, hidden);
    }
    if (call.rect.width > 0) {
        line += fmt::format("\n{}x{} pixels", call.rect.width, call.rect.height);
    }
    return line;
}

struct Sums {
    std::array<double, kLanes.size()> lanes{};
    double finish = 0.0;
    double total = 0.0;
};

Sums sums_of(const FrameTrace& trace)
{
    Sums sums;
    sums.total = trace.end_s - trace.begin_s;
    double verbs_end = trace.begin_s;
    for (const TracedCall& call : trace.calls) {
        if (const auto lane = lane_of(call.verb)) {
            sums.lanes[static_cast<size_t>(*lane)] += call.end_s - call.begin_s;
        }
        verbs_end = std::max(verbs_end, call.end_s);
    }
    sums.finish = trace.end_s - verbs_end;
    return sums;
}

// Writes on the same line if there is room for it, and else on the next one.
void flowing_text(const std::string& words, const ImVec4& color)
{
    const float end = ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x +
                      ImGui::CalcTextSize(words.c_str()).x;
    if (end < ImGui::GetWindowPos().x + ImGui::GetContentRegionMax().x) {
        ImGui::SameLine();
    }
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    text(words);
    ImGui::PopStyleColor();
}

void show_sums(const Sums& sums, const std::string& algorithm)
{
    constexpr double kMsPerSecond = 1000.0;
    double rest = sums.total - sums.finish;
    text(fmt::format("{}: {:.2f} ms =", algorithm, kMsPerSecond * sums.total));
    for (size_t i = 0; i < kLanes.size(); ++i) {
        rest -= sums.lanes[i];
        flowing_text(fmt::format("{} {:.2f}", kLanes[i].name, kMsPerSecond * sums.lanes[i]),
                     {kLanes[i].color.r, kLanes[i].color.g, kLanes[i].color.b, 1.0f});
    }
    flowing_text(fmt::format("algorithm {:.2f}", kMsPerSecond * std::max(rest, 0.0)),
                 ImGui::GetStyleColorVec4(ImGuiCol_Text));
    flowing_text(fmt::format("finish {:.2f}", kMsPerSecond * sums.finish),
                 ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
}

void show_lanes(const FrameTrace& trace, float height)
{
    const float label_width = scaled(74.0f);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = std::max(ImGui::GetContentRegionAvail().x - label_width, 1.0f);
    const float lane_height = height / static_cast<float>(kLanes.size());
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const double total = std::max(trace.end_s - trace.begin_s, 1e-9);
    const auto x_of = [&](double seconds) {
        return at.x + label_width + static_cast<float>((seconds - trace.begin_s) / total) * width;
    };
    for (size_t lane = 0; lane < kLanes.size(); ++lane) {
        const float y = at.y + static_cast<float>(lane) * lane_height;
        list.AddRectFilled({at.x + label_width, y + 1.0f},
                           {at.x + label_width + width, y + lane_height - 1.0f},
                           ImGui::GetColorU32(ImGuiCol_FrameBg));
        list.AddText({at.x, y}, ImGui::GetColorU32(ImGuiCol_Text), kLanes[lane].name);
    }
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const TracedCall* under = nullptr;
    double verbs_end = trace.begin_s;
    for (const TracedCall& call : trace.calls) {
        verbs_end = std::max(verbs_end, call.end_s);
        const auto lane = lane_of(call.verb);
        if (!lane) {
            continue;
        }
        const auto index = static_cast<size_t>(*lane);
        const float y = at.y + static_cast<float>(index) * lane_height;
        const ImVec2 low{x_of(call.begin_s), y + 2.0f};
        const ImVec2 high{std::max(x_of(call.end_s), low.x + 1.0f), y + lane_height - 2.0f};
        list.AddRectFilled(low, high, to_u32(kLanes[index].color));
        if (mouse.x >= low.x - 1.0f && mouse.x <= high.x + 1.0f && mouse.y >= low.y &&
            mouse.y <= high.y) {
            under = &call;
        }
    }
    list.AddRectFilled({x_of(verbs_end), at.y + 1.0f}, {x_of(trace.end_s), at.y + height - 1.0f},
                       IM_COL32(255, 255, 255, 28));
    ImGui::Dummy({label_width + width, height});
    if (under != nullptr && ImGui::IsItemHovered()) {
        ImGui::BeginTooltip();
        text(describe(*under, trace));
        ImGui::EndTooltip();
    }
}

} // namespace

void timeline_panel(Viewer& viewer, const Layout& layout)
{
    const float x = layout.controls_width;
    const PanelScope scope{"time line",
                           {x, layout.window.y - layout.timeline_height},
                           {layout.window.x - layout.inspector_width - x, layout.timeline_height},
                           false};
    const FrameTrace& trace = viewer.pane(0).trace();
    if (trace.calls.empty()) {
        faint("There is no frame yet.");
        return;
    }
    show_sums(sums_of(trace), viewer.pane(0).algorithm());
    show_lanes(trace, std::max(ImGui::GetContentRegionAvail().y - scaled(6.0f), scaled(40.0f)));
}

} // namespace occlude::tools::viewer
