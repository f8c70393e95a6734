#include <occlude/cull/cost_model.h>

#include <limits>

namespace occlude {

namespace {

// What a read-back and a test against it cost before anything was measured.
constexpr RoundCost kPyramidHint{400.0, 0.1};

// How much of the past one more sample leaves.
constexpr double kDecay = 0.9;

} // namespace

void RecentMedian::add(double sample)
{
    samples_[count_ % kSamples] = sample;
    ++count_;
}

double RecentMedian::value() const
{
    std::array<double, kSamples> sorted = samples_;
    const size_t count = std::min(count_, kSamples);
    std::sort(sorted.begin(), sorted.begin() + static_cast<ptrdiff_t>(count));
    return sorted[count / 2];
}

void CostModel::take_hints(const DeviceCaps& caps)
{
    if (hint_us_per_triangle_ == caps.us_per_triangle && hint_us_per_item_ == caps.us_per_item) {
        return;
    }
    *this = CostModel{};
    hint_us_per_triangle_ = caps.us_per_triangle;
    hint_us_per_item_ = caps.us_per_item;
    us_per_unit_ = caps.us_per_triangle;
    triangles_per_item_ =
        caps.us_per_triangle > 0.0f ? caps.us_per_item / caps.us_per_triangle : 0.0;
    for (const TestCost& cost : caps.methods) {
        Method& method = methods_[index(cost.method)];
        method.available = caps.same_frame_results;
        method.hint = {cost.us_per_batch, cost.us_per_test + cost.us_per_box};
    }
    // Tested here, not by the device: all it needs is the depth.
    Method& pyramid = methods_[index(TestMethod::pyramid)];
    pyramid.available = caps.read_depth;
    pyramid.hint = kPyramidHint;
}

void CostModel::drew(double units, double us)
{
    us_sum_ = kDecay * us_sum_ + us;
    unit_sum_ = kDecay * unit_sum_ + units;
    if (unit_sum_ > 0.0) {
        us_per_unit_ = us_sum_ / unit_sum_;
    }
}

RoundCost CostModel::round(TestMethod which) const
{
    const Method& method = methods_[index(which)];
    if (!method.available) {
        constexpr double kNever = std::numeric_limits<double>::infinity();
        return {kNever, kNever};
    }
    RoundCost cost = method.hint;
    if (!method.us_per_test.empty()) {
        cost.us_per_test = method.us_per_test.value();
    }
    if (!method.small_round_us.empty()) {
        cost.us_per_round = method.small_round_us.value();
    }
    return cost;
}

void CostModel::tested(TestMethod which, size_t tests, double us)
{
    Method& method = methods_[index(which)];
    if (tests <= kSmallRound) {
        method.small_round_us.add(us);
    } else if (!method.small_round_us.empty()) {
        const double beyond = us - method.small_round_us.value();
        method.us_per_test.add(std::max(beyond, 0.0) / static_cast<double>(tests - kSmallRound));
    }
}

} // namespace occlude
