#include "suites/papers_report.h"

#include "report/table.h"
#include "suites/published_figures.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

namespace occlude::tools {

namespace {

// A published figure with ours.
struct Row {
    const PublishedFigure* figure = nullptr;
    Finding finding;

    bool measured() const { return !std::isnan(finding.value); }
    bool reached() const { return figure->target.reached_by(finding.value); }
    bool judged() const { return measured() && figure->target.judges(); }
};

std::vector<Row> rows_of(const SuiteResults& results, std::string_view paper)
{
    std::vector<Row> rows;
    for (const PublishedFigure& figure : published_figures()) {
        if (figure.paper == paper) {
            rows.push_back({&figure, figure.find(results, figure.target)});
        }
    }
    return rows;
}

std::string target_text(const Target& target)
{
    if (!target.judges()) {
        return "";
    }
    if (std::isnan(target.at_most)) {
        return fmt::format("at least {}", readable(target.at_least));
    }
    if (std::isnan(target.at_least)) {
        return fmt::format("at most {}", readable(target.at_most));
    }
    return fmt::format("{} to {}", readable(target.at_least), readable(target.at_most));
}

std::string verdict(const Row& row)
{
    if (!row.measured()) {
        return "not measured";
    }
    if (!row.judged()) {
        return "";
    }
    return row.reached() ? "yes"
                         : (row.finding.value > row.figure->target.at_most ? "above" : "**short**");
}

std::string paper_section(const Paper& paper, const std::vector<Row>& rows)
{
    std::string text = fmt::format("## {}\n\n{}. {}\n\n"
                                   "| scene | figure | published | ours | same ratio in counters | "
                                   "wanted | reached |\n|---|---|---|---|---|---|---|\n",
                                   paper.key, paper.citation, paper.setting);
    std::string reasons;
    for (const Row& row : rows) {
        text += fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", row.figure->scene,
                            row.figure->what, row.figure->published,
                            row.measured() ? row.finding.ours : "-", row.finding.counters,
                            target_text(row.figure->target), verdict(row));
        if (row.measured() && !row.finding.why.empty()) {
            reasons += fmt::format("- *{}, {}*: {}\n", row.figure->scene, row.figure->what,
                                   row.finding.why);
        }
    }
    return reasons.empty() ? text + '\n'
                           : text + "\nWhere ours differs, and why:\n\n" + reasons + '\n';
}

std::string tally(const SuiteResults& results)
{
    size_t reached = 0;
    size_t judged = 0;
    size_t missing = 0;
    for (const PublishedFigure& figure : published_figures()) {
        const Row row{&figure, figure.find(results, figure.target)};
        judged += row.judged() ? 1 : 0;
        reached += row.judged() && row.reached() ? 1 : 0;
        missing += row.measured() ? 0 : 1;
    }
    std::string text =
        fmt::format("Of {} figures with something to reach, {} are reached. ", judged, reached);
    return missing == 0 ? text : text + fmt::format("{} were not measured. ", missing);
}

std::string run_row(const EntryResult& entry, const RunResult& run)
{
    const auto counter = [&](const char* name) {
        return readable(run[fmt::format("per_frame.{}", name)]);
    };
    const RunResult* frustum = entry.run("frustum");
    const double gain = frustum != nullptr ? (*frustum)["frame_ms.median"] / run["frame_ms.median"]
                                           : std::numeric_limits<double>::quiet_NaN();
    const double differing = run["differing_pixels"];
    return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", run.algorithm,
                       readable(run["frame_ms.median"]), readable(gain), counter("triangles_drawn"),
                       counter("items_drawn"), counter("queries"), counter("cells_asked"),
                       counter("state_changes"),
                       std::isnan(differing) ? "-"
                                             : fmt::format("{:.0f} in {:.0f} frames", differing,
                                                           run["compared_frames"]));
}

std::string entry_section(const EntryResult& entry)
{
    std::string sets;
    for (const std::string& set : entry.sets) {
        sets += fmt::format("{}`{}`", sets.empty() ? "; options " : ", ", set);
    }
    std::string text = fmt::format(
        "### {}\n\n`{}`, {} objects, {} items, {} triangles; path `{}`, {:.0f} frames, every {} "
        "measured; {}; tree `{}` with leaves of up to {:.0f} triangles and meshes in items of up "
        "to {:.0f} (`--split {}`){}. {}.\n\n"
        "| algorithm | ms | gain | triangles | items | queries | cells | state changes | differing "
        "pixels |\n|---|---|---|---|---|---|---|---|---|\n",
        entry.name, entry.scene, readable(entry["scene.objects"]), readable(entry["scene.items"]),
        readable(entry["scene.triangles"]), entry.path, entry["frames"],
        entry["sample_every"] > 1.0 ? fmt::format("{:.0f}th", entry["sample_every"]) : "one",
        entry.size, entry.hierarchy, entry["leaf_triangles"], entry["item_triangles"], entry.split,
        sets, entry.date);
    for (const RunResult& run : entry.runs) {
        text += run_row(entry, run);
    }
    return text + '\n';
}

std::string devices(const SuiteResults& results)
{
    std::set<std::string> devices;
    for (const EntryResult& entry : results.entries) {
        devices.insert(entry.device);
    }
    return fmt::format("{}", fmt::join(devices, "; "));
}

} // namespace

std::string papers_report(const SuiteResults& results)
{
    std::string text = fmt::format(
        "# The papers' figures, and ours\n\n"
        "Written by `occlude bench --suite papers --scale {}`; not by hand. Scale: **{}** ({}). "
        "Device: {}.\n\n{}"
        "Times are means over the measured frames, as in the papers (or totals), algorithms "
        "interleaved frame by frame in one run; between them, all algorithms that remember frames "
        "cull the whole path. Ratios of "
        "counters carry over to other machines where milliseconds do not. `frustum`, their "
        "common denominator, has the same renderer, sorting and tree. Images are compared on a "
        "part of the measured frames, as the tables of the runs say.\n\n",
        results.scale, results.scale,
        results.scale == "full" ? "scenes as large as published"
                                : "smaller scenes than published, for a run of minutes; occlusion "
                                  "grows with the scene, so ratios fall short of full scale",
        devices(results), tally(results));
    for (const Paper& paper : papers()) {
        text += paper_section(paper, rows_of(results, paper.key));
    }
    text += "## The runs\n\nMedian milliseconds, mean counters per frame; *gain* is the time of "
            "`frustum` "
            "over that of the algorithm.\n\n";
    for (const EntryResult& entry : results.entries) {
        text += entry_section(entry);
    }
    while (text.ends_with("\n\n")) {
        text.pop_back();
    }
    return text;
}

} // namespace occlude::tools
