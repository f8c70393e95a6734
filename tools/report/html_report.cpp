#include "report/html_report.h"

#include "measure/verify.h"
#include "report/headline.h"
#include "report/html_text.h"
#include "report/json_report.h"
#include "report/page_parts.h"
#include "report/table.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace occlude::tools {

namespace {

// A figure that the JSON holds, too: `key` leads to it from its run. The script of the tests
// compares both.
std::string figure(std::string_view tag, size_t run, std::string_view key, double value,
                   int decimals)
{
    const std::string text =
        std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "&ndash;";
    return fmt::format("<{0} data-run=\"{1}\" data-key=\"{2}\">{3}</{0}>", tag, run, key, text);
}

std::string figure_cell(size_t run, std::string_view key, double value, int decimals)
{
    return figure("td", run, key, value, decimals);
}

std::string pixels_cell(size_t run, const Summary& summary)
{
    if (!summary.verified) {
        return "<td>not compared</td>";
    }
    const bool equal = summary.differing_pixels == 0;
    return fmt::format("<td data-run=\"{}\" data-key=\"differing_pixels\" class=\"{}\">{}</td>",
                       run, equal ? "good" : "bad", grouped(summary.differing_pixels));
}

std::string headings(std::span<const char* const> names)
{
    std::string html = "<thead><tr>";
    for (const char* name : names) {
        html += fmt::format("<th>{}</th>", name);
    }
    return html + "</tr></thead><tbody>\n";
}

// The first sentence, for a reader who reads no other.
std::string headline(const BenchDocument& document, std::optional<size_t> chosen)
{
    constexpr double kPays = 1.05;
    if (!chosen) {
        return "<p class=\"headline\">No exact algorithm was timed beside frustum culling.</p>\n";
    }
    const AlgorithmRun& run = document.runs[*chosen];
    const Summary summary = summarise(run);
    const std::string speed =
        figure("b", *chosen, "speedup_vs_frustum", summary.speedup_vs_frustum, 2);
    std::string html = fmt::format(
        "<p class=\"headline\">On {}, on this machine, <b>{}</b> draws the same pixels {} times as "
        "fast as frustum culling",
        html_escaped(document.scene),
        html_escaped(run_label(run, on_several_hierarchies(document.runs))), speed);
    if (const auto ideal = ideal_run(document, *chosen)) {
        html += fmt::format("; the limit is {}",
                            figure("b", *ideal, "speedup_vs_frustum",
                                   summarise(document.runs[*ideal]).speedup_vs_frustum, 2));
    }
    html += summary.speedup_vs_frustum < kPays ? ". Culling does not pay here." : ".";
    if (!summary.verified) {
        html += " The pixels are promised; <code>--verify</code> compares them.";
    } else if (summary.differing_pixels == 0) {
        html += fmt::format(" All pixels of {} were compared: none differs.",
                            counted(summary.compared_frames, "frame"));
    } else {
        html += fmt::format(" <span class=\"bad\">But {} pixels differ.</span>",
                            grouped(summary.differing_pixels));
    }
    return html + "</p>\n";
}

std::string brief_table(const BenchDocument& document, std::optional<size_t> chosen)
{
    constexpr std::array<const char*, 5> kHeadings = {"algorithm", "ms a frame", "speed-up",
                                                      "time / ideal", "differing pixels"};
    std::string html = "<div class=\"wide\"><table class=\"brief\">" + headings(kHeadings);
    const bool several = on_several_hierarchies(document.runs);
    for (size_t i = 0; i < document.runs.size(); ++i) {
        const Summary s = summarise(document.runs[i]);
        html += fmt::format("<tr{}><th>{}</th>", i == chosen ? " class=\"chosen\"" : "",
                            html_escaped(run_label(document.runs[i], several))) +
                figure_cell(i, "frame_ms.median", s.frame_ms.median, 2) +
                figure_cell(i, "speedup_vs_frustum", s.speedup_vs_frustum, 2) +
                figure_cell(i, "ratio_to_ideal", s.ratio_to_ideal, 2) + pixels_cell(i, s) +
                "</tr>\n";
    }
    return html + "</tbody></table></div>\n"
                  "<p class=\"note\">Milliseconds are medians. The speed-up is against "
                  "<i>frustum</i>, which draws all that is in view; <i>ideal</i> draws what owns a "
                  "pixel, known beforehand, and <i>opt</i> the visible leaves of the tree.</p>\n";
}

std::string counters_row(const AlgorithmRun& run, size_t i, bool with_hierarchy)
{
    const Summary s = summarise(run);
    const auto mean = [&](const char* counter, uint64_t total) {
        return figure_cell(i, fmt::format("per_frame.{}", counter), s.per_frame(total), 1);
    };
    return fmt::format("<tr><th>{}</th><td>{}</td>", html_escaped(run_label(run, with_hierarchy)),
                       to_string(run.guarantee)) +
           figure_cell(i, "frame_ms.median", s.frame_ms.median, 2) +
           figure_cell(i, "frame_ms.p99", s.frame_ms.p99, 2) +
           figure_cell(i, "frame_ms.max", s.frame_ms.max, 2) +
           figure_cell(i, "ratio_to_opt", s.ratio_to_opt, 2) + mean("queries", s.total.queries) +
           mean("boxes", s.total.boxes) + mean("multiqueries_failed", s.total.multiqueries_failed) +
           mean("state_changes", s.total.state_changes) + mean("draw_calls", s.total.draw_calls) +
           mean("items_drawn", s.total.items_drawn) +
           mean("triangles_drawn", s.total.triangles_drawn) + mean("waits", s.total.waits) +
           figure_cell(i, "per_frame.wait_ms", s.wait_ms, 2) +
           figure_cell(i, "per_frame.cull_cpu_ms", s.cull_cpu_ms, 2) + "</tr>\n";
}

std::string counters_table(const BenchDocument& document)
{
    constexpr std::array<const char*, 16> kHeadings = {
        "algorithm", "promise", "median ms",     "p99 ms",        "max ms",     "time / opt",
        "queries",   "boxes",   "failed multi.", "state changes", "draw calls", "items",
        "triangles", "waits",   "wait ms",       "cull CPU ms"};
    std::string html =
        "<details class=\"counters\"><summary>All counters, means per frame</summary>"
        "\n<div class=\"wide\" tabindex=\"0\"><table>" +
        headings(kHeadings);
    const bool several = on_several_hierarchies(document.runs);
    for (size_t i = 0; i < document.runs.size(); ++i) {
        html += counters_row(document.runs[i], i, several);
    }
    return html + "</tbody></table></div></details>\n";
}

std::string plots(size_t index, const std::string& chosen)
{
    constexpr std::array<std::array<const char*, 2>, 5> kPlots = {
        {{"time", "Time of every frame along the path"},
         {"ratio", "Time against the ideal: 1 is the limit"},
         {"queries", "Occlusion queries of every frame"},
         {"triangles", "Triangles drawn in every frame"},
         {"distribution", "How many frames take how long"}}};
    std::string html = fmt::format("<div id=\"plots-{0}\" data-chosen=\"{1}\">\n<div "
                                   "class=\"toggles\" id=\"toggles-{0}\"></div>\n",
                                   index, html_escaped(chosen));
    for (const auto& [id, caption] : kPlots) {
        html += fmt::format("<figure><figcaption>{1}</figcaption><div class=\"plot\">"
                            "<canvas id=\"{0}-{2}\" role=\"img\" aria-label=\"{1}\"></canvas>"
                            "</div></figure>\n",
                            id, caption, index);
    }
    return html + "</div>\n";
}

std::string pictures(const BenchDocument& document)
{
    std::string html;
    for (const FramePicture& picture : document.pictures) {
        html += fmt::format("<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\">"
                            "<figcaption>{0}</figcaption></figure>\n",
                            html_escaped(fmt::format("Frame {}, {}: {}", picture.frame,
                                                     picture.algorithm, picture.caption)),
                            base64(picture.png));
    }
    return html.empty() ? html : "<div class=\"pictures\">\n" + html + "</div>\n";
}

// The frames in which the chosen run gains least, with pictures of the worst.
std::string worst(const BenchDocument& document, size_t run)
{
    constexpr size_t kFrames = 3;
    constexpr std::array<const char*, 5> kHeadings = {"frame", "ms", "speed-up", "queries",
                                                      "triangles"};
    const std::vector<FrameFigures>& frames = document.runs[run].frames;
    std::string html = fmt::format("<h3>The worst frames of {}</h3>\n<table>",
                                   html_escaped(run_label(document.runs[run],
                                                          on_several_hierarchies(document.runs)))) +
                       headings(kHeadings);
    for (const size_t place : worst_frames(document.runs[run], kFrames)) {
        const FrameFigures& frame = frames[place];
        const auto key = [&](const char* name) { return fmt::format("frames.{}.{}", place, name); };
        const auto count = [&](const char* name, uint64_t value) {
            return fmt::format("<td data-run=\"{}\" data-key=\"{}\">{}</td>", run, key(name),
                               grouped(value));
        };
        html += fmt::format("<tr><th data-run=\"{}\" data-key=\"{}\">{}</th>", run, key("frame"),
                            frame.frame) +
                figure_cell(run, key("frame_ms"), frame.frame_ms, 2) +
                figure_cell(run, key("speedup_vs_frustum"), frame.speedup_vs_frustum, 2) +
                count("queries", frame.counters.queries) +
                count("triangles_drawn", frame.counters.triangles_drawn) + "</tr>\n";
    }
    return html + "</tbody></table>\n" + pictures(document);
}

std::string environment(const BenchDocument& d)
{
    const std::string measured =
        d.sample_every > 1 ? fmt::format(", one in {} measured", d.sample_every) : "";
    const auto entry = [](std::string_view name, std::string_view value) {
        return fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, html_escaped(value));
    };
    std::string html =
        "<h3>Scene, device and settings</h3>\n<dl>\n" +
        entry("scene", fmt::format("{} objects, {} items, {} triangles", grouped(d.objects),
                                   grouped(d.items), grouped(d.triangles))) +
        entry("path", d.path + ", " + counted(d.frames, "frame") + measured + ", walked " +
                          counted(d.repeat, "time")) +
        entry("image", fmt::format("{} x {}, {} a pixel", d.size.x, d.size.y,
                                   counted(static_cast<size_t>(d.samples), "sample"))) +
        entry("device", fmt::format("{}: {}", d.api, d.renderer)) +
        entry("hierarchy", d.hierarchy) + entry("test", d.test) +
        entry("leaves", fmt::format("of up to {} triangles", grouped(d.leaf_triangles))) +
        entry("items", fmt::format("of up to {} triangles, cut by {}", grouped(d.item_triangles),
                                   d.split.empty() ? "centroid" : d.split));
    for (const std::string& set : d.sets) {
        html += entry("option", set);
    }
    return html + "</dl>\n";
}

std::string method(const BenchDocument& d)
{
    return fmt::format(
        "<details class=\"counters\"><summary>How it was measured</summary>\n<p>Every algorithm "
        "culls every frame of the path with a state of its own. They take turns frame by frame, in "
        "an order that rotates, so that a machine that slows down slows all of them. Shaders are "
        "warmed up first, and a frame ends when the device has finished it. A frame's time is the "
        "median of {}. Speed-ups and ratios are formed frame by frame; the table shows their "
        "medians over all frames.{}</p></details>\n",
        counted(d.repeat, "walk"),
        summarise(d.runs.front()).verified
            ? " In a walk of its own, which is not timed, every pixel is compared with the picture "
              "of frustum culling."
            : "");
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
    const std::optional<size_t> chosen = chosen_run(document);
    std::string html =
        fmt::format("<section data-document=\"{0}\">\n<h2 id=\"section-{0}\">{1}</h2>\n", index,
                    title(document)) +
        headline(document, chosen) + brief_table(document, chosen) + differences(document) +
        plots(index, chosen ? document.runs[*chosen].algorithm : "");
    if (chosen) {
        html += worst(document, *chosen);
    }
    html += environment(document);
    if (!document.runs.empty()) {
        html += method(document) + counters_table(document);
    }
    return html + "</section>\n";
}

} // namespace

std::string html_report(std::span<const BenchDocument> documents)
{
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                       "<meta name=\"viewport\" content=\"width=device-width\">\n"
                       "<title>occlude: occlusion culling measured</title>\n<style>";
    html += report_css();
    html += "</style></head><body>\n<h1>Occlusion culling, measured</h1>\n" + contents(documents);
    for (size_t i = 0; i < documents.size(); ++i) {
        html += section(documents[i], i);
    }
    html += "<p class=\"downloads\"><a class=\"button\" id=\"save-json\" href=\"#\" "
            "download=\"occlude.json\">Raw data (JSON)</a> <a class=\"button\" id=\"save-csv\" "
            "href=\"#\" download=\"occlude.csv\">Every frame (CSV)</a></p>\n"
            "<script type=\"application/json\" id=\"occlude-data\">" +
            json_for_script(json_report(documents)) + "</script>\n<script>";
    html += chart_js();
    html += "</script>\n<script>";
    html += report_js();
    html += "</script>\n</body></html>\n";
    return html;
}

} // namespace occlude::tools
