// The costs of work on the running device, measured while frames are made. `adaptive` decides by
// these numbers.
//
// Implements  the measured constants of M. Guthe, A. Balazs, R. Klein, "Near Optimal Hierarchical
//             Culling: Performance Driven Use of Hardware Occlusion Queries", EGSR 2006: the cost
//             of drawing and the cost of testing.
// Deviations  The paper measures once, at start-up, with drawings of its own. Here the frames
//             themselves are timed, between moments at which the device is idle: after a read-back,
//             or when an awaited answer arrives. That is the time a frame waits for, and it follows
//             machines whose speed drifts. Timer queries would leave out the work of the CPU, which
//             on software devices is all work. The cost of drawing is learnt as a slope, the time
//             of one more unit, because pixels cost the same whatever is hidden. Each test method
//             has three measured costs (RoundCost).
// Guarantees  Every figure is a median of recent samples, so that one disturbed frame changes
//             nothing. Without a clock there are no samples, and the hints of DeviceCaps stay:
//             decisions are then the same in every run.
#pragma once

#include <occlude/core/query_device.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace occlude {

/// The median of the last five samples, or of all if there are fewer. Of an even number of samples,
/// it is the lower of the two in the middle. One disturbed sample changes nothing.
class RecentMedian {
public:
    void add(double sample);
    bool empty() const { return count_ == 0; }
    size_t count() const { return count_; } ///< of all samples so far
    /// Precondition: not empty.
    double value() const;

private:
    static constexpr size_t kSamples = 5;
    std::array<double, kSamples> samples_{};
    size_t count_ = 0;
};

/// The cost of one round of tests by one method, in microseconds: `us_per_round` for starting the
/// device and waiting for it, `us_per_test` for each test of one box, and `us_per_box` for each
/// further box that shares a test.
struct RoundCost {
    double us_per_round = 0.0;
    double us_per_test = 0.0;
    double us_per_box = 0.0;

    double of(double tests) const { return us_per_round + tests * us_per_test; }
    double of(double tests, double boxes) const { return of(tests) + (boxes - tests) * us_per_box; }
};

class CostModel {
public:
    /// Starts from the device's hints; hints of read-backs hold for a target of `size_px`. Keeps
    /// the measurements if the hints are the same as at the last call.
    void take_hints(const DeviceCaps& caps, glm::ivec2 size_px = glm::ivec2{0});
    /// Sets the costs back to the hints.
    void forget_measurements();

    // --- drawing ---

    /// The work of drawing, in units: a triangle is one, and an item counts as the number of
    /// triangles that the device's hints say it costs.
    double units(uint64_t triangles, uint64_t items) const
    {
        return static_cast<double>(triangles) + triangles_per_item_ * static_cast<double>(items);
    }
    double us_per_unit() const { return us_per_unit_; }

    /// Records that drawing `units`, with their pixels, took `us` from idle to idle. Ignores fewer
    /// than `kMinSampleUnits`.
    void record_drawing(double units, double us);
    /// The expected time of drawing `units`, with their pixels: by the slope, but at least the
    /// longest time of a frame that drew as many units or fewer.
    double whole_us(double units) const;

    // --- testing ---

    /// The cost of a round by `method`; infinite for a method that the device does not have.
    RoundCost round(TestMethod method) const;
    bool has(TestMethod method) const { return methods_[index(method)].available; }

    /// Records that a round of `tests` of `boxes` by `method` took `us` on an idle device. A round
    /// of one box by TestMethod::pyramid is a read-back in tiles of tile_px().
    void record_round(TestMethod method, size_t tests, size_t boxes, double us);
    /// The next round to be timed: it measures the least measured cost of `method`. It has no tests
    /// once each cost was measured three times, or if the device does not have the method.
    struct RoundSize {
        size_t tests = 0;
        size_t boxes = 0;
    };
    RoundSize least_known(TestMethod method) const;
    // --- read-backs: a round of TestMethod::pyramid begins with one ---

    /// The side of the tiles in which depth is to be read; 1 for pixels.
    int tile_px() const { return reads_[read_].tile_px; }
    /// Chooses the cheapest tiles for a frame whose drawing takes `drawn_us`: coarser tiles are
    /// read faster and hide less. If pixels were measured, only measured sizes are chosen.
    void choose_tile(double drawn_us);
    /// The tiles whose read-back is to be measured next: pixels first, then sizes that may cost
    /// less by their hints. 0: all are measured.
    int unmeasured_tile_px() const;
    /// Records that one read-back of the whole target in such tiles took `us` on an idle device.
    void record_read(int tile_px, double us);

    /// The cost of a round by `method` according to the device's hints.
    RoundCost hint(TestMethod method) const { return methods_[index(method)].hint; }
    /// How many rounds of a single test were recorded.
    size_t rounds_measured(TestMethod method) const { return small_round_us(method).count(); }

    /// True if some of its costs were measured, but not all.
    bool partly_known(TestMethod method) const
    {
        return rounds_measured(method) > 0 && least_known(method).tests > 0;
    }

private:
    struct Method {
        bool available = false;
        RoundCost hint;
        RecentMedian small_round_us; ///< of one test of one box
        RecentMedian us_per_test;    ///< of each further test
        RecentMedian us_per_box;     ///< of each further box in one test
    };
    /// One size of tiles.
    struct Read {
        int tile_px = 1;
        double undrawn_share = 0.0; ///< the share of a frame's drawing that such tiles fail to
                                    ///< hide, an estimate
        bool available = false;
        double hint_us = 0.0;
        RecentMedian us = {};

        double cost_us() const { return us.empty() ? hint_us : us.value(); }
    };
    void take_read_hints(const DeviceCaps& caps, glm::ivec2 size_px);
    const RecentMedian& small_round_us(TestMethod method) const
    {
        return method == TestMethod::pyramid ? reads_[read_].us
                                             : methods_[index(method)].small_round_us;
    }
    /// Frames that drew about the same number of units.
    struct Sample {
        RecentMedian units;
        RecentMedian us = {};
    };
    static size_t index(TestMethod method) { return static_cast<size_t>(method); }

    std::array<Method, 4> methods_{};
    std::array<Read, 3> reads_{Read{1, 0.0}, Read{8, 0.04}, Read{16, 0.08}};
    size_t read_ = 0; ///< index of the tiles in use
    double triangles_per_item_ = 0.0;
    double us_per_unit_ = 0.0;
    static constexpr size_t kSizeClasses = 40;
    static size_t size_class(double units);    ///< the binary logarithm
    std::array<Sample, kSizeClasses> drawn_{}; ///< by size class
    float hint_us_per_triangle_ = -1.0f;
    float hint_us_per_item_ = -1.0f;
};

} // namespace occlude
