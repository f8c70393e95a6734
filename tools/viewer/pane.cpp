#include "viewer/pane.h"

#include <occlude/cull/registry.h>

#include <algorithm>

namespace occlude::tools::viewer {

static constexpr double kMsPerSecond = 1000.0;

void Rolling::add(float value)
{
    if (values_.size() == kCapacity) {
        values_.erase(values_.begin());
    }
    values_.push_back(value);
}

float Rolling::largest() const
{
    return values_.empty() ? 0.0f : *std::max_element(values_.begin(), values_.end());
}

float Rolling::median() const
{
    constexpr size_t kWindow = 60;
    const size_t count = std::min(kWindow, values_.size());
    if (count == 0) {
        return 0.0f;
    }
    std::vector<float> last(values_.end() - static_cast<ptrdiff_t>(count), values_.end());
    const auto middle = last.begin() + static_cast<ptrdiff_t>(count / 2);
    std::nth_element(last.begin(), middle, last.end());
    return *middle;
}

Pane::Pane(std::string algorithm, SecondsClock clock)
    : algorithm_(std::move(algorithm))
    , clock_(std::move(clock))
    , tracer_(clock_)
{
}

void Pane::choose_algorithm(const std::string& algorithm)
{
    if (algorithm != algorithm_) {
        algorithm_ = algorithm;
        forget_tree();
        figures_.clear();
    }
}

void Pane::set_option(const std::string& name, const std::string& value)
{
    options_[algorithm_][name] = value;
    forget_tree();
}

std::string Pane::option(const OptionInfo& info) const
{
    const auto sets = options_.find(algorithm_);
    if (sets != options_.end()) {
        if (const auto value = sets->second.find(info.name); value != sets->second.end()) {
            return value->second;
        }
    }
    return info.default_value;
}

void Pane::set_option_sets(OptionSets sets)
{
    options_ = std::move(sets);
    forget_tree();
}

void Pane::forget_tree()
{
    culler_.reset();
    memory_.clear();
    tracer_.forget();
    report_ = {};
}

void Pane::cut()
{
    if (culler_) {
        culler_->reset();
    }
}

bool Pane::make_culler(const Hierarchy& tree)
{
    std::vector<OptionValue> values;
    if (const auto sets = options_.find(algorithm_); sets != options_.end()) {
        values.assign(sets->second.begin(), sets->second.end());
    }
    auto made = occlude::make_culler(algorithm_, tree, values, clock_);
    problem_ = made ? std::string{} : made.error().message;
    if (made) {
        culler_ = std::move(*made);
    }
    return culler_ != nullptr;
}

bool Pane::cull(const Stage& stage, const View& view, QueryDevice& device, uint64_t frame)
{
    if (!culler_ && !make_culler(stage.hierarchy)) {
        return false;
    }
    if (needs_answer(*culler_)) {
        const std::vector<ItemId> items = items_in_frustum(view, stage.item_bounds);
        const std::vector<ItemId> owners = owners_of_pixels(stage.renderer.render_ids(view, items));
        record_answer(*culler_, view, stage.renderer.device(), owners);
    }
    if (memory_.size() == kRememberedFrames) {
        memory_.pop_front();
    }
    FrameMemory& remembered = memory_.emplace_back();
    remembered.frame = frame;
    TimingDevice timing{device, clock_};
    tracer_.set_inner(timing);
    stage.renderer.finish();
    tracer_.begin(remembered.trace, frame);
    const double start = clock_();
    report_ = culler_->cull(view, tracer_);
    const double culled = clock_();
    stage.renderer.finish();
    const double end = clock_();
    remembered.trace.end_s = end;
    const auto decisions = culler_->decisions().entries();
    remembered.decisions.assign(decisions.begin(), decisions.end());

    const FrameCounters& counters = report_.counters;
    figures_.frame_ms.add(static_cast<float>(kMsPerSecond * (end - start - tracer_.overhead_s())));
    figures_.cull_cpu_ms.add(static_cast<float>(
        kMsPerSecond * (culled - start - timing.verb_seconds() - tracer_.overhead_s())));
    figures_.queries.add(static_cast<float>(counters.queries));
    figures_.batches.add(static_cast<float>(counters.batches));
    figures_.waits.add(static_cast<float>(counters.waits));
    figures_.triangles.add(static_cast<float>(counters.triangles_drawn));
    return true;
}

const FrameTrace& Pane::trace() const
{
    static const FrameTrace kNone{};
    return memory_.empty() ? kNone : memory_.back().trace;
}

} // namespace occlude::tools::viewer
