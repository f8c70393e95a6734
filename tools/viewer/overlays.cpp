#include "viewer/overlays.h"

#include "session/picture.h"

#include <occlude/cull/lazy_grid.h>
#include <occlude/hierarchy/item_shapes.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace occlude::tools::viewer {

namespace {

constexpr glm::vec4 kFoundNothing = state_color(Decision::hidden).color.color;
constexpr glm::vec4 kFoundSamples = state_color(Decision::drawn_revealed).color.color;
constexpr glm::vec4 kUnanswered = palette::kLightGrey.color;
constexpr glm::vec4 kShapeColor = palette::kBlue.color;
constexpr glm::vec4 kLevelColor = palette::kSkyBlue.color;
constexpr glm::vec4 kCellFull = state_color(Decision::hidden).color.color;
constexpr glm::vec4 kCellFree = palette::kSkyBlue.color;
constexpr glm::vec4 kCellUnknown = palette::kYellow.color;
constexpr glm::vec4 kReadColor = palette::kPurple.color;

const std::array<glm::vec4, 6> kGroupColors = {palette::kOrange.color, palette::kSkyBlue.color,
                                               palette::kGreen.color,  palette::kPurple.color,
                                               palette::kYellow.color, palette::kBlue.color};

void add_lines(OverlayPicture& picture, const glm::vec4& color, bool on_top,
               std::vector<glm::vec3> points)
{
    if (!points.empty()) {
        picture.lines.push_back({color, on_top, std::move(points)});
    }
}

void add_decided_boxes(OverlayPicture& picture, const Culler& culler)
{
    for (const StateColor& state : state_colors()) {
        std::vector<glm::vec3> points;
        for (const DecisionLog::Entry& entry : culler.decisions().entries()) {
            if (entry.decision == state.decision && state.decision != Decision::outside) {
                add_box(points, culler.hierarchy().node(entry.node).box);
            }
        }
        // Hidden boxes are behind something by definition: only on top can they be seen.
        add_lines(picture, state.color.color, !is_drawn(state.decision), std::move(points));
    }
}

void add_tested_boxes(OverlayPicture& picture, const FrameTrace& trace)
{
    std::vector<glm::vec3> nothing;
    std::vector<glm::vec3> samples;
    std::vector<glm::vec3> unanswered;
    for (const TracedTest& test : trace.tests) {
        auto& points = test.state == AnswerState::pending ? unanswered
                       : test.found_nothing()             ? nothing
                                                          : samples;
        for (const Aabb& box : test.boxes) {
            add_box(points, box);
        }
    }
    add_lines(picture, kFoundNothing, true, std::move(nothing));
    add_lines(picture, kFoundSamples, true, std::move(samples));
    add_lines(picture, kUnanswered, true, std::move(unanswered));
}

void add_groups(OverlayPicture& picture, const FrameTrace& trace)
{
    size_t group = 0;
    for (const TracedTest& test : trace.tests) {
        if (test.subjects.size() < 2) {
            continue;
        }
        std::vector<glm::vec3> points;
        for (const Aabb& box : test.boxes) {
            add_box(points, box);
        }
        add_lines(picture, group_color(group++), true, std::move(points));
    }
}

void add_shapes(OverlayPicture& picture, const Culler& culler, const ItemShapes* shapes)
{
    std::vector<glm::vec3> points;
    for (const ItemId item : culler.drawn_items()) {
        const ItemShapes::Placed* placed = shapes != nullptr ? shapes->find(item) : nullptr;
        if (placed == nullptr) {
            continue;
        }
        for (const Aabb& box : *placed->shape) {
            for (const glm::vec3& corner : box_edges(box)) {
                points.emplace_back(placed->world_from_shape * glm::vec4{corner, 1.0f});
            }
        }
    }
    add_lines(picture, kShapeColor, false, std::move(points));
}

void add_level(OverlayPicture& picture, const Hierarchy& hierarchy, int level)
{
    std::vector<glm::vec3> points;
    std::vector<int> depth(hierarchy.nodes().size(), 0);
    for (uint32_t i = 0; i < depth.size(); ++i) { // parents come before their children
        const Node& node = hierarchy.nodes()[i];
        depth[i] = node.parent.valid() ? depth[node.parent.value] + 1 : 0;
        if (depth[i] == level) {
            add_box(points, node.box);
        }
    }
    add_lines(picture, kLevelColor, true, std::move(points));
}

void add_grid_cells(OverlayPicture& picture, const Culler& culler)
{
    const auto* lazy = dynamic_cast<const LazyGrid*>(&culler);
    if (lazy == nullptr) {
        return;
    }
    const OcclusionGrid& grid = lazy->grid();
    for (int y = 0; y < grid.size_in_cells().y; ++y) {
        for (int x = 0; x < grid.size_in_cells().x; ++x) {
            const OcclusionGrid::Cell& cell = grid.cell({x, y});
            if (cell.untouched) {
                continue;
            }
            const bool full = cell.zfar < OcclusionGrid::kFarthest;
            const bool outdated = cell.known_free == OcclusionGrid::kUnknown;
            picture.marks.push_back({grid.pixels({x, y}),
                                     full       ? kCellFull
                                     : outdated ? kCellUnknown
                                                : kCellFree,
                                     false});
        }
    }
}

void add_depth_reads(OverlayPicture& picture, const FrameTrace& trace)
{
    for (const TracedCall& call : trace.calls) {
        if (call.verb == DeviceVerb::read_depth) {
            picture.marks.push_back({call.rect, kReadColor, false});
        }
    }
}

// The farthest depth of each texel, as grey: near is dark. Depths crowd at 1, hence the power.
void add_pyramid(OverlayPicture& picture, std::span<const float> depth, glm::ivec2 size, int level)
{
    if (depth.size() != static_cast<size_t>(size.x) * static_cast<size_t>(size.y)) {
        return;
    }
    const int side = 1 << level;
    for (int y = 0; y < size.y; y += side) {
        for (int x = 0; x < size.x; x += side) {
            const PixelRect rect{x, y, std::min(side, size.x - x), std::min(side, size.y - y)};
            float farthest = 0.0f;
            for (int row = 0; row < rect.height; ++row) {
                const float* first = depth.data() +
                                     static_cast<size_t>(y + row) * static_cast<size_t>(size.x) +
                                     static_cast<size_t>(x);
                farthest = std::max(farthest, *std::max_element(first, first + rect.width));
            }
            constexpr float kContrast = 24.0f;
            const float grey = std::pow(farthest, kContrast);
            picture.marks.push_back({rect, {grey, grey, grey, 0.75f}, true});
        }
    }
}

} // namespace

bool OverlaySettings::any_on_screen() const
{
    return has(Overlay::grid_cells) || has(Overlay::depth_reads) || has(Overlay::pyramid);
}

void add_box(std::vector<glm::vec3>& points, const Aabb& box)
{
    if (box.is_bounded() && !box.is_empty()) {
        const auto edges = box_edges(box);
        points.insert(points.end(), edges.begin(), edges.end());
    }
}

glm::vec4 group_color(size_t index)
{
    return kGroupColors[index % kGroupColors.size()];
}

OverlayPicture make_overlays(const OverlaySettings& settings, const Pane& pane,
                             const ItemShapes* shapes, glm::ivec2 size_px,
                             std::span<const float> depth)
{
    const Culler& culler = *pane.culler();
    OverlayPicture picture;
    if (settings.has(Overlay::levels)) {
        add_level(picture, culler.hierarchy(), settings.level);
    }
    if (settings.has(Overlay::shapes)) {
        add_shapes(picture, culler, shapes);
    }
    if (settings.has(Overlay::decided_boxes)) {
        add_decided_boxes(picture, culler);
    }
    if (settings.has(Overlay::tested_boxes)) {
        add_tested_boxes(picture, pane.trace());
    }
    if (settings.has(Overlay::groups)) {
        add_groups(picture, pane.trace());
    }
    if (settings.has(Overlay::pyramid)) {
        add_pyramid(picture, depth, size_px, settings.pyramid_level);
    }
    if (settings.has(Overlay::grid_cells)) {
        add_grid_cells(picture, culler);
    }
    if (settings.has(Overlay::depth_reads)) {
        add_depth_reads(picture, pane.trace());
    }
    return picture;
}

namespace {

// All of them, whether or not this frame has them: the legend must not change its size at each
// frame.
void add_state_lines(std::vector<LegendLine>& lines, bool with_outside)
{
    for (const StateColor& state : state_colors()) {
        if (state.decision != Decision::undecided &&
            (with_outside || state.decision != Decision::outside)) {
            lines.push_back({state.color.color, std::string{state.meaning}});
        }
    }
}

} // namespace

std::vector<LegendLine> legend(Fill fill, const OverlaySettings& settings, const Pane& pane)
{
    std::vector<LegendLine> lines;
    if (fill == Fill::states || settings.has(Overlay::decided_boxes)) {
        add_state_lines(lines, fill == Fill::states);
    } else if (fill == Fill::hidden) {
        lines.push_back({kFoundNothing, "hidden: not drawn"});
    }
    const bool lazy = dynamic_cast<const LazyGrid*>(pane.culler()) != nullptr;
    if (settings.has(Overlay::tested_boxes)) {
        lines.push_back({kFoundNothing, "tested box: no sample could be seen"});
        lines.push_back({kFoundSamples, "tested box: samples could be seen"});
        lines.push_back({kUnanswered, "tested box: not answered in this frame"});
    }
    if (settings.has(Overlay::groups)) {
        lines.push_back({group_color(0), "boxes of one colour: one test (multiquery)"});
    }
    if (settings.has(Overlay::shapes)) {
        lines.push_back({kShapeColor, "shapes: boxes tighter than the item's own"});
    }
    if (settings.has(Overlay::levels)) {
        lines.push_back(
            {kLevelColor, fmt::format("nodes at level {} of the tree", settings.level)});
    }
    if (settings.has(Overlay::grid_cells) && lazy) {
        lines.push_back({kCellFull, "cell: full, all its pixels are covered"});
        lines.push_back({kCellFree, "cell: a free pixel is known"});
        lines.push_back({kCellUnknown, "cell: drawn into since it was looked at"});
    } else if (settings.has(Overlay::grid_cells)) {
        lines.push_back({kUnanswered, "cells: only lazy_grid has them"});
    }
    if (settings.has(Overlay::depth_reads)) {
        lines.push_back({kReadColor, "pixels whose depth was read back"});
    }
    if (settings.has(Overlay::pyramid)) {
        lines.push_back(
            {palette::kWhite.color, fmt::format("farthest depth of {0}x{0} pixels: dark is near",
                                                1 << settings.pyramid_level)});
    }
    return lines;
}

} // namespace occlude::tools::viewer
