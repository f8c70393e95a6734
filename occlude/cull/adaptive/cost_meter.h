// The clock of `adaptive`: times the device's work, and adds up what a frame spends on tests.
// Without a clock nothing is measured, and costs stay at the device's hints.
//
// A clock that stands still during a frame, or ticks only every few milliseconds, would make every
// cost 0. Its zeros give it away: a wait for the device takes longer than one tick of any useful
// clock. After kMaxZeroTimes such zeros the clock is ignored, and the costs that it taught are
// forgotten.
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

    /// Takes the device's hints for a target of `size_px`, and keeps what was measured. `units`:
    /// the work that the frame is expected to draw.
    void start_frame(const DeviceCaps& caps, glm::ivec2 size_px = glm::ivec2{0},
                     double units = 0.0);

    const CostModel& costs() const { return costs_; }

    // --- the clock ---

    bool has_clock() const { return clock_ && zero_times_ < kMaxZeroTimes; }
    /// True if there is a clock, but it cannot measure the device's work.
    bool clock_is_useless() const { return clock_ && zero_times_ >= kMaxZeroTimes; }
    /// The clock, or null if there is none or it is useless.
    const SecondsClock* clock() const { return has_clock() ? &clock_ : nullptr; }
    /// Gives a useless clock another chance.
    void trust_clock() { zero_times_ = 0; }
    /// The time in microseconds; 0 without a clock.
    double now_us() const
    {
        constexpr double kUsPerSecond = 1e6;
        return has_clock() ? kUsPerSecond * clock_() : 0.0;
    }
    /// Checks the clock: the device was waited for between these two times, so they must differ.
    void check_clock(double from_us, double to_us);

    // --- measured times, from idle to idle; ignored without a clock ---

    /// Records that drawing `units` took `us`. A negative time counts as 0.
    void note_drawing(double units, double us);
    /// Records a round of tests; see CostModel::record_round().
    void note_round(TestMethod method, size_t tests, size_t boxes, double us);

    /// Records one read-back in tiles of `tile_px`.
    void note_read(int tile_px, double us);

    // --- what this frame spends on tests ---

    /// Adds the time and the number of tests.
    void spend(double us, double tests)
    {
        spent_us_ += us;
        tests_ += tests;
    }
    double spent_us() const { return spent_us_; }
    double tests() const { return tests_; }

    /// True until note_trial() if there is a clock: a frame pays for one trial of a method.
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
