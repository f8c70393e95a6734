// The visible share of a light, for the brightness of its lens flare.
//
// Implements  D. Sekulic, "Efficient Occlusion Culling", GPU Gems, 2004, section 29.8.2: a block of
//             pixels at the place and depth of the light, tested against the depth buffer, and
//             the fraction that passed, read in the next frame.
// Map         "render a block of pixels"         -> make_flare_disc, FlareVisibility::end_frame
//             "read its result in the next one"  -> FlareVisibility::begin_frame
//             "modulate the brightness"          -> FlareVisibility::brightness
// Deviations  The block is a disc, cut into strips of one pixel row each, so that its pixels are
//             those whose centres lie in the disc. The number that passes is divided by the count
//             of the same strips before anything is drawn, not by a number of pixels: devices count
//             flat boxes twice or samples several times, and the ratio is right for all of them.
//             The part of the disc outside the screen counts as hidden, like the pixels in the
//             chapter that are not rendered: a flare fades out while its light leaves the screen,
//             and does not pop.
// Guarantees  fraction() is the share of the disc's pixels that were nearer than everything drawn
//             when the tests were issued, one frame before; with multisampling, the share of its
//             samples on the screen. Devices without exact counts (DeviceCaps::exact_counts) answer
//             all or nothing: then the smoothing does the fading.
// Cost        two tests per light that is on the screen, in two batches per frame, with one box per
//             row of pixels.
//             row of pixels.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/core/query_device.h>
#include <occlude/core/view.h>

#include <functional>
#include <span>
#include <vector>

namespace occlude {

struct FlareLight {
    /// w = 1: a place in the world. w = 0: a direction toward a light at infinity, such as the sun,
    /// which lies behind everything. (In orthographic views such a light is never visible.)
    glm::vec4 position_world{0.0f, 0.0f, 0.0f, 1.0f};
    float radius_px = 8.0f; ///< radius of the disc in pixels; clamped to at least 0.75, so that it
                            ///< covers a pixel
};

/// The radius in pixels of a ball of `radius_world` at `position_world`, at least `smallest` and at
/// most `largest` >= smallest: "the number of pixels to test can be determined from the size on
/// screen".
float flare_radius_px(const View& view, const glm::vec3& position_world, float radius_world,
                      float smallest, float largest);

/// A light's disc on the screen, as boxes in a plane through the light and parallel to the screen.
struct FlareDisc {
    glm::mat4 world_from_disc{1.0f}; ///< pixels relative to the disc's centre -> world; z is 0
    std::vector<Aabb> strips;        ///< flat, disjoint, clipped at the edge of the screen
    double on_screen = 0.0;          ///< the share of the disc's pixels that are on the screen
    bool touches_near = false;       ///< it must not be tested, because nothing can stand before it
};

/// The disc of a light; without strips if it is behind the eye or outside the screen. At most
/// kMaxFlareStrips strips, so that strips of larger discs are several pixels high.
FlareDisc make_flare_disc(const View& view, const FlareLight& light);
constexpr int kMaxFlareStrips = 64;

struct FlareOptions {
    /// The time in which brightness() goes 63% of the way to a new fraction(), in units of `clock`.
    /// 0: at once.
    double fade_time = 2.0;
    /// Any ascending number; by default it counts frames.
    std::function<double()> clock = {};
    /// An answer that has not arrived after this many frames is waited for.
    uint32_t max_latency = 3;
};

/// Measures several lights at once. Within the frame of an engine that draws by itself:
///
///   device.begin_frame(view);
///   flares.begin_frame(view, device);   // answers of the last frame; reference counts
///   ... all opaque draws ...
///   flares.end_frame(device);           // the tests of this frame
///   device.end_frame();
///
/// A Culler has the whole frame to itself: give it a FlareDevice (device/flare_device.h).
class FlareVisibility {
public:
    explicit FlareVisibility(FlareOptions options = {})
        : options_(std::move(options))
    {
        OCCLUDE_ASSERT(options_.fade_time >= 0.0, "the fade_time of flares must not be negative");
    }

    /// Sets the lights from the next frame on. Light i continues the fading of the former light i,
    /// so keep their order. New lights are dark until their first answer.
    void set_lights(std::span<const FlareLight> lights);

    void begin_frame(const View& view, QueryDevice& device);
    /// Precondition: begin_frame() was called for this frame; else nothing is tested.
    void end_frame(QueryDevice& device);

    /// Forgets all answers: for a camera cut. All lights are dark, and the first answer takes
    /// effect at once.
    void reset();

    size_t light_count() const { return lights_.size(); }
    /// The visible share of the light's disc, 0 to 1, in the last frame that was answered.
    /// Precondition for both: light < light_count(); else 0.
    double fraction(size_t light) const { return is_light(light) ? lights_[light].fraction : 0.0; }
    /// The same, smoothed; after the first answer it never jumps.
    double brightness(size_t light) const
    {
        return is_light(light) ? lights_[light].brightness : 0.0;
    }

private:
    bool is_light(size_t light) const
    {
        OCCLUDE_ASSERT(light < lights_.size(), "FlareVisibility has no light of this number");
        return light < lights_.size();
    }

    struct Light {
        FlareLight light = {};
        double fraction = 0.0;
        double brightness = 0.0;
        bool measured = false;
    };
    /// The pending tests of one light.
    struct Measurement {
        FlareDisc disc = {};
        Ticket reference = {};
        Ticket test = {};
        Answer reference_answer = Answer::pending();
        Answer test_answer = Answer::pending();
        bool issued = false; ///< has tickets
    };

    void collect(QueryDevice& device);
    void finish_measurement(Light& light, const Measurement& measurement) const;
    void fade(double elapsed);
    bool collect_boxes();
    void issue(QueryDevice& device, Ticket Measurement::*ticket);

    FlareOptions options_;
    std::vector<Light> lights_;
    std::vector<Measurement> measurements_; ///< by light; empty if nothing is pending
    std::vector<QueryBox> boxes_;
    std::vector<uint32_t> ends_;
    std::vector<Ticket> tickets_;
    uint64_t frame_ = 0;
    uint64_t issued_frame_ = 0;
    double last_time_ = 0.0;
    bool in_frame_ = false;
    bool measures_this_frame_ = false;
};

} // namespace occlude
