#include <occlude/integration/audit.h>

#include <occlude/screen/projection.h>

#include <glm/matrix.hpp>

#include <algorithm>
#include <array>

namespace occlude {

namespace {

// Depth is compared with the slack of tested boxes, plus some for the engine's own vertex stream.
constexpr float kDepthSlack = 1e-5f;

struct Pixel {
    glm::ivec2 at{0};
    float depth = 1.0f;
};

// The visible part of one item in the frame that was just drawn.
std::vector<Pixel> seen_pixels(std::span<const float> depths, glm::ivec2 size)
{
    std::vector<Pixel> seen;
    for (size_t i = 0; i < depths.size(); ++i) {
        if (depths[i] < 1.0f) {
            const auto index = static_cast<int>(i);
            seen.push_back({{index % size.x, index / size.x}, depths[i]});
        }
    }
    return seen;
}

bool holds(const ScreenBounds& bounds, const Pixel& pixel)
{
    if (!bounds.valid) {
        return true; // the box touches the near plane: it may be anywhere
    }
    const PixelRect& rect = bounds.rect;
    return pixel.at.x >= rect.x && pixel.at.x < rect.x + rect.width && pixel.at.y >= rect.y &&
           pixel.at.y < rect.y + rect.height && pixel.depth >= bounds.near_depth - kDepthSlack &&
           pixel.depth <= bounds.far_depth + kDepthSlack;
}

// Another camera than the view's, which may explain what was drawn.
struct Suspect {
    View view;
    const char* verdict;
    size_t fitting = 0; ///< number of items whose visible part lies in their boxes under this
                        ///< camera
};

std::array<Suspect, 2> suspects(const View& view)
{
    const ClipConvention now = view.convention();
    const ClipConvention range{now.range == DepthRange::zero_to_one ? DepthRange::minus_one_to_one
                                                                    : DepthRange::zero_to_one,
                               now.order};
    const glm::mat4& matrix = view.clip_from_world();
    return {{{View::from_clip(glm::transpose(matrix), view.size_px(), now),
              "the matrix of the view is transposed: give View::from_clip clip_from_world with its "
              "translation in the last column, as GLM has it"},
             {View::from_clip(matrix, view.size_px(), range),
              "the view's ClipConvention has the wrong depth range: use zero_to_one for "
              "D3D, Vulkan and glClipControl, minus_one_to_one for plain OpenGL"}}};
}

std::string text(glm::ivec2 pixel)
{
    std::string text = "(";
    text += std::to_string(pixel.x);
    text += ", ";
    text += std::to_string(pixel.y);
    text += ")";
    return text;
}

OutsideItem describe(ItemId item, const ScreenBounds& bounds, std::span<const Pixel> seen)
{
    OutsideItem outside{item, 0, {}, 0.0f, {}};
    for (const Pixel& pixel : seen) {
        if (holds(bounds, pixel)) {
            continue;
        }
        if (outside.pixels == 0) {
            outside.first_px = pixel.at;
            outside.depth = pixel.depth;
        }
        ++outside.pixels;
    }
    outside.text = "item " + std::to_string(item.value) +
                   " leaves its box: " + std::to_string(outside.pixels) + " of " +
                   std::to_string(seen.size()) + " pixels, the first at " + text(outside.first_px) +
                   " with depth " + std::to_string(outside.depth) +
                   ". The box is too small, or the item moved and its box did not";
    return outside;
}

// `fitting`: number of items that fit their boxes in the given view.
std::string find_verdict(const BoundsAudit& audit, size_t fitting,
                         std::span<const Suspect> suspects)
{
    if (audit.outside.empty()) {
        return {};
    }
    // One camera that explains most items is more likely than that many wrong boxes.
    const auto best = std::ranges::max_element(suspects, {}, &Suspect::fitting);
    if (2 * best->fitting > audit.items_drawn && best->fitting > 2 * fitting) {
        return best->verdict;
    }
    if (2 * audit.outside.size() > audit.items_drawn && audit.items_drawn > 1) {
        return "most items leave their boxes: is the matrix of the view the one that you draw "
               "with, and are the boxes in world space?";
    }
    return std::to_string(audit.outside.size()) +
           " items leave their boxes: " + audit.outside.front().text;
}

} // namespace

Result<BoundsAudit> audit_item_bounds(QueryDevice& device, const View& view,
                                      std::span<const ItemBounds> bounds)
{
    const glm::ivec2 size = view.size_px();
    if (!device.caps().read_depth || size.x <= 0 || size.y <= 0) {
        return Error{ErrorCode::unsupported,
                     "audit_item_bounds() needs a view of some pixels and a device that can read "
                     "depth (caps().read_depth)"};
    }
    BoundsAudit audit;
    std::array<Suspect, 2> others = suspects(view);
    size_t fitting = 0;
    std::vector<float> depths(pixel_count(size));
    for (size_t i = 0; i < bounds.size(); ++i) {
        if (bounds[i].box.is_empty()) {
            continue;
        }
        const ItemId item{i};
        device.begin_frame(view);
        device.draw({&item, 1}, DrawPass::shade);
        const bool read = device.read_depth({0, 0, size.x, size.y}, depths);
        device.end_frame();
        if (!read) {
            return Error{ErrorCode::device_failed,
                         "audit_item_bounds(): the device could not read depth of item " +
                             std::to_string(i)};
        }
        const std::vector<Pixel> seen = seen_pixels(depths, size);
        audit.items_drawn += seen.empty() ? 0 : 1;
        if (seen.empty()) {
            continue;
        }
        const auto all_in = [&](const ScreenBounds& box) {
            return std::ranges::all_of(seen, [&](const Pixel& p) { return holds(box, p); });
        };
        const ScreenBounds box = project(view, bounds[i].box);
        if (!all_in(box)) {
            audit.outside.push_back(describe(item, box, seen));
        }
        // A box at the near plane may be anywhere, and proves nothing about the camera.
        fitting += box.valid && all_in(box) ? 1 : 0;
        for (Suspect& other : others) {
            const ScreenBounds there = project(other.view, bounds[i].box);
            other.fitting += there.valid && all_in(there) ? 1 : 0;
        }
    }
    audit.verdict = find_verdict(audit, fitting, others);
    return audit;
}

std::vector<ItemId> stale_items(const Hierarchy& hierarchy, std::span<const ItemBounds> bounds)
{
    std::vector<ItemId> stale;
    for (size_t i = 0; i < hierarchy.items().size(); ++i) {
        const ItemId item = hierarchy.items()[i];
        const ItemBounds& known = hierarchy.item_bounds()[i];
        const bool same = item.value < bounds.size() &&
                          known.box.min == bounds[item.value].box.min &&
                          known.box.max == bounds[item.value].box.max &&
                          known.triangles == bounds[item.value].triangles &&
                          known.flags == bounds[item.value].flags;
        if (!same) {
            stale.push_back(item);
        }
    }
    return stale;
}

} // namespace occlude
