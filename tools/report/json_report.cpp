#include "report/json_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace occlude::tools {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value)
{
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json if_verified(bool verified, uint64_t count)
{
    return verified ? Json(count) : Json(nullptr);
}

// Hashes go as text: a JSON number holds only 53 bits safely.
Json hash_text(uint64_t hash)
{
    return fmt::format("{:016x}", hash);
}

Json distribution_json(const Distribution& d)
{
    return {{"median", number(d.median)}, {"mean", number(d.mean)}, {"p95", number(d.p95)},
            {"p99", number(d.p99)},       {"max", number(d.max)},   {"total", number(d.total)}};
}

// `value(count)` is what becomes of a counter: itself for one frame, its mean for a run.
template <class Value>
Json counters_json(const FrameCounters& c, double wait_ms, double cull_cpu_ms, Value&& value)
{
    return {{"queries", value(c.queries)},
            {"boxes", value(c.boxes)},
            {"multiqueries_failed", value(c.multiqueries_failed)},
            {"state_changes", value(c.state_changes)},
            {"batches", value(c.batches)},
            {"draw_calls", value(c.draw_calls)},
            {"items_drawn", value(c.items_drawn)},
            {"triangles_drawn", value(c.triangles_drawn)},
            {"nodes_visited", value(c.nodes_visited)},
            {"waits", value(c.waits)},
            {"depth_reads", value(c.depth_reads)},
            {"pixels_read", value(c.pixels_read)},
            {"cells_asked", value(c.cells_asked)},
            {"wait_ms", number(wait_ms)},
            {"cull_cpu_ms", number(cull_cpu_ms)}};
}

Json frame_json(const FrameFigures& frame)
{
    Json json = {{"frame_ms", number(frame.frame_ms)},
                 {"speedup_vs_frustum", number(frame.speedup_vs_frustum)},
                 {"ratio_to_opt", number(frame.ratio_to_opt)},
                 {"ratio_to_ideal", number(frame.ratio_to_ideal)}};
    json.update(counters_json(frame.counters, frame.wait_ms, frame.cull_cpu_ms,
                              [](uint64_t count) { return Json(count); }));
    const bool verified = frame.verdict.has_value();
    const Verdict verdict = frame.verdict.value_or(Verdict{});
    json["overdraw_items_vs_exact"] = number(frame.overdraw_items_vs_exact);
    json["differing_pixels"] = if_verified(verified, verdict.differing_pixels);
    json["tied_pixels"] = if_verified(verified, verdict.tied_pixels);
    json["decision_hash"] = hash_text(frame.decision_hash);
    return json;
}

Json run_json(const AlgorithmRun& run, const BenchDocument& document)
{
    const Summary summary = summarise(run);
    Json frames = Json::array();
    for (const FrameFigures& frame : run.frames) {
        frames.push_back(frame_json(frame));
    }
    return {{"algorithm", run.algorithm},
            {"hierarchy", run.hierarchy},
            {"device", document.device},
            {"test", document.test},
            {"guarantee", to_string(run.guarantee)},
            {"frame_ms", distribution_json(summary.frame_ms)},
            {"speedup_vs_frustum", number(summary.speedup_vs_frustum)},
            {"ratio_to_opt", number(summary.ratio_to_opt)},
            {"ratio_to_ideal", number(summary.ratio_to_ideal)},
            {"per_frame",
             counters_json(summary.total, summary.wait_ms, summary.cull_cpu_ms,
                           [&](uint64_t count) { return number(summary.per_frame(count)); })},
            {"overdraw_items_vs_exact", number(summary.overdraw_items_vs_exact)},
            {"differing_pixels", if_verified(summary.verified, summary.differing_pixels)},
            {"differing_frames", if_verified(summary.verified, summary.differing_frames)},
            {"tied_pixels", if_verified(summary.verified, summary.tied_pixels)},
            {"decision_hash", hash_text(summary.decision_hash)},
            {"frames", std::move(frames)}};
}

Json document_json(const BenchDocument& document)
{
    Json runs = Json::array();
    for (const AlgorithmRun& run : document.runs) {
        runs.push_back(run_json(run, document));
    }
    return {{"version", 1},
            {"scene",
             {{"name", document.scene},
              {"objects", document.objects},
              {"items", document.items},
              {"triangles", document.triangles}}},
            {"device",
             {{"name", document.device}, {"api", document.api}, {"renderer", document.renderer}}},
            {"path", document.path},
            {"size", {document.size.x, document.size.y}},
            {"samples", document.samples},
            {"frames", document.frames},
            {"repeat", document.repeat},
            {"runs", std::move(runs)}};
}

} // namespace

std::string json_report(std::span<const BenchDocument> documents)
{
    constexpr int kIndent = 1;
    Json json = Json::array();
    for (const BenchDocument& document : documents) {
        json.push_back(document_json(document));
    }
    // Names come from files: bytes that are not UTF-8 are replaced, never thrown about.
    const Json& top = documents.size() == 1 ? json[0] : json;
    return top.dump(kIndent, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace occlude::tools
