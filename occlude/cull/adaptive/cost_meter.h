// The clock of `adaptive`: what the device's work takes, and what a frame has spent on tests so
// far. Without a clock nothing is measured, and costs stay what the device's hints say.
//
// A clock that stands still while a frame is made, or that ticks only every few milliseconds, would
// teach that everything is free. Its zeros give it away: work that the device is waited for takes
// longer than a tick of any clock that can measure it. After kMaxZeroTimes such zeros the clock is
// not asked any more, and what it taught is forgotten.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/core/query_device.h>
#include <occlude/cull/parts/cost_model.h>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace occlude {

class CostMeter {
public:
    explicit CostMeter(SecondsClock clock)
        : clock_(std::move(clock))
    {
    }

    /// Takes the device's hints, for a target of `size_px`. What was measured stays. The frame is
    /// expected to draw `units`.
    void start_frame(const DeviceCaps& caps, glm::ivec2 size_px = glm::ivec2{0},
                     double units = 0.0);

    const CostModel& costs() const { return costs_; }

    // --- the clock ---

    bool has_clock() const { return clock_ && zero_times_ < kMaxZeroTimes; }
    /// There is a clock, but it cannot measure the device's work.
    bool clock_is_useless() const { return clock_ && zero_times_ >= kMaxZeroTimes; }
    /// The clock, or null.
    const SecondsClock* clock() const { return has_clock() ? &clock_ : nullptr; }
    /// Gives a useless clock another chance.
    void trust_clock() { zero_times_ = 0; }
    /// Microseconds; 0 without a clock.
    double now_us() const
    {
        constexpr double kUsPerSecond = 1e6;
        return has_clock() ? kUsPerSecond * clock_() : 0.0;
    }
    /// The device was waited for from one moment to the other: did the clock move?
    void check_clock(double from_us, double to_us);

    // --- what work took, from idle to idle; ignored without a clock ---

    /// Drawing of `units`. A negative time counts as 0.
    void note_drawing(double units, double us);
    /// A round of tests, as CostModel::record_round().
    void note_round(TestMethod method, size_t tests, size_t boxes, double us);

    /// One read-back in tiles of this size.
    void note_read(int tile_px, double us);

    // --- this frame ---

    /// What it has spent on tests, and how many there were.
    void spend(double us, double tests)
    {
        spent_us_ += us;
        tests_ += tests;
    }
    double spent_us() const { return spent_us_; }
    double tests() const { return tests_; }

    /// A frame pays for one trial of what a method costs at most: false after note_trial().
    bool may_try() const { return has_clock() && !tried_; }
    void note_trial() { tried_ = true; }

private:
    static constexpr uint32_t kMaxZeroTimes = 3;

    SecondsClock clock_;
    CostModel costs_;
    uint32_t zero_times_ = 0;
    double spent_us_ = 0.0;
    double tests_ = 0.0;
    bool tried_ = false;
};

} // namespace occlude
