#include "report/html_report.h"

#include "measure/verify.h"
#include "report/chart_js.h"
#include "report/json_report.h"
#include "report/table.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace occlude::tools {

namespace {

constexpr const char* kStyle = R"(
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem;
       color: #1b1f24; background: #fff; }
h1 { font-size: 1.6rem; } h2 { margin-top: 2.5rem; }
table { border-collapse: collapse; width: 100%; margin: 1rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .6rem; text-align: right; border-bottom: 1px solid #d8dee4; }
th:first-child, td:first-child { text-align: left; }
dl { display: grid; grid-template-columns: max-content auto; gap: .1rem 1rem; }
dt { color: #57606a; } dd { margin: 0; }
.bad { color: #b3261e; font-weight: 600; } .good { color: #1a7f37; }
figure { margin: 1.5rem 0; } figcaption { color: #57606a; }
.plot { position: relative; height: 22rem; }
.wide { overflow-x: auto; } .wide th, .wide td { white-space: nowrap; }
)";

// Draws the two plots of every document from the JSON that is in the page.
constexpr const char* kScript = R"(
const parsed = JSON.parse(document.getElementById('occlude-data').textContent);
const documents = Array.isArray(parsed) ? parsed : [parsed];
const colors = ['#6e7781', '#0969da', '#bf3989', '#1a7f37', '#bc4c00', '#8250df', '#9a6700',
                '#0a3069', '#cf222e', '#116329', '#e16f24', '#6639ba', '#1b7c83', '#953800',
                '#db61a2', '#57606a'];
Chart.defaults.animation = false;
documents.forEach((doc, index) => {
  const runs = doc.runs.filter(run => run.frame_ms.median !== null);
  if (runs.length === 0) { return; }
  const several = runs.some(run => run.hierarchy !== runs[0].hierarchy);
  const label = run => run.algorithm + (several ? ' on ' + run.hierarchy : '');
  new Chart(document.getElementById('bars-' + index), {
    type: 'bar',
    data: { labels: runs.map(label),
            datasets: [
              { label: 'median', data: runs.map(run => run.frame_ms.median),
                backgroundColor: runs.map((_, i) => colors[i % colors.length]) },
              { label: '99th percentile', data: runs.map(run => run.frame_ms.p99),
                backgroundColor: '#d0d7de' }] },
    options: { maintainAspectRatio: false, indexAxis: 'y',
               scales: { x: { beginAtZero: true, title: { display: true, text: 'ms per frame' } } } }
  });
  new Chart(document.getElementById('lines-' + index), {
    type: 'line',
    data: { labels: runs[0].frames.map(frame => frame.frame),
            datasets: runs.map((run, i) => ({
              label: label(run), data: run.frames.map(frame => frame.frame_ms),
              borderColor: colors[i % colors.length],
              backgroundColor: colors[i % colors.length], borderWidth: 1.5, pointRadius: 0 })) },
    options: { maintainAspectRatio: false, interaction: { mode: 'index', intersect: false },
               scales: { x: { title: { display: true, text: 'frame' } },
                         y: { beginAtZero: true, title: { display: true, text: 'ms' } } } }
  });
});
)";

std::string figure(double value, int decimals)
{
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "&ndash;";
}

std::string cell(std::string_view content)
{
    return fmt::format("<td>{}</td>", content);
}

std::string pixels_cell(const Summary& summary)
{
    if (!summary.verified) {
        return cell("not compared");
    }
    const bool equal = summary.differing_pixels == 0;
    return fmt::format("<td class=\"{}\">{}</td>", equal ? "good" : "bad",
                       grouped(summary.differing_pixels));
}

std::string run_row(const AlgorithmRun& run, bool with_hierarchy)
{
    const Summary s = summarise(run);
    const auto per_frame = [&](uint64_t total) { return cell(figure(s.per_frame(total), 1)); };
    return "<tr>" + cell(html_escaped(run_label(run, with_hierarchy))) +
           cell(to_string(run.guarantee)) + cell(figure(s.frame_ms.median, 2)) +
           cell(figure(s.frame_ms.p99, 2)) + cell(figure(s.speedup_vs_frustum, 2)) +
           cell(figure(s.ratio_to_opt, 2)) + cell(figure(s.ratio_to_ideal, 2)) +
           per_frame(s.total.queries) + per_frame(s.total.boxes) +
           per_frame(s.total.multiqueries_failed) + per_frame(s.total.state_changes) +
           per_frame(s.total.draw_calls) + per_frame(s.total.items_drawn) +
           per_frame(s.total.triangles_drawn) + per_frame(s.total.waits) +
           cell(figure(s.wait_ms, 2)) + cell(figure(s.cull_cpu_ms, 2)) + pixels_cell(s) + "</tr>\n";
}

std::string runs_table(const BenchDocument& document)
{
    constexpr std::array<const char*, 18> kHeadings = {
        "algorithm", "promise",   "median ms", "p99 ms",       "speed-up",      "vs opt",
        "vs ideal",  "queries",   "boxes",     "failed multi", "state changes", "draw calls",
        "items",     "triangles", "waits",     "wait ms",      "cull CPU ms",   "differing px"};
    std::string html = "<div class=\"wide\"><table><thead><tr>";
    for (const char* heading : kHeadings) {
        html += fmt::format("<th>{}</th>", heading);
    }
    html += "</tr></thead><tbody>\n";
    const bool several = on_several_hierarchies(document.runs);
    for (const AlgorithmRun& run : document.runs) {
        html += run_row(run, several);
    }
    return html + "</tbody></table></div>\n<p>Counters are means per frame. Speed-up is against "
                  "<i>frustum</i>; the ratios are times against <i>opt</i> (the visible leaves "
                  "known beforehand) and <i>ideal</i> (the visible items known beforehand); all "
                  "three are formed per frame, then the median is taken.</p>\n";
}

// "1 frame", "24 frames".
std::string counted(size_t count, std::string_view thing)
{
    return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string environment(const BenchDocument& d)
{
    const std::string measured =
        d.sample_every > 1 ? fmt::format(", one in {} measured", d.sample_every) : "";
    const auto entry = [](std::string_view name, std::string_view value) {
        return fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, html_escaped(value));
    };
    return "<dl>\n" +
           entry("scene", fmt::format("{} objects, {} items, {} triangles", grouped(d.objects),
                                      grouped(d.items), grouped(d.triangles))) +
           entry("path", d.path + ", " + counted(d.frames, "frame") + measured + ", walked " +
                             counted(d.repeat, "time")) +
           entry("image", fmt::format("{} x {}, {} a pixel", d.size.x, d.size.y,
                                      counted(static_cast<size_t>(d.samples), "sample"))) +
           entry("device", fmt::format("{}: {}", d.api, d.renderer)) +
           entry("hierarchy", d.hierarchy) + entry("test", d.test) + "</dl>\n";
}

std::string list_of_differences(const AlgorithmRun& run)
{
    constexpr size_t kMaxLines = 20;
    std::string items;
    for (const std::string& line : describe_differences(run, kMaxLines)) {
        items += "<li>" + html_escaped(line) + "</li>\n";
    }
    return items.empty() ? "" : "<ul>\n" + items + "</ul>\n";
}

// What differs although it must not stands open; what may differ can be unfolded.
std::string differences(const BenchDocument& document)
{
    std::string broken;
    std::string allowed;
    for (const AlgorithmRun& run : document.runs) {
        const bool exact = run.guarantee.kind == Guarantee::Kind::exact;
        (exact ? broken : allowed) += list_of_differences(run);
    }
    std::string html = broken.empty() ? "" : "<h3>Differences</h3>\n" + broken;
    if (!allowed.empty()) {
        html += "<details><summary>Differences of algorithms that are not exact</summary>\n" +
                allowed + "</details>\n";
    }
    return html;
}

// The name a reader looks for: the entry of a suite, or else the scene.
std::string title(const BenchDocument& document)
{
    const std::string scene =
        fmt::format("{}, path {}", html_escaped(document.scene), html_escaped(document.path));
    return document.entry.empty() ? scene
                                  : fmt::format("{}: {}", html_escaped(document.entry), scene);
}

// Links to the sections, where there are several.
std::string contents(std::span<const BenchDocument> documents)
{
    if (documents.size() < 2) {
        return "";
    }
    std::string items;
    for (size_t i = 0; i < documents.size(); ++i) {
        items += fmt::format("<li><a href=\"#section-{}\">{}</a></li>\n", i, title(documents[i]));
    }
    return "<ul>\n" + items + "</ul>\n";
}

std::string section(const BenchDocument& document, size_t index)
{
    return fmt::format("<h2 id=\"section-{}\">{}</h2>\n{}"
                       "<figure><div class=\"plot\"><canvas id=\"bars-{}\"></canvas></div>"
                       "<figcaption>Time of a frame, by algorithm</figcaption></figure>\n"
                       "<figure><div class=\"plot\"><canvas id=\"lines-{}\"></canvas></div>"
                       "<figcaption>Time of every frame along the path</figcaption></figure>\n",
                       index, title(document), environment(document), index, index) +
           runs_table(document) + differences(document);
}

// JSON inside a script element must not end it.
std::string json_for_script(std::span<const BenchDocument> documents)
{
    std::string json = json_report(documents);
    for (size_t at = 0; (at = json.find("</", at)) != std::string::npos; at += 3) {
        json.insert(at + 1, 1, '\\');
    }
    return json;
}

} // namespace

std::string html_escaped(std::string_view text)
{
    std::string escaped;
    for (const char c : text) {
        switch (c) {
        case '&':
            escaped += "&amp;";
            break;
        case '<':
            escaped += "&lt;";
            break;
        case '>':
            escaped += "&gt;";
            break;
        case '"':
            escaped += "&quot;";
            break;
        default:
            escaped += c;
        }
    }
    return escaped;
}

std::string html_report(std::span<const BenchDocument> documents)
{
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                       "<meta name=\"viewport\" content=\"width=device-width\">\n"
                       "<title>occlude: occlusion culling measured</title>\n<style>";
    html += kStyle;
    html += "</style></head><body>\n<h1>Occlusion culling, measured</h1>\n" + contents(documents);
    for (size_t i = 0; i < documents.size(); ++i) {
        html += section(documents[i], i);
    }
    html += "<script type=\"application/json\" id=\"occlude-data\">" + json_for_script(documents) +
            "</script>\n<script>";
    html += chart_js();
    html += "</script>\n<script>";
    html += kScript;
    html += "</script>\n</body></html>\n";
    return html;
}

} // namespace occlude::tools
