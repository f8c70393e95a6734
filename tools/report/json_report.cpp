#include "report/json_report.h"

#include "files/json.h"

#include <fmt/core.h>

#include <cmath>

namespace occlude::tools {

namespace {

// Whether every frame is told, or only what sums them up.
enum class Detail { frames, sums };

Json number(double value)
{
    return std::isfinite(value) ? Json(value) : Json();
}

Json if_verified(bool verified, uint64_t count)
{
    return verified ? Json(count) : Json();
}

// Hashes go as text: a JSON number holds only 53 bits safely.
Json hash_text(uint64_t hash)
{
    return fmt::format("{:016x}", hash);
}

Json distribution_json(const Distribution& d)
{
    return Json::object({{"median", number(d.median)},
                         {"mean", number(d.mean)},
                         {"p95", number(d.p95)},
                         {"p99", number(d.p99)},
                         {"max", number(d.max)},
                         {"total", number(d.total)}});
}

// `value(count)` is what becomes of a counter: itself for one frame, its mean for a run.
template <class Value>
Json counters_json(const FrameCounters& c, double wait_ms, double read_ms, double cull_cpu_ms,
                   Value&& value)
{
    return Json::object({{"queries", value(c.queries)},
                         {"boxes", value(c.boxes)},
                         {"multiqueries", value(c.multiqueries)},
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
                         {"read_ms", number(read_ms)},
                         {"cull_cpu_ms", number(cull_cpu_ms)}});
}

Json frame_json(const FrameFigures& frame)
{
    Json json = Json::object({{"frame", frame.frame},
                              {"frame_ms", number(frame.frame_ms)},
                              {"speedup_vs_frustum", number(frame.speedup_vs_frustum)},
                              {"ratio_to_opt", number(frame.ratio_to_opt)},
                              {"ratio_to_ideal", number(frame.ratio_to_ideal)}});
    json.update(counters_json(frame.counters, frame.wait_ms, frame.read_ms, frame.cull_cpu_ms,
                              [](uint64_t count) { return Json(count); }));
    const bool verified = frame.verdict.has_value();
    const Verdict verdict = frame.verdict.value_or(Verdict{});
    json.set("overdraw_items_vs_exact", number(frame.overdraw_items_vs_exact));
    json.set("differing_pixels", if_verified(verified, verdict.differing_pixels));
    json.set("tied_pixels", if_verified(verified, verdict.tied_pixels));
    json.set("decision_hash", hash_text(frame.decision_hash));
    if (frame.plan.kind != FramePlan::Kind::fixed) {
        json.set("plan", to_string(frame.plan));
    }
    return json;
}

// Everything about a run but its frames.
Json run_json(const AlgorithmRun& run, const BenchDocument& document)
{
    const Summary summary = summarise(run);
    return Json::object(
        {{"algorithm", run.algorithm},
         {"hierarchy", run.hierarchy},
         {"device", document.device},
         {"test", document.test},
         {"guarantee", to_string(run.guarantee)},
         {"frame_ms", distribution_json(summary.frame_ms)},
         {"speedup_vs_frustum", number(summary.speedup_vs_frustum)},
         {"slowest_vs_frustum", number(summary.slowest_vs_frustum)},
         {"ratio_to_opt", number(summary.ratio_to_opt)},
         {"ratio_to_ideal", number(summary.ratio_to_ideal)},
         {"per_frame",
          counters_json(summary.total, summary.wait_ms, summary.read_ms, summary.cull_cpu_ms,
                        [&](uint64_t count) { return number(summary.per_frame(count)); })},
         {"overdraw_items_vs_exact", number(summary.overdraw_items_vs_exact)},
         {"differing_pixels", if_verified(summary.verified, summary.differing_pixels)},
         {"differing_frames", if_verified(summary.verified, summary.differing_frames)},
         {"tied_pixels", if_verified(summary.verified, summary.tied_pixels)},
         {"compared_frames", summary.compared_frames},
         {"decision_hash", hash_text(summary.decision_hash)},
         {"decision_hash_reproducible",
          (document.deterministic() || !run.polled) && !run.asked_time}});
}

Json preparation_json(const Preparation& preparation)
{
    return Json::object({{"load_seconds", number(preparation.load_seconds)},
                         {"hierarchy_seconds", number(preparation.hierarchy_seconds)},
                         {"tree_update_ms", number(preparation.tree_update_ms)},
                         {"uncut_triangles", preparation.uncut_triangles}});
}

Json evidence_json(const BenchDocument& document)
{
    const Evidence evidence = evidence_of(document.runs);
    return Json::object({{"frames", evidence.frames},
                         {"empty_frames", evidence.empty_frames},
                         {"hiding_frames", evidence.hiding_frames}});
}

Json coincident_json(const BenchDocument& document)
{
    Json list = Json::array();
    for (const CoincidentObjects& pair : document.coincident) {
        list.push_back(Json::object(
            {{"objects", Json::array({pair.first, pair.second})}, {"pixels", pair.pixels}}));
    }
    return list;
}

Json document_json(const BenchDocument& document, Detail detail)
{
    Json runs = Json::array();
    for (const AlgorithmRun& run : document.runs) {
        Json json = run_json(run, document);
        if (detail == Detail::frames) {
            Json frames = Json::array();
            for (const FrameFigures& frame : run.frames) {
                frames.push_back(frame_json(frame));
            }
            json.set("frames", std::move(frames));
        }
        runs.push_back(std::move(json));
    }
    return Json::object({{"version", 1},
                         {"scene", Json::object({{"name", document.scene},
                                                 {"objects", document.objects},
                                                 {"items", document.items},
                                                 {"triangles", document.triangles},
                                                 {"notes", Json::list(document.load_notes)},
                                                 {"left_out", Json::list(document.load_losses)}})},
                         {"device", Json::object({{"name", document.device},
                                                  {"api", document.api},
                                                  {"renderer", document.renderer},
                                                  {"deterministic", document.deterministic()}})},
                         {"hierarchy", document.hierarchy},
                         {"leaf_triangles", document.leaf_triangles},
                         {"item_triangles", document.item_triangles},
                         {"split", document.split},
                         {"sets", Json::list(document.sets)},
                         {"preparation", preparation_json(document.preparation)},
                         {"path", document.path},
                         {"size", Json::array({document.size.x, document.size.y})},
                         {"samples", document.samples},
                         {"frames", document.frames},
                         {"repeat", document.repeat},
                         {"sample_every", document.sample_every},
                         {"evidence", evidence_json(document)},
                         {"coincident", coincident_json(document)},
                         {"runs", std::move(runs)}});
}

std::string to_text(const Json& json)
{
    constexpr int kIndent = 1;
    return json.dump(kIndent) + "\n";
}

} // namespace

std::string json_report(std::span<const BenchDocument> documents)
{
    Json json = Json::array();
    for (const BenchDocument& document : documents) {
        json.push_back(document_json(document, Detail::frames));
    }
    return to_text(documents.size() == 1 ? json.at(size_t{0}) : json);
}

std::string suite_report(const std::string& suite, const std::string& scale,
                         std::span<const BenchDocument> documents)
{
    Json list = Json::array();
    for (const BenchDocument& document : documents) {
        Json entry = Json::object({{"entry", document.entry}, {"date", document.date}});
        entry.update(document_json(document, Detail::sums));
        list.push_back(std::move(entry));
    }
    return to_text(Json::object(
        {{"version", 1}, {"suite", suite}, {"scale", scale}, {"documents", std::move(list)}}));
}

} // namespace occlude::tools
