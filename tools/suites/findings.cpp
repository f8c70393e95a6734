#include "suites/findings.h"

#include "report/table.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace occlude::tools {

namespace {

// Means, like the totals of the papers: frames that take long have the weight of their time.
constexpr std::string_view kTime = "frame_ms.mean";
constexpr std::string_view kTriangles = "per_frame.triangles_drawn";
// A ratio this close to another one counts as equal to it.
constexpr double kAbout = 1.25;

double figure_of(const EntryResult& entry, std::string_view run, std::string_view figure)
{
    const RunResult* found = entry.run(run);
    return found != nullptr ? (*found)[figure] : std::numeric_limits<double>::quiet_NaN();
}

double ratio_of(const EntryResult& entry, std::string_view figure, std::string_view a,
                std::string_view b)
{
    return figure_of(entry, a, figure) / figure_of(entry, b, figure);
}

// Milliseconds per triangle of `frustum`: the price of drawing on this machine.
double ms_per_triangle(const EntryResult& entry)
{
    return figure_of(entry, "frustum", kTime) / figure_of(entry, "frustum", kTriangles);
}

double draw_share(const EntryResult& entry, std::string_view run)
{
    return ms_per_triangle(entry) * figure_of(entry, run, kTriangles) /
           figure_of(entry, run, kTime);
}

// How often a run checks what is visible: tests, or cells whose pixels were read.
double looks_of(const EntryResult& entry, std::string_view run)
{
    return figure_of(entry, run, "per_frame.queries") +
           figure_of(entry, run, "per_frame.depth_reads");
}

std::string percent(double share)
{
    return fmt::format("{:.0f}%", 100.0 * share);
}

// "`a` draws fewer triangles, but ...": time falls short although the counters do not.
std::string where_the_time_goes(const EntryResult& entry, std::string_view run)
{
    struct Part {
        std::string_view figure;
        std::string_view name;
    };
    static constexpr std::array<Part, 3> kParts{
        Part{"per_frame.wait_ms", "waiting for answers"},
        Part{"per_frame.read_ms", "reading depth back"},
        Part{"per_frame.cull_cpu_ms", "the algorithm's own work on the CPU"}};
    const double time = figure_of(entry, run, kTime);
    const double drawing = draw_share(entry, run);
    std::string text = fmt::format("Of a frame of `{}` about {} is drawing at `frustum`'s price "
                                   "per triangle",
                                   run, percent(std::min(drawing, 1.0)));
    for (const Part& part : kParts) {
        const double share = figure_of(entry, run, part.figure) / figure_of(entry, run, kTime);
        if (share >= 0.1) {
            text += fmt::format(", {} {}", percent(share), part.name);
        }
    }
    const double looks = looks_of(entry, run);
    if (looks >= 1.0 && drawing < 0.9) {
        text += fmt::format("; with {} tests a frame, all that is not drawing costs as much per "
                            "test as {} triangles",
                            readable(looks),
                            readable((1.0 - drawing) * time / looks / ms_per_triangle(entry)));
    }
    return text + '.';
}

std::string why_short_of_frustum(const EntryResult& entry, std::string_view fast, double wanted)
{
    const double limit = ratio_of(entry, kTime, "frustum", "ideal");
    if (limit < wanted) {
        return fmt::format("The scene sets the limit: `ideal`, which is told what is visible and "
                           "tests nothing, is {} times as fast as `frustum`.",
                           readable(limit));
    }
    const double triangles = ratio_of(entry, kTriangles, "frustum", fast);
    const double possible = ratio_of(entry, kTriangles, "frustum", "opt");
    if (triangles >= wanted) {
        return fmt::format("Triangles fall by the published factor and more ({}), time does not. ",
                           readable(triangles)) +
               where_the_time_goes(entry, fast);
    }
    if (possible < wanted * kAbout) {
        return fmt::format("The leaves that are visible at all hold so much that triangles can "
                           "fall {}-fold at most (`opt`); `{}` makes it {}. ",
                           readable(possible), fast, readable(triangles)) +
               where_the_time_goes(entry, fast);
    }
    return fmt::format("Triangles fall {}-fold where {}-fold was possible (`opt`): what was seen "
                       "lately stays drawn. ",
                       readable(triangles), readable(possible)) +
           where_the_time_goes(entry, fast);
}

std::string why_short_of_other(const EntryResult& entry, std::string_view slow,
                               std::string_view fast, double wanted)
{
    const double looks = looks_of(entry, slow) / looks_of(entry, fast);
    const double triangles = ratio_of(entry, kTriangles, slow, fast);
    // Drawing the visible items costs both the same: their pixels are shaded in software here.
    const double floor = figure_of(entry, "ideal", kTime);
    const double above =
        (figure_of(entry, slow, kTime) - floor) / (figure_of(entry, fast, kTime) - floor);
    if (above >= wanted) {
        return fmt::format("Tests fall {}-fold. {} ms of both are what `ideal` takes to draw the "
                           "visible pixels in software; what is above that falls {}-fold.",
                           readable(looks), readable(floor), readable(above));
    }
    const double drawing = draw_share(entry, slow);
    if (looks >= wanted && 1.0 / drawing < wanted * kAbout) {
        return fmt::format("Tests fall {}-fold; but {} of a frame of `{}` is drawing what is "
                           "visible, which remains.",
                           readable(looks), percent(std::min(drawing, 1.0)), slow);
    }
    return fmt::format("Against `{}`, `{}` makes {} times fewer tests and draws {} times as many "
                       "triangles. ",
                       slow, fast, readable(looks), readable(1.0 / triangles)) +
           where_the_time_goes(entry, fast);
}

} // namespace

bool Target::judges() const
{
    return !std::isnan(at_least) || !std::isnan(at_most);
}

bool Target::reached_by(double value) const
{
    return !(value < at_least) && !(value > at_most) && !std::isnan(value);
}

std::string readable(double value)
{
    if (!std::isfinite(value)) {
        return "-";
    }
    const double size = std::abs(value);
    if (size >= 1e15) { // beyond what a double counts
        return fmt::format("{:.3g}", value);
    }
    if (size >= 1000.0) {
        return fmt::format("{}{}", value < 0.0 ? "-" : "",
                           grouped(static_cast<uint64_t>(std::llround(size))));
    }
    return fmt::format("{:.{}f}", value, size >= 100.0 ? 0 : (size >= 10.0 ? 1 : 2));
}

Finding time_ratio(const EntryResult& entry, std::string_view slow, std::string_view fast,
                   const Target& target)
{
    Finding finding;
    finding.value = ratio_of(entry, kTime, slow, fast);
    if (std::isnan(finding.value)) {
        return finding;
    }
    finding.ours = fmt::format("{} ms / {} ms = **{}**", readable(figure_of(entry, slow, kTime)),
                               readable(figure_of(entry, fast, kTime)), readable(finding.value));
    finding.counters =
        fmt::format("triangles {}", readable(ratio_of(entry, kTriangles, slow, fast)));
    const double looks = looks_of(entry, slow) / looks_of(entry, fast);
    if (std::isfinite(looks) && looks > 0.0) {
        finding.counters += fmt::format(", tests {}", readable(looks));
    }
    if (target.judges() && finding.value < target.at_least) {
        finding.why = slow == "frustum" ? why_short_of_frustum(entry, fast, target.at_least)
                                        : why_short_of_other(entry, slow, fast, target.at_least);
    } else if (target.judges() && finding.value > target.at_most) {
        finding.why = fmt::format(
            "More than published: `{}` draws {} times as many triangles and makes {} times as many "
            "tests.",
            slow, readable(ratio_of(entry, kTriangles, slow, fast)), readable(looks));
    }
    return finding;
}

Finding counter_ratio(const EntryResult& entry, std::string_view counter, std::string_view more,
                      std::string_view less, const Target& target)
{
    const std::string figure = fmt::format("per_frame.{}", counter);
    Finding finding;
    finding.value = ratio_of(entry, figure, more, less);
    if (!std::isfinite(finding.value)) {
        return finding;
    }
    finding.ours = fmt::format("{} / {} = **{}**", readable(figure_of(entry, more, figure)),
                               readable(figure_of(entry, less, figure)), readable(finding.value));
    finding.counters = "this is one";
    if (!target.judges() || target.reached_by(finding.value)) {
        return finding;
    }
    const double best = ratio_of(entry, figure, more, "opt");
    const bool of_drawing = counter == "triangles_drawn" || counter == "items_drawn";
    if (of_drawing && finding.value < target.at_least && std::isfinite(best)) {
        finding.why =
            best < target.at_least
                ? fmt::format("The scene sets the limit: drawing nothing but the visible leaves "
                              "(`opt`) makes it {}.",
                              readable(best))
                : fmt::format("{} was possible (`opt`): boxes are looser than what is in them.",
                              readable(best));
    } else {
        finding.why = fmt::format("Per item drawn, `{}` counts {} of them here and `{}` {}.", more,
                                  readable(figure_of(entry, more, figure) /
                                           figure_of(entry, more, "per_frame.items_drawn")),
                                  less,
                                  readable(figure_of(entry, less, figure) /
                                           figure_of(entry, less, "per_frame.items_drawn")));
    }
    return finding;
}

Finding time_share(const EntryResult& entry, std::string_view part, std::string_view run)
{
    Finding finding;
    finding.value =
        figure_of(entry, run, fmt::format("per_frame.{}", part)) / figure_of(entry, run, kTime);
    if (!std::isfinite(finding.value)) {
        return finding;
    }
    finding.ours = fmt::format("**{}** of `{}`", percent(finding.value), run);
    finding.counters = fmt::format("{} tests a frame", readable(looks_of(entry, run)));
    return finding;
}

Finding test_cost_in_triangles(const EntryResult& entry, std::string_view run)
{
    Finding finding;
    const double looks = looks_of(entry, run);
    const double rest = figure_of(entry, run, kTime) * (1.0 - draw_share(entry, run));
    finding.value = rest / looks / ms_per_triangle(entry);
    if (!std::isfinite(finding.value)) {
        return finding;
    }
    finding.ours = fmt::format("**{}** triangles", readable(finding.value));
    finding.counters = fmt::format("{} tests a frame", readable(looks));
    return finding;
}

} // namespace occlude::tools
