#include "report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace occlude::tools {

namespace {

std::string figure(double value, int decimals)
{
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

std::string rounded_count(double value)
{
    return std::isfinite(value) ? grouped(static_cast<uint64_t>(std::llround(value))) : "-";
}

std::string heading(const BenchDocument& document)
{
    const std::string msaa =
        document.samples > 1 ? fmt::format(", {} samples", document.samples) : "";
    return fmt::format("{}: {} objects, {} items, {} triangles; path {}, {} frames{}\n"
                       "{}x{}{} on {} ({}), hierarchy {}, test {}\n",
                       document.scene, grouped(document.objects), grouped(document.items),
                       grouped(document.triangles), document.path, document.frames,
                       document.repeat > 1 ? fmt::format(" x {}", document.repeat) : "",
                       document.size.x, document.size.y, msaa, document.api, document.renderer,
                       document.hierarchy, document.test);
}

// Adds the hierarchy as the second column where runs are on several.
void name_hierarchies(std::vector<std::vector<std::string>>& rows,
                      std::span<const AlgorithmRun> runs)
{
    if (!on_several_hierarchies(runs)) {
        return;
    }
    rows[0].insert(rows[0].begin() + 1, "hierarchy");
    for (size_t i = 0; i < runs.size(); ++i) {
        rows[i + 1].insert(rows[i + 1].begin() + 1, runs[i].hierarchy);
    }
}

std::vector<std::string> bench_row(const AlgorithmRun& run)
{
    const Summary s = summarise(run);
    return {run.algorithm,
            figure(s.frame_ms.median, 2),
            figure(s.frame_ms.p99, 2),
            figure(s.speedup_vs_frustum, 2),
            figure(s.ratio_to_opt, 2),
            figure(s.ratio_to_ideal, 2),
            figure(s.per_frame(s.total.queries), 1),
            figure(s.per_frame(s.total.state_changes), 1),
            rounded_count(s.per_frame(s.total.triangles_drawn)),
            s.verified ? grouped(s.differing_pixels) : "-"};
}

std::vector<std::string> verify_row(const AlgorithmRun& run)
{
    const Summary s = summarise(run);
    const bool exact = run.guarantee.kind == Guarantee::Kind::exact;
    const bool equal = s.differing_pixels == 0;
    return {run.algorithm,
            to_string(run.guarantee),
            std::to_string(s.frame_count),
            grouped(s.differing_pixels),
            std::to_string(s.differing_frames),
            grouped(s.tied_pixels),
            figure(s.per_frame(s.total.queries), 1),
            rounded_count(s.per_frame(s.total.triangles_drawn)),
            equal ? (s.tied_pixels == 0 ? "equal" : "equal but for ties")
                  : (exact ? "DIFFERS" : "differs, as it may")};
}

} // namespace

std::string grouped(uint64_t value)
{
    std::string digits = std::to_string(value);
    for (size_t at = digits.size(); at > 3; at -= 3) {
        digits.insert(at - 3, 1, ',');
    }
    return digits;
}

std::string align_columns(const std::vector<std::vector<std::string>>& rows)
{
    std::vector<size_t> widths;
    for (const auto& row : rows) {
        widths.resize(std::max(widths.size(), row.size()), 0);
        for (size_t i = 0; i < row.size(); ++i) {
            widths[i] = std::max(widths[i], row[i].size());
        }
    }
    std::string text;
    for (const auto& row : rows) {
        for (size_t i = 0; i < row.size(); ++i) {
            text += i == 0 ? fmt::format("{:<{}}", row[i], widths[i])
                           : fmt::format("  {:>{}}", row[i], widths[i]);
        }
        text += '\n';
    }
    return text;
}

// What an algorithm that chooses per frame has chosen: "adaptive: 99 frames pyramid, 1 draw_all".
static std::string plans_line(const AlgorithmRun& run)
{
    std::map<std::string, size_t> frames;
    for (const FrameFigures& frame : run.frames) {
        if (frame.plan.kind != FramePlan::Kind::fixed) {
            ++frames[name(frame.plan.kind)];
        }
    }
    std::string line;
    for (const auto& [plan, count] : frames) {
        line +=
            fmt::format("{}{} frames {}", line.empty() ? run.algorithm + ": " : ", ", count, plan);
    }
    return line.empty() ? line : line + "\n";
}

std::string bench_table(const BenchDocument& document)
{
    std::vector<std::vector<std::string>> rows = {{"algorithm", "median ms", "p99 ms", "speed-up",
                                                   "vs opt", "vs ideal", "queries", "state changes",
                                                   "triangles", "differing px"}};
    for (const AlgorithmRun& run : document.runs) {
        rows.push_back(bench_row(run));
    }
    name_hierarchies(rows, document.runs);
    std::string text = heading(document) + '\n' + align_columns(rows);
    for (const AlgorithmRun& run : document.runs) {
        text += plans_line(run);
    }
    return text;
}

std::string verify_table(const BenchDocument& document)
{
    std::vector<std::vector<std::string>> rows = {{"algorithm", "promise", "frames", "differing px",
                                                   "differing frames", "tied px", "queries",
                                                   "triangles", "image"}};
    for (const AlgorithmRun& run : document.runs) {
        rows.push_back(verify_row(run));
    }
    name_hierarchies(rows, document.runs);
    return heading(document) + '\n' + align_columns(rows);
}

} // namespace occlude::tools
