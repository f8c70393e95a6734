#include "suites/published_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {

namespace {

using Find = std::function<Finding(const SuiteResults&, const Target&)>;

constexpr Target kForComparison{};

constexpr Target at_least(double value)
{
    return {.at_least = value};
}

constexpr Target at_most(double value)
{
    return {.at_most = value};
}

constexpr Target between(double low, double high)
{
    return {.at_least = low, .at_most = high};
}

// The result of `find` for one entry; nothing if it was not run.
template <class FindInEntry>
Find in(std::string entry, FindInEntry find)
{
    return [entry = std::move(entry), find](const SuiteResults& results, const Target& target) {
        const EntryResult* found = results.entry(entry);
        return found != nullptr ? find(*found, target) : Finding{};
    };
}

Find time(std::string entry, std::string slow, std::string fast)
{
    return in(std::move(entry), [slow, fast](const EntryResult& e, const Target& target) {
        return time_ratio(e, slow, fast, target);
    });
}

Find count(std::string entry, std::string counter, std::string more, std::string less)
{
    return in(std::move(entry), [=](const EntryResult& e, const Target& target) {
        return counter_ratio(e, counter, more, less, target);
    });
}

Find share(std::string entry, std::string part, std::string run)
{
    return in(std::move(entry), [part, run](const EntryResult& e, const Target&) {
        return time_share(e, part, run);
    });
}

// A number of the entry itself, in words.
Find preparation(std::string entry, std::string figure, std::string words)
{
    return in(std::move(entry), [figure, words](const EntryResult& e, const Target&) {
        Finding finding;
        finding.value = e["preparation." + figure];
        if (!std::isnan(finding.value)) {
            finding.ours = fmt::format("**{}** {}", readable(finding.value), words);
            finding.counters = fmt::format("{} items", readable(e["scene.items"]));
        }
        return finding;
    });
}

Find growth_by_cutting(std::string entry)
{
    return in(std::move(entry), [](const EntryResult& e, const Target&) {
        const double before = e["preparation.uncut_triangles"];
        Finding finding;
        finding.value = e["scene.triangles"] / before;
        if (std::isfinite(finding.value)) {
            finding.ours = fmt::format("{} / {} = **{:+.0f}%**", readable(e["scene.triangles"]),
                                       readable(before), 100.0 * (finding.value - 1.0));
            finding.counters =
                fmt::format("{} parts per object", readable(e["scene.items"] / e["scene.objects"]));
            finding.why = "How much cutting adds depends on how small the parts are, at most "
                          "`item_triangles` each.";
        }
        return finding;
    });
}

// The extreme of time_ratio over several entries; `sign` 1: the largest, -1: the smallest.
Find extreme_time(std::vector<std::string> entries, std::string slow, std::string fast, int sign)
{
    return [=](const SuiteResults& results, const Target& target) {
        Finding best;
        for (const EntryResult& e : results.entries) {
            if (!entries.empty() &&
                std::find(entries.begin(), entries.end(), e.name) == entries.end()) {
                continue;
            }
            Finding next = time_ratio(e, slow, fast, target);
            if (!std::isnan(next.value) &&
                (std::isnan(best.value) || sign * next.value > sign * best.value)) {
                best = std::move(next);
                best.ours += ", on " + e.name;
            }
        }
        return best;
    };
}

// Engine calls from the view of the device: draws and batches of tests.
Find engine_calls(std::string entry)
{
    return in(std::move(entry), [](const EntryResult& e, const Target& target) {
        const auto calls = [&](std::string_view name) {
            const RunResult* run = e.run(name);
            return run == nullptr ? std::numeric_limits<double>::quiet_NaN()
                                  : (*run)["per_frame.batches"] + (*run)["per_frame.draw_calls"];
        };
        Finding finding;
        finding.value = calls("chc") / calls("chc_plus_plus");
        if (std::isfinite(finding.value)) {
            finding.ours = fmt::format("{} / {} = **{}**", readable(calls("chc")),
                                       readable(calls("chc_plus_plus")), readable(finding.value));
            finding.counters = "this is one";
            if (!target.reached_by(finding.value)) {
                finding.why = fmt::format(
                    "`chc` shows {} visible leaves a frame here: the fewer there are, the fewer "
                    "calls there are to save.",
                    readable((*e.run("chc"))["per_frame.items_drawn"]));
            }
        }
        return finding;
    });
}

Find state_changes_per_frame(std::string entry)
{
    return in(std::move(entry), [](const EntryResult& e, const Target&) {
        Finding finding;
        if (const RunResult* run = e.run("chc_plus_plus")) {
            finding.value = (*run)["per_frame.state_changes"];
            finding.ours = fmt::format("**{}**", readable(finding.value));
            finding.counters = "this is one";
        }
        return finding;
    });
}

Find test_cost(std::string entry)
{
    return in(std::move(entry), [](const EntryResult& e, const Target&) {
        Finding finding = test_cost_in_triangles(e, "batch_and_wait");
        if (!std::isnan(finding.value)) {
            finding.why = "Measured, not chosen: what is left of a frame after drawing, per test. "
                          "Drawing is in software here, and triangles are expensive.";
        }
        return finding;
    });
}

void add_stat05(std::vector<PublishedFigure>& figures)
{
    const auto add = [&](std::string scene, std::string what, std::string published, Target target,
                         Find find) {
        figures.push_back({"STAT05", std::move(scene), std::move(what), std::move(published),
                           target, std::move(find)});
    };
    const auto add_scene = [&](const std::string& scene, const std::string& entry,
                               std::array<int, 3> seconds, double target) {
        const auto published = [&](int a, int b) {
            return fmt::format("{} s / {} s = {:.2f}", a, b, static_cast<double>(a) / b);
        };
        add(scene, "time, No OC over Simple OC", published(seconds[0], seconds[1]), kForComparison,
            time(entry, "frustum", "stop_and_wait"));
        add(scene, "time, No OC over Stat. OC", published(seconds[0], seconds[2]), at_least(target),
            time(entry, "frustum", "statistical"));
        add(scene, "time, Simple OC over Stat. OC", published(seconds[1], seconds[2]),
            kForComparison, time(entry, "stop_and_wait", "statistical"));
    };
    add_scene("power plant, 2 million triangles", "plant_2m", {43, 37, 22}, 1.95);
    add_scene("library, 40,000 books, over 10 million", "library", {14, 7, 4}, 3.5);
    add_scene("5,000 teapots, 32 million", "teapots", {33, 11, 11}, 3.0);
    const std::vector<std::string> all = {"plant_2m", "library", "teapots"};
    add("all three", "the best gain, No OC over Stat. OC", "\"up to 4 times\"", at_least(4.0),
        extreme_time(all, "frustum", "statistical", 1));
    add("all three", "the worst case, Simple OC over Stat. OC",
        "\"only a bit slower\" than Simple OC", at_least(0.8),
        extreme_time(all, "stop_and_wait", "statistical", -1));
}

void add_dyn06(std::vector<PublishedFigure>& figures)
{
    const auto add = [&](std::string scene, std::string what, std::string published, Target target,
                         Find find) {
        figures.push_back({"DYN06", std::move(scene), std::move(what), std::move(published), target,
                           std::move(find)});
    };
    const std::string plant = "power plant, 1,185 objects, 13 million";
    add(plant, "time, VFC over Simple", "5942 ms / 1194 ms = 4.98", kForComparison,
        time("plant_13m", "frustum", "stop_and_wait"));
    add(plant, "time, VFC over Full", "5942 ms / 788 ms = 7.54", at_least(7.5),
        time("plant_13m", "frustum", "two_level"));
    add(plant, "time, Simple over Full", "1194 ms / 788 ms = 1.52", at_least(1.5),
        time("plant_13m", "stop_and_wait", "two_level"));
    add(plant, "queries, Full over Simple", "216 / 616 = 0.35", at_most(0.35),
        count("plant_13m", "queries", "two_level", "stop_and_wait"));
    add(plant, "parts drawn, VFC over Simple", "1678 / 504 = 3.33", kForComparison,
        count("plant_13m", "items_drawn", "frustum", "stop_and_wait"));
    add(plant, "parts drawn, VFC over Full", "1678 / 522 = 3.21", kForComparison,
        count("plant_13m", "items_drawn", "frustum", "two_level"));
    add(plant, "preparing the objects", "8 minutes", kForComparison,
        preparation("plant_13m", "load_seconds", "s; less if the cut meshes were kept"));
    const std::string bunnies = "300 moving bunnies, 23 million";
    add(bunnies, "time, VFC over Simple", "3836 ms / 3168 ms = 1.21", kForComparison,
        time("bunnies", "frustum", "stop_and_wait"));
    add(bunnies, "time, VFC over Full", "3836 ms / 826 ms = 4.64", at_least(4.6),
        time("bunnies", "frustum", "two_level"));
    add(bunnies, "time, Simple over Full", "3168 ms / 826 ms = 3.84", at_least(3.8),
        time("bunnies", "stop_and_wait", "two_level"));
    add(bunnies, "queries, Full over Simple", "2173 / 14408 = 0.15", at_most(0.15),
        count("bunnies", "queries", "two_level", "stop_and_wait"));
    add(bunnies, "parts drawn, VFC over Simple", "22344 / 2584 = 8.65", kForComparison,
        count("bunnies", "items_drawn", "frustum", "stop_and_wait"));
    add(bunnies, "parts drawn, VFC over Full", "22344 / 6260 = 3.57", kForComparison,
        count("bunnies", "items_drawn", "frustum", "two_level"));
    add(bunnies, "triangles after cutting", "77,000 / 70,000 = +10% in 23 parts", kForComparison,
        growth_by_cutting("bunnies"));
    add(bunnies, "preparing the bunny", "5 s", kForComparison,
        preparation("bunnies", "load_seconds", "s; less if the cut mesh was kept"));
    add(bunnies, "the scene tree following a frame", "\"in the order of\" a millisecond",
        kForComparison, preparation("bunnies", "tree_update_ms", "ms"));
}

void add_log01(std::vector<PublishedFigure>& figures)
{
    const auto add = [&](std::string scene, std::string what, std::string published, Target target,
                         Find find) {
        figures.push_back({"LOG01", std::move(scene), std::move(what), std::move(published), target,
                           std::move(find)});
    };
    struct Walk {
        const char* scene;
        const char* entry;
        int lazy_cells;
        int busy_cells;
        int all_triangles;
        int few_triangles;
        Target gain; // lazy over none, time
        double fewer;
    };
    static constexpr std::array<Walk, 4> kWalks{
        Walk{"forest, 640x480", "forest_640", 498, 2394, 147969, 7009, at_least(1.9), 20.0},
        Walk{"forest, 1280x960", "forest_1280", 650, 6781, 147969, 7510, at_least(1.9), 19.7},
        Walk{"city, 640x480", "city_640", 565, 1332, 1964918, 11981, at_least(10.0), 160.0},
        Walk{"city, 1280x960", "city_1280", 937, 4227, 1964918, 11775, at_least(10.0), 160.0}};
    const auto published = [](double a, double b) {
        return fmt::format("{} / {} = {}", readable(a), readable(b), readable(a / b));
    };
    for (const Walk& walk : kWalks) {
        add(walk.scene, "pixel-level queries (cells asked), busy over lazy",
            published(walk.busy_cells, walk.lazy_cells), at_least(2.4),
            count(walk.entry, "cells_asked", "lazy_grid:update=busy", "lazy_grid"));
        add(walk.scene, "triangles, none over lazy",
            published(walk.all_triangles, walk.few_triangles), at_least(walk.fewer),
            count(walk.entry, "triangles_drawn", "frustum", "lazy_grid"));
        add(walk.scene, "triangles, none over busy",
            published(walk.all_triangles, walk.few_triangles), kForComparison,
            count(walk.entry, "triangles_drawn", "frustum", "lazy_grid:update=busy"));
        add(walk.scene, "time, none over lazy", "between 1.9 and 39.1, by figure only", walk.gain,
            time(walk.entry, "frustum", "lazy_grid"));
        add(walk.scene, "time, busy over lazy", "between 1.9 and 5.8, by figure only",
            between(1.9, 5.8), time(walk.entry, "lazy_grid:update=busy", "lazy_grid"));
        add(walk.scene, "time spent reading depth, lazy", "38 to 52%", kForComparison,
            share(walk.entry, "read_ms", "lazy_grid"));
        add(walk.scene, "time spent reading depth, busy", "54 to 69%", kForComparison,
            share(walk.entry, "read_ms", "lazy_grid:update=busy"));
        add(walk.scene, "building the hierarchy", "less than 1 s", kForComparison,
            preparation(walk.entry, "hierarchy_seconds", "s"));
    }
    const std::vector<std::string> all = {"forest_640", "forest_1280", "city_640", "city_1280"};
    add("all four", "the greatest gain in time, none over lazy", "39.1", at_least(39.0),
        extreme_time(all, "frustum", "lazy_grid", 1));
    add("all four", "the least gain in time, none over lazy", "1.9", at_least(1.9),
        extreme_time(all, "frustum", "lazy_grid", -1));
    add("all four", "the greatest gain of lazy over busy", "5.8", kForComparison,
        extreme_time(all, "lazy_grid:update=busy", "lazy_grid", 1));
    add("all four", "the least gain of lazy over busy", "1.9", kForComparison,
        extreme_time(all, "lazy_grid:update=busy", "lazy_grid", -1));
    add("forest", "time, none over busy", "below 1: busy is slower than nothing", kForComparison,
        extreme_time({"forest_640", "forest_1280"}, "frustum", "lazy_grid:update=busy", -1));
}

void add_gems29(std::vector<PublishedFigure>& figures)
{
    const auto add = [&](std::string scene, std::string what, std::string published, Target target,
                         Find find) {
        figures.push_back({"GEMS29", std::move(scene), std::move(what), std::move(published),
                           target, std::move(find)});
    };
    add("boxes of 252 triangles", "triangles that cost as much as a test", "about 200",
        kForComparison, test_cost("boxes_252"));
    add("boxes of 12 triangles", "time, frustum over testing every object",
        "\"won't accomplish much\" for 300 triangles, the less for 12", kForComparison,
        time("boxes_12", "frustum", "batch_and_wait"));
    add("boxes of 252 triangles", "time, frustum over testing every object",
        "\"won't accomplish much\" for 300 triangles", kForComparison,
        time("boxes_252", "frustum", "batch_and_wait"));
    add("teapots, more than 1,000 triangles each", "time, frustum over testing every object",
        "\"more than double\"", at_least(2.0), time("teapot_objects", "frustum", "batch_and_wait"));
    add("teapots, more than 1,000 triangles each", "time, frustum over testing in the next frame",
        "\"more than double\"", at_least(2.0), time("teapot_objects", "frustum", "next_frame"));
    add("teapots, more than 1,000 triangles each", "loss by waiting, testing in the next frame",
        "less than 10%", at_most(0.1), share("teapot_objects", "wait_ms", "next_frame"));
}

void add_sx7(std::vector<PublishedFigure>& figures)
{
    const auto add = [&](std::string scene, std::string what, std::string published, Target target,
                         Find find) {
        figures.push_back({"SX7", std::move(scene), std::move(what), std::move(published), target,
                           std::move(find)});
    };
    for (const char* entry : {"city_street", "city_rise", "vienna_street", "vienna_rise"}) {
        add(entry, "time, CHC over CHC++", "1.5 to 3, typically", between(1.5, 3.0),
            time(entry, "chc", "chc_plus_plus"));
        add(entry, "state changes, CHC over CHC++", "more than 10", at_least(10.0),
            count(entry, "state_changes", "chc", "chc_plus_plus"));
        add(entry, "engine calls, CHC over CHC++", "more than 10", at_least(10.0),
            engine_calls(entry));
        add(entry, "queries, CHC over CHC++", "\"significantly reduced\"", at_least(1.5),
            count(entry, "queries", "chc", "chc_plus_plus"));
        add(entry, "time, without tight bounds and multiqueries over with", "1.05 to 1.20",
            at_least(1.05),
            time(entry, "chc_plus_plus:multiqueries=off:tight_bounds_depth=0", "chc_plus_plus"));
        add(entry, "state changes a frame", "about 200 are acceptable", at_most(200.0),
            state_changes_per_frame(entry));
    }
    add("every scene and path of this suite", "the worst, frustum over CHC++", "never below 1",
        at_least(0.98), extreme_time({}, "frustum", "chc_plus_plus", -1));
}

} // namespace

std::span<const Paper> papers()
{
    static constexpr std::array<Paper, 5> kPapers{
        Paper{"STAT05",
              "V. Kovalcik, J. Sochor: Occlusion Culling with Statistically Optimized Occlusion "
              "Queries, WSCG 2005",
              "Theirs: Pentium 4 at 2 GHz, Radeon 9700. No OC is `frustum`, Simple OC "
              "`stop_and_wait`, Stat. OC `statistical`, all on `bsp`, with `straddling=child` for "
              "the plant and the teapots."},
        Paper{"DYN06", "V. Kovalcik, P. Tobola: Fast Rendering of Complex Dynamic Scenes, 2006",
              "Theirs: Sempron 3000+, Radeon 9500. VFC is `frustum`, Simple `stop_and_wait`, Full "
              "`two_level`, all on the tree `two_level` over exactly cut meshes."},
        Paper{"LOG01",
              "H. Hey, R. F. Tobler, W. Purgathofer: Real-Time Occlusion Culling with a Lazy "
              "Occlusion Grid, 2001",
              "Theirs: Athlon at 900 MHz, GeForce2 GTS. None is `frustum`, lazy and busy are "
              "`lazy_grid` with `update=lazy` and `update=busy`; cells of 32 x 32 pixels. Theirs: "
              "boxes of at most 1,500 triangles; here of 128, tested by their faces, up to 96 of "
              "them wait for pixels at once, and a read-back takes whole rows of cells (`bounds`, "
              "`tests_at_once`, `join`)."},
        Paper{"GEMS29", "D. Sekulic: Efficient Occlusion Culling, GPU Gems, chapter 29, 2004",
              "Rules of thumb for the hardware of 2004. One test per object is `batch_and_wait`, "
              "the answers of the last frame are `next_frame`."},
        Paper{"SX7",
              "J. Bittner, O. Mattausch, M. Wimmer: Game-Engine-Friendly Occlusion Culling, "
              "ShaderX7, 2009; the algorithm is that of CHC++: Coherent Hierarchical Culling "
              "Revisited, 2008",
              "Figures in words, without a table. CHC is `chc`, CHC++ `chc_plus_plus`; a frame "
              "rate below view-frustum culling is one below `frustum`, where 2% pass as noise."}};
    return kPapers;
}

const std::vector<PublishedFigure>& published_figures()
{
    static const std::vector<PublishedFigure> kFigures = [] {
        std::vector<PublishedFigure> figures;
        add_stat05(figures);
        add_dyn06(figures);
        add_log01(figures);
        add_gems29(figures);
        add_sx7(figures);
        return figures;
    }();
    return kFigures;
}

} // namespace occlude::tools
