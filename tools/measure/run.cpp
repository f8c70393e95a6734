#include "measure/run.h"

#include <algorithm>

namespace occlude::tools {

Guarantee weaker(const Guarantee& a, const Guarantee& b)
{
    if (a.kind != b.kind) {
        return a.kind > b.kind ? a : b;
    }
    return a.frames + a.threshold >= b.frames + b.threshold ? a : b;
}

bool on_several_hierarchies(std::span<const AlgorithmRun> runs)
{
    return std::any_of(runs.begin(), runs.end(), [&](const AlgorithmRun& run) {
        return run.hierarchy != runs.front().hierarchy;
    });
}

std::string run_label(const AlgorithmRun& run, bool with_hierarchy)
{
    return with_hierarchy && !run.hierarchy.empty() ? run.algorithm + " on " + run.hierarchy
                                                    : run.algorithm;
}

double Summary::per_frame(uint64_t count) const
{
    return frame_count == 0 ? kNotMeasured
                            : static_cast<double>(count) / static_cast<double>(frame_count);
}

static std::vector<double> column(const AlgorithmRun& run, double FrameFigures::*figure)
{
    std::vector<double> values;
    values.reserve(run.frames.size());
    for (const FrameFigures& frame : run.frames) {
        values.push_back(frame.*figure);
    }
    return values;
}

Evidence evidence_of(std::span<const AlgorithmRun> runs)
{
    Evidence evidence;
    for (const AlgorithmRun& run : runs) {
        evidence.frames = std::max(evidence.frames, run.frames.size());
    }
    for (size_t frame = 0; frame < evidence.frames; ++frame) {
        bool empty = true;
        bool hides = false;
        for (const AlgorithmRun& run : runs) {
            const FrameFigures& figures = run.frames[std::min(frame, run.frames.size() - 1)];
            empty = empty && figures.shows_nothing;
            hides = hides || figures.counters.items_drawn < figures.items_in_frustum;
        }
        evidence.empty_frames += empty ? 1 : 0;
        evidence.hiding_frames += hides && !empty ? 1 : 0;
    }
    return evidence;
}

Summary summarise(const AlgorithmRun& run)
{
    Summary summary;
    summary.frame_ms = distribution(column(run, &FrameFigures::frame_ms));
    const std::vector<double> speedups = column(run, &FrameFigures::speedup_vs_frustum);
    summary.speedup_vs_frustum = median(speedups);
    summary.slowest_vs_frustum = percentile(speedups, 0.0);
    summary.ratio_to_opt = median(column(run, &FrameFigures::ratio_to_opt));
    summary.ratio_to_ideal = median(column(run, &FrameFigures::ratio_to_ideal));
    summary.overdraw_items_vs_exact = mean(column(run, &FrameFigures::overdraw_items_vs_exact));
    summary.wait_ms = mean(column(run, &FrameFigures::wait_ms));
    summary.read_ms = mean(column(run, &FrameFigures::read_ms));
    summary.cull_cpu_ms = mean(column(run, &FrameFigures::cull_cpu_ms));
    summary.frame_count = run.frames.size();
    for (const FrameFigures& frame : run.frames) {
        summary.total += frame.counters;
        summary.decision_hash = walk_hash(summary.decision_hash, frame.decision_hash);
        if (frame.verdict) {
            ++summary.compared_frames;
            summary.differing_pixels += frame.verdict->differing_pixels;
            summary.differing_frames += frame.verdict->differing_pixels > 0 ? 1 : 0;
            summary.tied_pixels += frame.verdict->tied_pixels;
        }
    }
    summary.verified = summary.compared_frames > 0;
    return summary;
}

} // namespace occlude::tools
