#include <occlude/cull/adaptive/cost_meter.h>

#include <algorithm>

namespace occlude {

void CostMeter::start_frame(const DeviceCaps& caps, glm::ivec2 size_px, double units)
{
    costs_.take_hints(caps, size_px);
    costs_.choose_tile(costs_.us_per_unit() * units);
    spent_us_ = 0.0;
    tests_ = 0.0;
    tried_ = false;
}

void CostMeter::check_clock(double from_us, double to_us)
{
    if (!has_clock() || to_us > from_us) {
        return;
    }
    ++zero_times_;
    if (zero_times_ == kMaxZeroTimes) {
        costs_.forget_measurements();
    }
}

void CostMeter::note_drawing(double units, double us)
{
    if (has_clock()) {
        costs_.record_drawing(units, std::max(us, 0.0));
    }
}

void CostMeter::note_read(int tile_px, double us)
{
    if (has_clock()) {
        costs_.record_read(tile_px, us);
    }
}

void CostMeter::note_round(TestMethod method, size_t tests, size_t boxes, double us)
{
    if (has_clock()) {
        costs_.record_round(method, tests, boxes, us);
    }
}

} // namespace occlude
