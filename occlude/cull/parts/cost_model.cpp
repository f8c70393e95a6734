#include <occlude/cull/parts/cost_model.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace occlude {

namespace {

// The cost of a read-back and of a test against it before anything is measured.
constexpr RoundCost kPyramidHint{400.0, 0.1, 0.1};

// Frames that draw fewer units show nothing about the cost of drawing.
constexpr double kMinSampleUnits = 256.0;

// Two frames give a slope only if one drew at least this many times as much as the other. Otherwise
// noise dominates the difference.
constexpr double kMinWorkRatio = 4.0;

// The slope counts at least this share of the largest frame's time as drawing, whatever the noise.
constexpr double kMinDrawingShare = 0.1;

// Until there is a slope, the cost of drawing is capped at this many times the hint.
constexpr double kMaxHintRatio = 4.0;

// Rounds that measure each cost of a method; they have one box, or `kLargeRoundBoxes`.
constexpr size_t kMeasuredRounds = 3;
constexpr size_t kLargeRoundBoxes = 16;

} // namespace

void RecentMedian::add(double sample)
{
    samples_[count_ % kSamples] = sample;
    ++count_;
}

double RecentMedian::value() const
{
    std::array<double, kSamples> samples = samples_;
    const auto count = static_cast<ptrdiff_t>(std::min(count_, kSamples));
    const auto median = samples.begin() + (count - 1) / 2;
    std::nth_element(samples.begin(), median, samples.begin() + count);
    return *median;
}

void CostModel::take_hints(const DeviceCaps& caps, glm::ivec2 size_px)
{
    take_read_hints(caps, size_px);
    if (hint_us_per_triangle_ == caps.us_per_triangle && hint_us_per_item_ == caps.us_per_item) {
        return;
    }
    *this = CostModel{};
    take_read_hints(caps, size_px);
    hint_us_per_triangle_ = caps.us_per_triangle;
    hint_us_per_item_ = caps.us_per_item;
    us_per_unit_ = caps.us_per_triangle;
    triangles_per_item_ =
        caps.us_per_triangle > 0.0f ? caps.us_per_item / caps.us_per_triangle : 0.0;
    for (const TestCost& cost : caps.methods) {
        Method& method = methods_[index(cost.method)];
        method.available = caps.same_frame_results;
        method.hint = {cost.us_per_batch, cost.us_per_test + cost.us_per_box, cost.us_per_box};
    }
    // The CPU tests against the pyramid, so that the device needs no more than to read depth.
    Method& pyramid = methods_[index(TestMethod::pyramid)];
    pyramid.available = caps.read_depth;
    pyramid.hint = kPyramidHint;
}

// The hint for pixels stands for the whole method; hints for tiles only compare sizes of tiles.
void CostModel::take_read_hints(const DeviceCaps& caps, glm::ivec2 size_px)
{
    const DepthReadCost* pixels = caps.find_depth_read(1);
    const double pixels_us = pixels != nullptr ? double{pixels->us(size_px)} : 0.0;
    for (Read& read : reads_) {
        const DepthReadCost* hint = caps.find_depth_read(read.tile_px);
        read.available = read.tile_px == 1 || (hint != nullptr && pixels_us > 0.0);
        read.hint_us = kPyramidHint.us_per_round;
        if (read.available && read.tile_px > 1) {
            read.hint_us *= double{hint->us(size_px)} / pixels_us;
        }
    }
    if (!reads_[read_].available) {
        read_ = 0;
    }
}

void CostModel::choose_tile(double drawn_us)
{
    const bool measured = !reads_[0].us.empty();
    const auto cost_us = [&](const Read& read) {
        return read.cost_us() + read.undrawn_share * drawn_us;
    };
    read_ = 0;
    for (size_t i = 1; i < reads_.size(); ++i) {
        const bool known = reads_[i].available && (!measured || !reads_[i].us.empty());
        if (known && cost_us(reads_[i]) < cost_us(reads_[read_])) {
            read_ = i;
        }
    }
}

int CostModel::unmeasured_tile_px() const
{
    const auto due = [&](const Read& read) {
        return read.available && read.us.count() < kMeasuredRounds &&
               (read.tile_px == 1 || !read.us.empty() ||
                read.hint_us < kMaxHintRatio * reads_[0].cost_us());
    };
    const auto found = std::find_if(reads_.begin(), reads_.end(), due);
    return found != reads_.end() ? found->tile_px : 0;
}

void CostModel::record_read(int tile_px, double us)
{
    for (Read& read : reads_) {
        if (read.tile_px == tile_px) {
            read.us.add(us);
        }
    }
}

void CostModel::forget_measurements()
{
    for (Read& read : reads_) {
        read.us = {};
    }
    read_ = 0;
    for (Method& method : methods_) {
        method.small_round_us = {};
        method.us_per_test = {};
        method.us_per_box = {};
    }
    drawn_ = {};
    us_per_unit_ = hint_us_per_triangle_;
}

size_t CostModel::size_class(double units)
{
    const int size = std::max(std::ilogb(std::max(units, 1.0)), 0);
    return std::min(static_cast<size_t>(size), kSizeClasses - 1);
}

double CostModel::whole_us(double units) const
{
    double us = us_per_unit_ * units;
    for (size_t size = 0; size <= size_class(units); ++size) {
        if (!drawn_[size].us.empty()) {
            us = std::max(us, drawn_[size].us.value());
        }
    }
    return us;
}

// Takes the slope between the frame that drew least and the frame that drew most. The whole time of
// the largest frame, divided by its units, bounds the slope, because pixels cost time, too.
void CostModel::record_drawing(double units, double us)
{
    if (units < kMinSampleUnits) {
        return;
    }
    Sample& sample = drawn_[size_class(units)];
    sample.units.add(units);
    sample.us.add(us);

    const auto known = [](const Sample& s) { return !s.units.empty(); };
    const Sample& least = *std::find_if(drawn_.begin(), drawn_.end(), known);
    const Sample& most = *std::find_if(drawn_.rbegin(), drawn_.rend(), known);
    const double bound = most.us.value() / most.units.value();
    const double difference = most.units.value() - least.units.value();
    if (most.units.value() >= kMinWorkRatio * least.units.value()) {
        const double slope = (most.us.value() - least.us.value()) / difference;
        us_per_unit_ = std::clamp(slope, kMinDrawingShare * bound, bound);
    } else {
        us_per_unit_ = std::min(kMaxHintRatio * double{hint_us_per_triangle_}, bound);
    }
}

RoundCost CostModel::round(TestMethod which) const
{
    const Method& method = methods_[index(which)];
    if (!method.available) {
        constexpr double kNever = std::numeric_limits<double>::infinity();
        return {kNever, kNever, kNever};
    }
    RoundCost cost = method.hint;
    if (!method.us_per_test.empty()) {
        cost.us_per_test = method.us_per_test.value();
    }
    if (!method.us_per_box.empty()) {
        cost.us_per_box = method.us_per_box.value();
    }
    cost.us_per_box = std::min(cost.us_per_box, cost.us_per_test);
    if (which == TestMethod::pyramid) {
        cost.us_per_round = reads_[read_].cost_us();
    } else if (!method.small_round_us.empty()) {
        cost.us_per_round = method.small_round_us.value();
    }
    return cost;
}

CostModel::RoundSize CostModel::least_known(TestMethod which) const
{
    const Method& method = methods_[index(which)];
    if (!method.available) {
        return {};
    }
    if (which == TestMethod::pyramid) {
        // Of pixels: whether tiles would be cheaper decides nothing here.
        return reads_[0].us.count() < kMeasuredRounds ? RoundSize{1, 1} : RoundSize{};
    }
    const size_t rounds = method.small_round_us.count();
    if (method.us_per_test.count() < rounds) {
        return {kLargeRoundBoxes, kLargeRoundBoxes};
    }
    if (which == TestMethod::queries && method.us_per_box.count() < rounds) {
        return {1, kLargeRoundBoxes};
    }
    return rounds < kMeasuredRounds ? RoundSize{1, 1} : RoundSize{};
}

void CostModel::record_round(TestMethod which, size_t tests, size_t boxes, double us)
{
    Method& method = methods_[index(which)];
    if (boxes <= 1) {
        (which == TestMethod::pyramid ? reads_[read_].us : method.small_round_us).add(us);
        return;
    }
    if (small_round_us(which).empty()) {
        return;
    }
    const double beyond = us - small_round_us(which).value();
    if (tests == 1) {
        method.us_per_box.add(std::max(beyond, 0.0) / static_cast<double>(boxes - 1));
        return;
    }
    const double shared_us = static_cast<double>(boxes - tests) * round(which).us_per_box;
    method.us_per_test.add(std::max(beyond - shared_us, 0.0) / static_cast<double>(tests - 1));
}

} // namespace occlude
