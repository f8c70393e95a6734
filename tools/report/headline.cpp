#include "report/headline.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace occlude::tools {

static bool is_yardstick(const std::string& algorithm)
{
    return algorithm == "frustum" || algorithm == "opt" || algorithm == "ideal";
}

std::optional<size_t> chosen_run(const BenchDocument& document)
{
    std::optional<size_t> best;
    double best_speedup = 0.0;
    for (size_t i = 0; i < document.runs.size(); ++i) {
        const AlgorithmRun& run = document.runs[i];
        const double speedup = summarise(run).speedup_vs_frustum;
        if (is_yardstick(run.algorithm) || run.guarantee.kind != Guarantee::Kind::exact ||
            !std::isfinite(speedup)) {
            continue;
        }
        if (run.algorithm == "adaptive") {
            return i;
        }
        if (speedup > best_speedup) {
            best = i;
            best_speedup = speedup;
        }
    }
    return best;
}

std::optional<size_t> ideal_run(const BenchDocument& document, size_t beside)
{
    const std::vector<AlgorithmRun>& runs = document.runs;
    std::optional<size_t> any; // `ideal` makes no use of nodes, and may have run on one tree only
    for (size_t i = 0; i < runs.size(); ++i) {
        if (runs[i].algorithm == "ideal") {
            any = runs[i].hierarchy == runs[beside].hierarchy ? i : any.value_or(i);
        }
    }
    return any;
}

std::vector<size_t> worst_frames(const AlgorithmRun& run, size_t count)
{
    std::vector<size_t> order;
    for (size_t i = 0; i < run.frames.size(); ++i) {
        if (std::isfinite(run.frames[i].speedup_vs_frustum)) {
            order.push_back(i);
        }
    }
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return run.frames[a].speedup_vs_frustum < run.frames[b].speedup_vs_frustum;
    });
    order.resize(std::min(order.size(), count));
    return order;
}

} // namespace occlude::tools
