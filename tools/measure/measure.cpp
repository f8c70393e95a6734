#include "measure/measure.h"

#include "measure/verify.h"

#include <occlude/core/assert.h>

#include <algorithm>

namespace occlude::tools {

namespace {

// How many frames the untimed run before the timed ones has, spread over the path. They suffice to
// load what the path shows into caches and to use every shader variant.
constexpr size_t kWarmUpFrames = 4;
constexpr double kMsPerSecond = 1000.0;

// The measurements of one frame in each repeat, before the median is taken.
struct Samples {
    std::vector<double> frame_ms;
    std::vector<double> wait_ms;
    std::vector<double> read_ms;
    std::vector<double> cull_cpu_ms;
};

class Measurement {
public:
    Measurement(const Stage& stage, std::span<const Contender> contenders,
                std::span<const View> views, const MeasureOptions& options,
                std::vector<std::unique_ptr<Culler>> cullers)
        : stage_(stage)
        , views_(views)
        , options_(options)
        , contenders_(contenders)
        , cullers_(std::move(cullers))
    {
        for (size_t frame = options.sample_every - 1; frame < views.size();
             frame += options.sample_every) {
            sampled_frames_.push_back(frame);
        }
        const size_t count = sampled_frames_.size();
        owners_.resize(count);
        samples_.assign(contenders.size(), std::vector<Samples>(count));
        for (const Contender& contender : contenders) {
            runs_.push_back(
                {contender.name, {}, std::vector<FrameFigures>(count), contender.hierarchy});
        }
    }

    std::vector<AlgorithmRun> walk()
    {
        warm_up();
        for (size_t repeat = 0; repeat < options_.repeat; ++repeat) {
            for (const auto& culler : cullers_) {
                // Unspent tickets of the previous walk must not fill the device in this one.
                culler->release(stage_.renderer.device());
            }
            walk_path(repeat);
        }
        take_medians();
        compare_with_references(runs_);
        return std::move(runs_);
    }

private:
    std::vector<ItemId> owners_in(size_t frame)
    {
        const std::vector<ItemId> items = items_in_frustum(views_[frame], stage_.item_bounds);
        return owners_of_pixels(stage_.renderer.render_ids(views_[frame], items));
    }

    // Ends every frame as the timed ones end. A target that is cleared before it was drawn is never
    // drawn, and the first timed frame would pay for work that happens only once.
    void warm_up()
    {
        stage_.renderer.warm_up();
        const size_t count = std::min(kWarmUpFrames, views_.size());
        for (size_t i = 0; i < count; ++i) {
            const size_t frame = i * views_.size() / count;
            set_frame(stage_, frame);
            const std::vector<ItemId> owners = owners_in(frame);
            for (const auto& culler : cullers_) {
                record_answer(*culler, views_[frame], stage_.renderer.device(), owners);
                culler->cull(views_[frame], stage_.renderer.device());
                stage_.renderer.finish();
            }
        }
    }

    void walk_path(size_t repeat)
    {
        for (size_t frame = 0, sample = 0; frame < views_.size(); ++frame) {
            set_frame(stage_, frame);
            if (sample < sampled_frames_.size() && frame == sampled_frames_[sample]) {
                measure_frame(sample++, repeat);
            } else {
                pass_frame(frame);
            }
            if (options_.progress) {
                const size_t done = repeat * views_.size() + frame + 1;
                options_.progress(static_cast<double>(done) /
                                  static_cast<double>(options_.repeat * views_.size()));
            }
        }
    }

    // A frame between two samples, which only algorithms that remember earlier frames cull.
    void pass_frame(size_t frame)
    {
        for (size_t i = 0; i < cullers_.size(); ++i) {
            if (contenders_[i].remembers) {
                cullers_[i]->cull(views_[frame], stage_.renderer.device());
                stage_.renderer.finish();
            }
        }
    }

    void measure_frame(size_t sample, size_t repeat)
    {
        const View& view = views_[sampled_frames_[sample]];
        if (repeat == 0) {
            owners_[sample] = owners_in(sampled_frames_[sample]);
            note_evidence(sample, view);
        }
        for (const auto& culler : cullers_) {
            record_answer(*culler, view, stage_.renderer.device(), owners_[sample]);
        }
        const bool judged =
            repeat == 0 && options_.verify_every > 0 && sample % options_.verify_every == 0;
        const Capture reference = judged ? reference_image(stage_, view) : Capture{};
        for (const size_t contender : contender_order(cullers_.size(), sample, repeat)) {
            time_frame(contender, sample, repeat);
            if (judged) {
                judge(contender, sample, reference);
            }
        }
    }

    void note_evidence(size_t sample, const View& view)
    {
        const std::vector<ItemId> items = items_in_frustum(view, stage_.item_bounds);
        const bool any_blended = std::any_of(items.begin(), items.end(), [&](ItemId item) {
            return has_flag(stage_.item_bounds[item.value].flags, ItemFlags::translucent);
        });
        for (AlgorithmRun& run : runs_) {
            run.frames[sample].items_in_frustum = items.size();
            run.frames[sample].shows_nothing = owners_[sample].empty() && !any_blended;
        }
    }

    void time_frame(size_t contender, size_t sample, size_t repeat)
    {
        Culler& culler = *cullers_[contender];
        TimingDevice device{stage_.renderer.device(), options_.clock};
        stage_.renderer.finish();
        const double start = options_.clock();
        const FrameReport report = culler.cull(views_[sampled_frames_[sample]], device);
        const double culled = options_.clock();
        stage_.renderer.finish();
        const double stop = options_.clock();

        Samples& samples = samples_[contender][sample];
        samples.frame_ms.push_back(kMsPerSecond * (stop - start));
        samples.wait_ms.push_back(kMsPerSecond * device.wait_seconds());
        samples.read_ms.push_back(kMsPerSecond * device.read_seconds());
        samples.cull_cpu_ms.push_back(kMsPerSecond * (culled - start - device.verb_seconds()));
        runs_[contender].polled = runs_[contender].polled || device.polls() > 0;
        const auto& asked_time = contenders_[contender].asked_time;
        runs_[contender].asked_time = asked_time != nullptr && *asked_time;
        if (repeat == 0) {
            note_decisions(contender, sample, report);
        }
    }

    void note_decisions(size_t contender, size_t sample, const FrameReport& report)
    {
        const Culler& culler = *cullers_[contender];
        AlgorithmRun& run = runs_[contender];
        run.guarantee = weaker(run.guarantee, report.guarantee);
        FrameFigures& figures = run.frames[sample];
        figures.frame = sampled_frames_[sample];
        figures.counters = report.counters;
        figures.plan = report.plan;
        figures.decision_hash = culler.decisions().hash(culler.hierarchy(), figures.frame);
        figures.overdraw_items_vs_exact = overdraw_items(culler.drawn_items(), owners_[sample]);
    }

    void judge(size_t contender, size_t sample, const Capture& reference)
    {
        const Culler& culler = *cullers_[contender];
        const Capture culled = stage_.renderer.capture();
        Stage walked{culler.hierarchy(), stage_.item_bounds, stage_.renderer};
        runs_[contender].frames[sample].verdict =
            judge_frame(walked, views_[sampled_frames_[sample]], reference, culled,
                        culler.drawn_items(), culler.decisions());
    }

    void take_medians()
    {
        for (size_t contender = 0; contender < runs_.size(); ++contender) {
            for (size_t sample = 0; sample < sampled_frames_.size(); ++sample) {
                const Samples& samples = samples_[contender][sample];
                FrameFigures& figures = runs_[contender].frames[sample];
                figures.frame_ms = median(samples.frame_ms);
                figures.wait_ms = median(samples.wait_ms);
                figures.read_ms = median(samples.read_ms);
                figures.cull_cpu_ms = median(samples.cull_cpu_ms);
            }
        }
    }

    const Stage& stage_;
    std::span<const View> views_;
    const MeasureOptions& options_;
    std::span<const Contender> contenders_;
    std::vector<std::unique_ptr<Culler>> cullers_;
    std::vector<size_t> sampled_frames_;      // indices into the path, ascending
    std::vector<std::vector<ItemId>> owners_; // by sample, as is the second index of the next two
    std::vector<std::vector<Samples>> samples_;
    std::vector<AlgorithmRun> runs_;
};

// The run of `algorithm` that `better` prefers to all others, and the first of equals; null: none.
template <class Better>
const AlgorithmRun* find_run(std::span<const AlgorithmRun> runs, std::string_view algorithm,
                             Better&& better)
{
    const AlgorithmRun* best = nullptr;
    for (const AlgorithmRun& run : runs) {
        if (run.algorithm == algorithm && (best == nullptr || better(run, *best))) {
            best = &run;
        }
    }
    return best;
}

double median_frame_ms(const AlgorithmRun& run)
{
    return summarise(run).frame_ms.median;
}

} // namespace

std::vector<size_t> contender_order(size_t count, size_t frame, size_t repeat)
{
    std::vector<size_t> order(count);
    for (size_t i = 0; i < count; ++i) {
        order[i] = (i + frame + repeat) % count;
    }
    return order;
}

double overdraw_items(std::span<const ItemId> drawn, std::span<const ItemId> owners)
{
    const auto wasted = std::count_if(drawn.begin(), drawn.end(), [&](ItemId item) {
        return !std::binary_search(owners.begin(), owners.end(), item);
    });
    return static_cast<double>(wasted) / static_cast<double>(std::max<size_t>(owners.size(), 1));
}

void compare_with_references(std::span<AlgorithmRun> runs)
{
    const AlgorithmRun* frustum =
        find_run(runs, "frustum", [](const AlgorithmRun& a, const AlgorithmRun& b) {
            return median_frame_ms(a) < median_frame_ms(b);
        });
    const AlgorithmRun* ideal = find_run(runs, "ideal", [](auto&, auto&) { return false; });
    for (AlgorithmRun& run : runs) {
        const AlgorithmRun* opt =
            find_run(runs, "opt", [&](const AlgorithmRun& a, const AlgorithmRun& b) {
                return a.hierarchy == run.hierarchy && b.hierarchy != run.hierarchy;
            });
        for (size_t frame = 0; frame < run.frames.size(); ++frame) {
            FrameFigures& figures = run.frames[frame];
            if (frustum != nullptr) {
                figures.speedup_vs_frustum = frustum->frames[frame].frame_ms / figures.frame_ms;
            }
            if (opt != nullptr) {
                figures.ratio_to_opt = figures.frame_ms / opt->frames[frame].frame_ms;
            }
            if (ideal != nullptr) {
                figures.ratio_to_ideal = figures.frame_ms / ideal->frames[frame].frame_ms;
            }
        }
    }
}

Result<std::vector<AlgorithmRun>> measure(const Stage& stage, std::span<const Contender> contenders,
                                          std::span<const View> views,
                                          const MeasureOptions& options)
{
    OCCLUDE_ASSERT(!views.empty() && options.repeat > 0 && options.sample_every > 0 &&
                       options.sample_every <= views.size(),
                   "there is nothing to measure");
    auto cullers = make_cullers(stage, contenders);
    if (!cullers) {
        return cullers.error();
    }
    return Measurement{stage, contenders, views, options, std::move(*cullers)}.walk();
}

} // namespace occlude::tools
