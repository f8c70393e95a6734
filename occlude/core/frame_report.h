// The result and the costs of one frame: plain counters that are always on, without clocks.
#pragma once

#include <cstdint>
#include <string>

namespace occlude {

/// How the image of a frame compares with the image of drawing everything in the frustum.
struct Guarantee {
    enum class Kind : uint8_t {
        exact,       ///< the same image, pixel by pixel
        latent,      ///< made from answers that are `frames` frames old: something may appear this
                     ///< many frames late
        approximate, ///< objects of up to `threshold` visible samples may be missing
    };
    Kind kind = Kind::exact;
    uint32_t frames = 0;
    uint64_t threshold = 0;

    /// As threshold: objects of any size may be missing.
    static constexpr uint64_t kAnySamples = ~uint64_t{0};

    static Guarantee exact() { return {}; }
    static Guarantee latent(uint32_t frames) { return {Kind::latent, frames, 0}; }
    static Guarantee approximate(uint64_t threshold) { return {Kind::approximate, 0, threshold}; }

    bool operator==(const Guarantee&) const = default;
};

/// "exact", "latent(1)", "approximate(20)", or "approximate" where anything may be missing.
std::string to_string(const Guarantee& guarantee);

struct FrameCounters {
    uint64_t nodes_visited = 0;       ///< nodes taken from the traversal queue
    uint64_t queries = 0;             ///< tests issued; a multiquery is one
    uint64_t boxes = 0;               ///< boxes in all tests
    uint64_t multiqueries = 0;        ///< tests over more than one node
    uint64_t multiqueries_failed = 0; ///< multiqueries that came back visible, so that their nodes
                                      ///< were tested again
    uint64_t batches = 0;             ///< calls of query()
    uint64_t state_changes = 0;       ///< switches between drawing and testing, both ways
    uint64_t draw_calls = 0;          ///< calls of draw() and draw_and_query()
    uint64_t items_drawn = 0;
    uint64_t triangles_drawn = 0;
    uint64_t waits = 0;        ///< calls of wait()
    uint64_t lost_answers = 0; ///< tests that the device could not answer: taken as visible
    uint64_t depth_reads = 0;  ///< calls of read_depth()
    uint64_t pixels_read = 0;
    uint64_t cells_asked = 0; ///< grid cells whose pixels were looked at

    FrameCounters& operator+=(const FrameCounters& other);
    bool operator==(const FrameCounters&) const = default;
};

/// Calls visit(name, value) for every counter, in a fixed order: the names of the JSON keys.
template <class Counters, class Visit>
void for_each_counter(Counters& c, Visit&& visit)
{
    visit("nodes_visited", c.nodes_visited);
    visit("queries", c.queries);
    visit("boxes", c.boxes);
    visit("multiqueries", c.multiqueries);
    visit("multiqueries_failed", c.multiqueries_failed);
    visit("batches", c.batches);
    visit("state_changes", c.state_changes);
    visit("draw_calls", c.draw_calls);
    visit("items_drawn", c.items_drawn);
    visit("triangles_drawn", c.triangles_drawn);
    visit("waits", c.waits);
    visit("lost_answers", c.lost_answers);
    visit("depth_reads", c.depth_reads);
    visit("pixels_read", c.pixels_read);
    visit("cells_asked", c.cells_asked);
}

/// The choice of an algorithm that chooses its way of testing in each frame, and the reason. The
/// times are its own estimates, in microseconds.
struct FramePlan {
    enum class Kind : uint8_t {
        fixed,    ///< the algorithm does not choose
        draw_all, ///< frustum culling only
        queries,  ///< tested by occlusion queries
        raster,   ///< tested by boxes rasterised into flags
        pyramid,  ///< tested on the CPU against depth that was read back
    };
    enum class Reason : uint8_t {
        none,
        first_look,       ///< nothing is known yet: draws near to far and tests what lies behind
        saves,            ///< the hidden nodes cost more to draw than to test
        saves_too_little, ///< they cost less, so everything is drawn
        probe,            ///< everything is drawn; a probe at the end of the frame measured what
                          ///< tests would hide
        no_tests,         ///< the device cannot test
        chosen,           ///< an option prescribes it
        useless_clock,    ///< the clock stands still or is coarse, so the device's hints decide
    };
    Kind kind = Kind::fixed;
    Reason reason = Reason::none;
    float drawn_us = 0.0f; ///< cost of the drawing
    float saved_us = 0.0f; ///< cost of drawing what was found hidden
    float spent_us = 0.0f; ///< cost of the tests

    bool operator==(const FramePlan&) const = default;
};

/// One line: "pyramid (pays): hides 12.30 ms of drawing at 0.61 ms, draws 2.90 ms". Empty for a
/// fixed plan.
std::string to_string(const FramePlan& plan);
/// "draw_all", "queries", ...: one word.
const char* name(FramePlan::Kind kind);

struct FrameReport {
    uint64_t frame = 0; ///< counts the cull() calls of this culler since it was made or reset
    Guarantee guarantee;
    FramePlan plan;
    FrameCounters counters;
};

} // namespace occlude
