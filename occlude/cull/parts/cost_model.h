// What work costs on the running device, measured while frames are made: the numbers that
// `adaptive` decides by.
//
// Implements  the measured constants of M. Guthe, A. Balazs, R. Klein, "Near Optimal Hierarchical
//             Culling: Performance Driven Use of Hardware Occlusion Queries", EGSR 2006: what it
//             costs to draw and what it costs to test.
// Deviations  The paper measures once, at start-up, with drawings of its own. Here the frames
//             themselves are timed, from one moment at which the device is idle to the next (a
//             read-back or an awaited answer is such a moment), because that is the time a frame
//             waits for, and because machines drift. Timer queries would leave out what the
//             processor does, which on software devices is everything. What is learnt of drawing is
//             a slope, the cost of one unit more (a triangle, or an item as so many triangles): a
//             frame costs what its pixels cost whatever is hidden. Of each test method three
//             numbers are learnt.
// Guarantees  Noise: every figure comes from medians of recent samples. Without a clock no sample
//             ever comes, and the hints of DeviceCaps stay: decisions are then the same in every
//             run.
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/core/query_device.h>
#include <occlude/hierarchy/hierarchy.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace occlude {

/// The median of the last few samples, the lower one of two: one disturbed sample changes nothing.
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

/// What one round of tests by one method costs: `us_per_round` whatever is asked, starting the
/// device and waiting for it included, `us_per_test` for each test of one box, and `us_per_box` for
/// each box more that shares a test.
struct RoundCost {
    double us_per_round = 0.0;
    double us_per_test = 0.0;
    double us_per_box = 0.0;

    double of(double tests) const { return us_per_round + tests * us_per_test; }
    double of(double tests, double boxes) const { return of(tests) + (boxes - tests) * us_per_box; }
};

class CostModel {
public:
    /// Starts from the device's hints. Keeps what was measured if they are the hints it had.
    void take_hints(const DeviceCaps& caps);

    // --- drawing ---

    /// The work of drawing, in triangles: an item counts as so many.
    double units(uint64_t triangles, uint64_t items) const
    {
        return static_cast<double>(triangles) + triangles_per_item_ * static_cast<double>(items);
    }
    double units(const Node& node) const
    {
        return units(node.subtree_triangles, node.subtree_items);
    }
    /// What has been drawn of a frame.
    double units(const FrameCounters& counters) const
    {
        return units(counters.triangles_drawn, counters.items_drawn);
    }
    double us_per_unit() const { return us_per_unit_; }
    double draw_us(const Node& node) const { return us_per_unit_ * units(node); }

    /// `units` were drawn in `us`, from idle to idle, pixels and all. A little says nothing and is
    /// left out.
    void drew(double units, double us);
    /// What drawing so much takes, pixels and all: by the slope, or what so much or less has taken.
    double whole_us(double units) const;

    // --- testing ---

    /// The cost of a round by `method`; infinite for a method that the device does not have.
    RoundCost round(TestMethod method) const;
    bool has(TestMethod method) const { return methods_[index(method)].available; }

    /// A round of `tests` of `boxes` by `method` on an idle device took `us`.
    void tested(TestMethod method, size_t tests, size_t boxes, double us);
    /// The round that would tell what is known least of `method`: so many tests of so many boxes.
    /// None once each of its costs was measured a few times, or if the device does not have it.
    struct Shape {
        size_t tests = 0;
        size_t boxes = 0;
    };
    Shape least_known(TestMethod method) const;
    /// What the device says of it.
    RoundCost hint(TestMethod method) const { return methods_[index(method)].hint; }
    /// Rounds of a single test that tested() has heard of.
    size_t rounds_measured(TestMethod method) const
    {
        return methods_[index(method)].small_round_us.count();
    }

    /// Something of it was measured, but not all.
    bool half_known(TestMethod method) const
    {
        return rounds_measured(method) > 0 && least_known(method).tests > 0;
    }

private:
    struct Method {
        bool available = false;
        RoundCost hint;
        RecentMedian small_round_us; ///< of one test of one box
        RecentMedian us_per_test;    ///< what more tests took beyond that
        RecentMedian us_per_box;     ///< ... and more boxes in one test
    };
    /// What frames of about the same amount of drawing took.
    struct Sample {
        RecentMedian units;
        RecentMedian us;
    };
    static size_t index(TestMethod method) { return static_cast<size_t>(method); }

    std::array<Method, 4> methods_{};
    double triangles_per_item_ = 0.0;
    double us_per_unit_ = 0.0;
    static constexpr size_t kSizes = 40;
    static size_t size_of(double units);
    std::array<Sample, kSizes> drawn_{}; ///< by the binary logarithm of the units
    float hint_us_per_triangle_ = -1.0f;
    float hint_us_per_item_ = -1.0f;
};

} // namespace occlude
