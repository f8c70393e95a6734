#include "session/picture.h"

#include "model/focus.h"
#include "walk/paths.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace occlude::tools {

namespace {

constexpr glm::vec4 kFrustumColor = palette::kWhite.color;
constexpr glm::vec4 kHiddenTint = linear_color(state_color(Decision::hidden).color.color);

// The corners of an edge differ in one bit: bit 0 is x, bit 1 is y, bit 2 is z.
std::array<glm::vec3, 24> edges_of(const std::array<glm::vec3, 8>& corners)
{
    std::array<glm::vec3, 24> edges{};
    size_t next = 0;
    for (size_t corner = 0; corner < corners.size(); ++corner) {
        for (const size_t bit : {1u, 2u, 4u}) {
            if ((corner & bit) == 0) {
                edges[next++] = corners[corner];
                edges[next++] = corners[corner | bit];
            }
        }
    }
    return edges;
}

std::vector<ItemId> hidden_in_frustum(const Stage& stage, const Culler& culler, const View& view)
{
    std::vector<ItemId> drawn{culler.drawn_items().begin(), culler.drawn_items().end()};
    std::sort(drawn.begin(), drawn.end());
    const std::vector<ItemId> items = items_in_frustum(view, stage.item_bounds);
    std::vector<ItemId> hidden;
    std::set_difference(items.begin(), items.end(), drawn.begin(), drawn.end(),
                        std::back_inserter(hidden));
    return hidden;
}

uint32_t mixed(uint32_t below, uint32_t above)
{
    constexpr uint32_t kAboveOf8 = 5;
    uint32_t result = 0;
    for (uint32_t shift = 0; shift < 32; shift += 8) {
        const uint32_t a = (below >> shift) & 0xffu;
        const uint32_t b = (above >> shift) & 0xffu;
        result |= ((a * (8 - kAboveOf8) + b * kAboveOf8) / 8) << shift;
    }
    return result;
}

// Draws `items` in one colour and blends them over `image`, as if nothing stood before them.
void shine_through(Session& session, const View& view, std::span<const ItemId> items, Image& image)
{
    const Stage stage = session.stage();
    const std::vector<glm::vec4> tints(stage.item_bounds.size(), kHiddenTint);
    stage.renderer.set_item_colors(tints);
    stage.renderer.render(view, items);
    const Image tinted = stage.renderer.capture().color;
    stage.renderer.set_item_colors({});
    const std::vector<uint32_t> ids = stage.renderer.render_ids(view, items);
    for (size_t i = 0; i < std::min(image.pixels.size(), ids.size()); ++i) {
        if (ItemId{ids[i]}.valid()) {
            image.pixels[i] = mixed(image.pixels[i], tinted.pixels[i]);
        }
    }
}

std::vector<glm::vec4> colors_by_state(const Culler& culler, size_t item_count)
{
    std::vector<glm::vec4> colors;
    colors.reserve(item_count);
    for (const Decision decision : item_decisions(culler, item_count)) {
        colors.push_back(linear_color(state_color(decision).color.color));
    }
    return colors;
}

void draw_decided_boxes(Session& session, const Culler& culler, const View& view)
{
    for (const StateColor& state : kStateColors) {
        std::vector<glm::vec3> points;
        for (const DecisionLog::Entry& entry : culler.decisions().entries()) {
            const Aabb& box = culler.hierarchy().node(entry.node).box;
            if (entry.decision == state.decision && state.decision != Decision::outside &&
                box.is_bounded()) {
                const std::array<glm::vec3, 24> edges = box_edges(box);
                points.insert(points.end(), edges.begin(), edges.end());
            }
        }
        if (!points.empty()) {
            // Hidden boxes are behind something by definition, so that they show only on top.
            session.renderer().draw_lines(view, points, state.color.color,
                                          !is_drawn(state.decision));
        }
    }
}

/// Draws the frustum over the picture with lines of three pixels, because devices draw lines of
/// one.
Image with_frustum(Session& session, const View& view, const View& path_view)
{
    const Image without = session.renderer().capture().color;
    const float reach = glm::length(world_bounds(session.model()).extent());
    session.renderer().draw_lines(view, frustum_edges(path_view, reach), kFrustumColor, true);
    const Image with = session.renderer().capture().color;
    Image image = with;
    const glm::ivec2 size = with.size;
    const auto pixel = [&](int x, int y) { return static_cast<size_t>(y * size.x + x); };
    for (int y = 1; y + 1 < size.y; ++y) {
        for (int x = 1; x + 1 < size.x; ++x) {
            if (with.pixels[pixel(x, y)] != without.pixels[pixel(x, y)]) {
                for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
                    image.pixels[pixel(x + dx, y + dy)] = with.pixels[pixel(x, y)];
                }
            }
        }
    }
    return image;
}

// The content of the renderer's target afterwards is the picture without lines and tints.
void draw_items_for(Session& session, const Culler& culler, const View& view, Show show,
                    bool from_outside)
{
    const Stage stage = session.stage();
    const bool by_state = show == Show::states || (show == Show::boxes && from_outside);
    if (!by_state) {
        stage.renderer.render(view, culler.drawn_items());
        return;
    }
    stage.renderer.set_item_colors(colors_by_state(culler, stage.item_bounds.size()));
    stage.renderer.render(
        view, in_draw_order(view, stage.item_bounds, items_in_frustum(view, stage.item_bounds)));
    stage.renderer.set_item_colors({});
}

} // namespace

std::vector<Decision> item_decisions(const Culler& culler, size_t item_count)
{
    std::vector<Decision> decisions = culler.decisions().by_item(culler.hierarchy());
    decisions.resize(item_count, Decision::undecided);
    for (const ItemId item : culler.drawn_items()) {
        if (!is_drawn(decisions[item.value])) {
            decisions[item.value] = Decision::drawn;
        }
    }
    return decisions;
}

Camera overview_camera(const SceneModel& model, const Camera& path_camera, glm::ivec2 size)
{
    constexpr float kFovY = 40.0f;   // degrees
    constexpr float kTilt = 1.0f;    // how far behind, per unit of height: oblique, so that walls
                                     // show
    constexpr float kMargin = 1.08f; // of the distance at which the bounds just fit
    const Aabb bounds = find_focus(model).box;
    const glm::vec3 up = glm::normalize(model.up);
    glm::vec3 heading = path_camera.target - path_camera.eye;
    heading -= up * glm::dot(heading, up);
    if (glm::length(heading) <
        1e-6f * glm::distance(path_camera.target, path_camera.eye)) { // it looks straight down
        heading = std::abs(up.x) < 0.5f ? glm::vec3{1.0f, 0.0f, 0.0f} : glm::vec3{0.0f, 1.0f, 0.0f};
        heading -= up * glm::dot(heading, up);
    }
    heading = glm::normalize(heading);
    const glm::vec3 forward = glm::normalize(kTilt * heading - up);
    const glm::vec3 right = glm::normalize(glm::cross(forward, heading));
    const glm::vec3 upward = glm::cross(right, forward);
    const float slope_y = std::tan(glm::radians(0.5f * kFovY));
    const float slope_x = slope_y * static_cast<float>(size.x) / static_cast<float>(size.y);
    float distance = 0.0f;
    for (const glm::vec3& corner : box_edges(bounds)) {
        const glm::vec3 offset = corner - bounds.center();
        const float needed = std::max(std::abs(glm::dot(offset, right)) / slope_x,
                                      std::abs(glm::dot(offset, upward)) / slope_y);
        distance = std::max(distance, needed - glm::dot(offset, forward));
    }
    Camera camera{.eye = bounds.center() - kMargin * distance * forward,
                  .target = bounds.center(),
                  .up = heading,
                  .fov_y = kFovY};
    choose_depth_range({&camera, 1}, model);
    return camera;
}

std::array<glm::vec3, 24> box_edges(const Aabb& box)
{
    std::array<glm::vec3, 8> corners{};
    for (size_t i = 0; i < corners.size(); ++i) {
        corners[i] = {(i & 1u) != 0 ? box.max.x : box.min.x, (i & 2u) != 0 ? box.max.y : box.min.y,
                      (i & 4u) != 0 ? box.max.z : box.min.z};
    }
    return edges_of(corners);
}

std::array<glm::vec3, 24> frustum_edges(const View& view, float reach)
{
    const glm::dmat4 world_from_clip = glm::inverse(glm::dmat4{view.clip_from_world()});
    const bool zero_to_one = view.convention().range == DepthRange::zero_to_one;
    const bool reversed = view.convention().order == DepthOrder::near_is_large;
    const double low = zero_to_one ? 0.0 : -1.0;
    std::array<glm::vec3, 8> corners{};
    for (size_t i = 0; i < corners.size(); ++i) {
        const bool is_far = (i & 4u) != 0;
        const glm::dvec4 corner =
            world_from_clip * glm::dvec4{(i & 1u) != 0 ? 1.0 : -1.0, (i & 2u) != 0 ? 1.0 : -1.0,
                                         is_far != reversed ? 1.0 : low, 1.0};
        const glm::vec3 world{glm::dvec3{corner} / corner.w};
        const glm::vec3 away = world - view.eye();
        const float length = glm::length(away);
        corners[i] = length > reach ? view.eye() + away * (reach / length) : world;
    }
    return edges_of(corners);
}

void cull_for_picture(Session& session, Culler& culler, const View& view, size_t frame)
{
    const Stage stage = session.stage();
    set_frame(stage, frame);
    std::vector<ItemId> owners;
    if (needs_answer(culler)) {
        const std::vector<ItemId> items = items_in_frustum(view, stage.item_bounds);
        owners = owners_of_pixels(stage.renderer.render_ids(view, items));
    }
    record_answer(culler, view, stage.renderer.device(), owners);
    culler.cull(view, stage.renderer.device());
}

Image draw_picture(Session& session, const Culler& culler, const Camera& camera, Show show,
                   const std::optional<Camera>& observer)
{
    const glm::ivec2 size = session.options().size;
    const View path_view = make_view(camera, size);
    const View view = observer ? make_view(*observer, size) : path_view;
    const std::vector<ItemId> hidden = hidden_in_frustum(session.stage(), culler, path_view);

    draw_items_for(session, culler, view, show, observer.has_value());
    if (show == Show::boxes) {
        draw_decided_boxes(session, culler, view);
    }
    Image image =
        observer ? with_frustum(session, view, path_view) : session.renderer().capture().color;
    if (show == Show::hidden) {
        shine_through(session, view, hidden, image);
    }
    return image;
}

} // namespace occlude::tools
