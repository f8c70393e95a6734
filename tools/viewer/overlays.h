// What the viewer draws over a picture: boxes in the world and rectangles on the screen, in the
// colours of the palette, each kind with the lines of its legend.
#pragma once

#include "render/palette.h"
#include "viewer/pane.h"

#include <occlude/core/view.h>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools::viewer {

/// How the objects are filled.
enum class Fill : uint8_t {
    visible, ///< what the algorithm drew, in its own colours
    hidden,  ///< ... and on top, what it left out though it is in the frustum
    states,  ///< everything in the frustum in the colour of its decision
    all,     ///< everything, as if nothing was culled
};
inline constexpr std::array<std::string_view, 4> kFillNames = {"drawn", "drawn, hidden on top",
                                                               "by decision", "everything"};

enum class Overlay : uint8_t {
    decided_boxes,
    tested_boxes,
    shapes,
    levels,
    groups,
    grid_cells,
    depth_reads,
    pyramid,
};
inline constexpr std::array<std::string_view, 8> kOverlayNames = {
    "decided boxes", "tested boxes",    "shapes of items", "tree level",
    "multiqueries",  "lazy grid cells", "depth reads",     "depth pyramid"};
inline constexpr size_t kOverlayCount = kOverlayNames.size();

/// Which overlays are on, and their own settings.
struct OverlaySettings {
    std::array<bool, kOverlayCount> on{};
    int level = 3;         ///< of the tree, from the root
    int pyramid_level = 4; ///< 2^level pixels a side

    bool has(Overlay overlay) const { return on[static_cast<size_t>(overlay)]; }
    /// Whether one of those is on that lie on the screen of the culling camera.
    bool any_on_screen() const;
};

/// Segments of one colour: pairs of points in the world.
struct WorldLines {
    glm::vec4 color{1.0f};
    bool on_top = false;
    std::vector<glm::vec3> points;
};

/// A rectangle of pixels of the culling camera's picture, row 0 at the bottom.
struct ScreenMark {
    PixelRect rect;
    glm::vec4 color{1.0f};
    bool filled = false;
};

struct LegendLine {
    glm::vec4 color{1.0f};
    std::string text;
};

/// What the overlays of one frame show.
struct OverlayPicture {
    std::vector<WorldLines> lines;
    std::vector<ScreenMark> marks;
};

/// The overlays in the world and those on the screen; `size_px` is that of the culled frame.
/// `depth` is its window depth, row by row from the bottom, read only for the pyramid; empty: none.
/// Precondition: pane.culler().
OverlayPicture make_overlays(const OverlaySettings& settings, const Pane& pane,
                             const ItemShapes* shapes, glm::ivec2 size_px,
                             std::span<const float> depth);

/// The lines of the legend of a fill and of all overlays that are on, each colour once.
std::vector<LegendLine> legend(Fill fill, const OverlaySettings& settings, const Pane& pane);

/// The colour of multiquery number `index`: neighbours differ.
glm::vec4 group_color(size_t index);

/// Adds the 12 edges of a box to `points`, unless it is unbounded or empty.
void add_box(std::vector<glm::vec3>& points, const Aabb& box);

} // namespace occlude::tools::viewer
