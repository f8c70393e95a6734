#include <occlude/effects/flare_visibility.h>

#include <occlude/core/detail/view_math.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

namespace occlude {

namespace {

constexpr float kSmallestRadius = 0.75f; // a circle of sqrt(1/2) holds a pixel centre anywhere
// Window depth of lights at infinity, measured from the far end: behind all geometry, and still
// before the far plane in a float or 24-bit depth buffer.
constexpr double kBehindAll = 0x1p-22;

// The place of a light: on the screen in pixels, and in depth as the value of one row of the
// matrix.
struct Place {
    glm::dvec2 center_px{0.0};
    double depth = 0.0; ///< clip w, or clip z when orthographic
};

// Normalised depth just before the far end.
double farthest_ndc(ClipConvention convention)
{
    const bool reversed = convention.order == DepthOrder::near_is_large;
    const double low = convention.range == DepthRange::minus_one_to_one ? -1.0 : 0.0;
    const double inward = kBehindAll * (1.0 - low);
    return reversed ? low + inward : 1.0 - inward;
}

// Relative to the view's origin, because float would not suffice far from the world's.
glm::dvec3 relative_position(const View& view, const glm::vec4& position)
{
    return glm::dvec3{position} / double{position.w} - view.origin();
}

// The eye, relative to the view's origin. Precondition: a perspective.
glm::dvec3 relative_eye(const View& view)
{
    const glm::dmat4 rows = glm::transpose(view.clip_from_relative());
    const glm::dvec4 zero = detail::common_zero(rows[0], rows[1], rows[3]);
    return glm::dvec3{zero} / zero.w;
}

std::optional<Place> place_perspective(const View& view, const glm::vec4& position)
{
    const glm::dmat4& clip_from_relative = view.clip_from_relative();
    const glm::dvec3 eye = relative_eye(view);
    const glm::dvec3 toward =
        position.w != 0.0f ? relative_position(view, position) - eye : glm::dvec3{position};
    // clip = at_eye + t * step
    const glm::dvec4 step = clip_from_relative * glm::dvec4{toward, 0.0};
    if (!(step.w > 0.0)) {
        return std::nullopt;
    }
    // z / w falls toward or from step.z / step.w with 1 / t: solved for the farthest depth.
    const double z_eye = (clip_from_relative * glm::dvec4{eye, 1.0}).z;
    const double t_far = z_eye / (step.w * farthest_ndc(view.convention()) - step.z);
    const double t_light = position.w != 0.0f ? 1.0 : Aabb::kInfinity;
    const double t = t_far > 0.0 ? std::min(t_far, t_light) : t_light;
    if (!std::isfinite(t)) {
        return std::nullopt;
    }
    const glm::dvec2 size{view.size_px()};
    return Place{(glm::dvec2{step} / step.w * 0.5 + 0.5) * size, t * step.w};
}

std::optional<Place> place_orthographic(const View& view, const glm::vec4& position)
{
    if (position.w == 0.0f) {
        return std::nullopt;
    }
    const glm::dvec4 clip =
        view.clip_from_relative() * glm::dvec4{relative_position(view, position), 1.0};
    const double farthest = farthest_ndc(view.convention());
    const bool reversed = view.convention().order == DepthOrder::near_is_large;
    const glm::dvec2 size{view.size_px()};
    return Place{(glm::dvec2{clip} / clip.w * 0.5 + 0.5) * size,
                 reversed ? std::max(clip.z, farthest * clip.w)
                          : std::min(clip.z, farthest * clip.w)};
}

// The affine map from pixels around `place` to its plane of constant depth: three rows of the
// matrix, solved for the point.
glm::mat4 world_from_pixels(const View& view, const Place& place)
{
    const glm::dmat4 rows = glm::transpose(view.clip_from_relative());
    const glm::dvec4 depth_row = view.orthographic() ? rows[2] : rows[3];
    const double w = view.orthographic() ? rows[3].w : place.depth;
    const glm::dmat3 world_from_rows = glm::inverse(glm::transpose(
        glm::dmat3{glm::dvec3{rows[0]}, glm::dvec3{rows[1]}, glm::dvec3{depth_row}}));
    const glm::dvec2 size{view.size_px()};
    const glm::dvec2 ndc = place.center_px / size * 2.0 - 1.0;
    const glm::dvec3 across = world_from_rows[0] * (w * 2.0 / size.x);
    const glm::dvec3 up = world_from_rows[1] * (w * 2.0 / size.y);
    const glm::dvec3 center =
        world_from_rows *
        glm::dvec3{ndc.x * w - rows[0].w, ndc.y * w - rows[1].w, place.depth - depth_row.w};
    const glm::dvec3 normal = glm::cross(across, up);
    return glm::mat4{glm::vec4{glm::vec3{across}, 0.0f}, glm::vec4{glm::vec3{up}, 0.0f},
                     glm::vec4{glm::vec3{glm::normalize(normal)}, 0.0f},
                     glm::vec4{glm::vec3{center + view.origin()}, 1.0f}};
}

// The number of pixel centres in [low, high].
double centers_between(double low, double high)
{
    return std::max(std::floor(high - 0.5) - std::ceil(low - 0.5) + 1.0, 0.0);
}

} // namespace

float flare_radius_px(const View& view, const glm::vec3& position_world, float radius_world,
                      float smallest, float largest)
{
    OCCLUDE_ASSERT(radius_world >= 0.0f, "the radius of a light's ball must not be negative");
    OCCLUDE_ASSERT(smallest <= largest, "the smallest radius of a flare is above its largest");
    const glm::dmat4 rows = glm::transpose(view.clip_from_relative());
    const double w = glm::dot(rows[3], glm::dvec4{glm::dvec3{position_world} - view.origin(), 1.0});
    if (!(w > 0.0)) {
        return smallest;
    }
    const double pixels_per_unit = 0.5 * view.size_px().y * glm::length(glm::dvec3{rows[1]}) / w;
    const auto radius_px = static_cast<float>(radius_world * pixels_per_unit);
    return std::max(std::min(radius_px, largest), smallest);
}

FlareDisc make_flare_disc(const View& view, const FlareLight& light)
{
    OCCLUDE_ASSERT(light.position_world.w >= 0.0f, "the w of a light is 1, or 0 at infinity");
    FlareDisc disc;
    if (view.size_px().x <= 0 || view.size_px().y <= 0) {
        return disc;
    }
    const auto place = view.orthographic() ? place_orthographic(view, light.position_world)
                                           : place_perspective(view, light.position_world);
    const double radius = std::max(light.radius_px, kSmallestRadius);
    const glm::dvec2 size{view.size_px()};
    const bool near_screen = place &&
                             std::abs(place->center_px.x - 0.5 * size.x) <= 0.5 * size.x + radius &&
                             std::abs(place->center_px.y - 0.5 * size.y) <= 0.5 * size.y + radius;
    if (!near_screen) {
        return disc;
    }
    const glm::mat4 world_from_disc = world_from_pixels(view, *place);
    if (!transformed(world_from_disc, {glm::vec3{0.0f}, glm::vec3{1.0f}}).is_bounded()) {
        return disc; // a view of which nothing is known
    }
    disc.world_from_disc = world_from_disc;

    const glm::dvec2 center = place->center_px;
    const double first_row = std::floor(center.y - radius);
    const double row_count = std::ceil(center.y + radius) - first_row;
    const double height = std::ceil(row_count / kMaxFlareStrips);
    double all_pixels = 0.0;
    double pixels_on_screen = 0.0;
    for (double row = first_row; row < first_row + row_count; row += height) {
        const double y = row + 0.5 * height - center.y; // of its middle, from the centre
        const double half_squared = radius * radius - y * y;
        if (half_squared <= 0.0) {
            continue;
        }
        const double half = std::sqrt(half_squared);
        const glm::dvec2 low{center.x - half, row};
        const glm::dvec2 high{center.x + half, row + height};
        const glm::dvec2 low_on_screen = glm::max(low, glm::dvec2{0.0});
        const glm::dvec2 high_on_screen = glm::min(high, size);
        all_pixels += centers_between(low.x, high.x) * centers_between(low.y, high.y);
        const double on_screen = centers_between(low_on_screen.x, high_on_screen.x) *
                                 centers_between(low_on_screen.y, high_on_screen.y);
        if (on_screen > 0.0) {
            pixels_on_screen += on_screen;
            disc.strips.push_back({glm::vec3{glm::vec2{low_on_screen - center}, 0.0f},
                                   glm::vec3{glm::vec2{high_on_screen - center}, 0.0f}});
        }
    }
    disc.on_screen = all_pixels > 0.0 ? pixels_on_screen / all_pixels : 0.0;
    for (const Aabb& strip : disc.strips) {
        disc.touches_near =
            disc.touches_near || view.touches_near(transformed(disc.world_from_disc, strip));
    }
    return disc;
}

void FlareVisibility::set_lights(std::span<const FlareLight> lights)
{
    lights_.resize(lights.size());
    for (size_t i = 0; i < lights.size(); ++i) {
        lights_[i].light = lights[i];
    }
}

void FlareVisibility::reset()
{
    for (Light& light : lights_) {
        light = {.light = light.light};
    }
    for (Measurement& measurement : measurements_) {
        measurement.disc.on_screen = -1.0; // pending, but not needed any more
    }
}

void FlareVisibility::finish_measurement(Light& light, const Measurement& measurement) const
{
    const FlareDisc& disc = measurement.disc;
    if (disc.on_screen < 0.0) {
        return;
    }
    double seen = 1.0; // of what is on the screen
    if (measurement.issued) {
        const Answer& test = measurement.test_answer;
        const Answer& reference = measurement.reference_answer;
        if (test.state != AnswerState::ready || reference.state != AnswerState::ready) {
            return; // no new information
        }
        seen = reference.samples == 0
                   ? 0.0
                   : static_cast<double>(test.samples) / static_cast<double>(reference.samples);
    }
    light.fraction = std::min(seen, 1.0) * disc.on_screen;
    if (!light.measured) {
        light.measured = true;
        light.brightness = light.fraction;
    }
}

// Reads the answers that have arrived. Uses all of a frame or none, so that lights agree.
void FlareVisibility::collect(QueryDevice& device)
{
    const bool waits = frame_ + 1 - issued_frame_ >= options_.max_latency;
    const auto read = [&](Ticket ticket, Answer& answer) {
        if (answer.state == AnswerState::pending) {
            answer = waits ? device.wait(ticket) : device.poll(ticket);
        }
        return answer.state != AnswerState::pending;
    };
    bool complete = true;
    for (Measurement& m : measurements_) {
        if (m.issued) {
            const bool reference_read = read(m.reference, m.reference_answer);
            const bool test_read = read(m.test, m.test_answer);
            complete = complete && reference_read && test_read;
        }
    }
    if (!complete) {
        return;
    }
    for (size_t i = 0; i < std::min(measurements_.size(), lights_.size()); ++i) {
        finish_measurement(lights_[i], measurements_[i]);
    }
    measurements_.clear();
}

void FlareVisibility::fade(double elapsed)
{
    const double share =
        options_.fade_time > 0.0 ? 1.0 - std::exp(-elapsed / options_.fade_time) : 1.0;
    for (Light& light : lights_) {
        light.brightness += (light.fraction - light.brightness) * share;
    }
}

// Issues one test per light that needs one. False if no light does.
bool FlareVisibility::collect_boxes()
{
    boxes_.clear();
    ends_.clear();
    for (Measurement& m : measurements_) {
        m.issued = !m.disc.strips.empty() && !m.disc.touches_near;
        if (m.issued) {
            for (const Aabb& strip : m.disc.strips) {
                boxes_.push_back({strip, &m.disc.world_from_disc, NodeId{}});
            }
            ends_.push_back(static_cast<uint32_t>(boxes_.size()));
        }
    }
    return !ends_.empty();
}

void FlareVisibility::issue(QueryDevice& device, Ticket Measurement::*ticket)
{
    tickets_.resize(ends_.size());
    device.query({boxes_, ends_, TestMethod::automatic}, tickets_);
    device.flush();
    size_t next = 0;
    for (Measurement& m : measurements_) {
        if (m.issued) {
            m.*ticket = tickets_[next++];
        }
    }
}

void FlareVisibility::begin_frame(const View& view, QueryDevice& device)
{
    in_frame_ = true;
    const double now = options_.clock ? options_.clock() : static_cast<double>(frame_);
    collect(device);
    fade(frame_ > 0 ? std::max(now - last_time_, 0.0) : 0.0);
    last_time_ = now;
    ++frame_;

    measures_this_frame_ = measurements_.empty() && !lights_.empty();
    if (!measures_this_frame_) {
        return; // the last answers are still pending
    }
    issued_frame_ = frame_;
    for (const Light& light : lights_) {
        measurements_.push_back({.disc = make_flare_disc(view, light.light)});
    }
    if (collect_boxes()) {
        issue(device, &Measurement::reference);
    }
}

void FlareVisibility::end_frame(QueryDevice& device)
{
    OCCLUDE_ASSERT(in_frame_, "FlareVisibility::end_frame follows its begin_frame");
    in_frame_ = false;
    if (measures_this_frame_ && !ends_.empty()) {
        issue(device, &Measurement::test);
    }
    measures_this_frame_ = false;
}

} // namespace occlude
