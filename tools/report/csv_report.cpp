#include "report/csv_report.h"

#include <fmt/format.h>

#include <cmath>

namespace occlude::tools {

namespace {

// One row in the making: the same calls give the header and the values.
class Row {
public:
    void text(std::string_view name, std::string_view value)
    {
        const bool quoted = value.find_first_of(",\"\n\r") != std::string_view::npos;
        std::string cell{value};
        for (size_t at = 0; quoted && (at = cell.find('"', at)) != std::string::npos; at += 2) {
            cell.insert(at, 1, '"');
        }
        add(name, quoted ? '"' + cell + '"' : cell);
    }
    void number(std::string_view name, double value)
    {
        add(name, std::isfinite(value) ? fmt::format("{}", value) : "");
    }
    void count(std::string_view name, uint64_t value) { add(name, std::to_string(value)); }
    void count_if(std::string_view name, bool known, uint64_t value)
    {
        add(name, known ? std::to_string(value) : "");
    }

    const std::string& names() const { return names_; }
    const std::string& values() const { return values_; }

private:
    void add(std::string_view name, const std::string& value)
    {
        const std::string_view comma = names_.empty() ? "" : ",";
        names_ += std::string{comma} + std::string{name};
        values_ += std::string{comma} + value;
    }

    std::string names_;
    std::string values_;
};

Row run_row(const BenchDocument& document, const AlgorithmRun& run)
{
    const Summary summary = summarise(run);
    Row row;
    row.text("scene", document.scene);
    row.count("triangles", document.triangles);
    row.text("path", document.path);
    row.text("device", document.device);
    row.text("renderer", document.renderer);
    row.text("size", fmt::format("{}x{}", document.size.x, document.size.y));
    row.count("frames", document.frames);
    row.count("repeat", document.repeat);
    row.text("algorithm", run.algorithm);
    row.text("hierarchy", run.hierarchy);
    row.text("test", document.test);
    row.text("guarantee", to_string(run.guarantee));
    row.number("frame_ms_median", summary.frame_ms.median);
    row.number("frame_ms_mean", summary.frame_ms.mean);
    row.number("frame_ms_p95", summary.frame_ms.p95);
    row.number("frame_ms_p99", summary.frame_ms.p99);
    row.number("frame_ms_max", summary.frame_ms.max);
    row.number("frame_ms_total", summary.frame_ms.total);
    row.number("speedup_vs_frustum", summary.speedup_vs_frustum);
    row.number("ratio_to_opt", summary.ratio_to_opt);
    row.number("ratio_to_ideal", summary.ratio_to_ideal);
    for_each_counter(summary.total, [&](std::string_view name, uint64_t total) {
        row.number(name, summary.per_frame(total));
    });
    row.number("wait_ms", summary.wait_ms);
    row.number("cull_cpu_ms", summary.cull_cpu_ms);
    row.number("overdraw_items_vs_exact", summary.overdraw_items_vs_exact);
    row.count_if("differing_pixels", summary.verified, summary.differing_pixels);
    row.count_if("differing_frames", summary.verified, summary.differing_frames);
    row.count_if("tied_pixels", summary.verified, summary.tied_pixels);
    row.text("decision_hash", fmt::format("{:016x}", summary.decision_hash));
    return row;
}

} // namespace

std::string csv_report(std::span<const BenchDocument> documents)
{
    std::string csv;
    for (const BenchDocument& document : documents) {
        for (const AlgorithmRun& run : document.runs) {
            const Row row = run_row(document, run);
            if (csv.empty()) {
                csv = row.names() + "\n";
            }
            csv += row.values() + "\n";
        }
    }
    return csv;
}

} // namespace occlude::tools
