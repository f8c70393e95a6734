#include "report/csv_report.h"
#include "report/headline.h"
#include "report/html_report.h"
#include "report/html_text.h"
#include "report/json_report.h"
#include "report/table.h"

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

namespace occlude::tools {

namespace {

using Json = nlohmann::json;

// Two frames of one algorithm, with figures that are easy to recognise.
BenchDocument example()
{
    AlgorithmRun run{"chc", Guarantee::exact(), std::vector<FrameFigures>(2), "bvh"};
    for (size_t i = 0; i < 2; ++i) {
        FrameFigures& frame = run.frames[i];
        const double factor = i == 0 ? 1.0 : 3.0;
        frame.frame_ms = 2.0 * factor;
        frame.wait_ms = 0.5 * factor;
        frame.cull_cpu_ms = 0.25 * factor;
        frame.speedup_vs_frustum = 4.0 * factor;
        frame.ratio_to_opt = 1.0 * factor;
        frame.ratio_to_ideal = 1.5 * factor;
        frame.overdraw_items_vs_exact = 0.5;
        frame.counters.queries = i == 0 ? 10 : 20;
        frame.counters.triangles_drawn = 1000000;
        frame.decision_hash = i + 1;
    }
    BenchDocument document;
    document.scene = "city, \"old\" </script>";
    document.objects = 3;
    document.items = 5;
    document.triangles = 12345678;
    document.device = "cpu";
    document.api = "cpu";
    document.renderer = "scalar";
    document.hierarchy = "bvh";
    document.test = "queries";
    document.path = "auto";
    document.size = {640, 360};
    document.frames = 2;
    document.runs = {run};
    return document;
}

std::set<std::string> keys(const Json& json)
{
    std::set<std::string> names;
    for (const auto& [name, value] : json.items()) {
        names.insert(name);
    }
    return names;
}

} // namespace

TEST(JsonReport, HasTheKeysOfTheContract)
{
    const std::vector<BenchDocument> documents = {example()};
    const Json json = Json::parse(json_report(documents));
    EXPECT_EQ(keys(json),
              (std::set<std::string>{"version", "scene", "device", "hierarchy", "leaf_triangles",
                                     "item_triangles", "split", "sets", "preparation", "path",
                                     "size", "samples", "frames", "repeat", "sample_every",
                                     "evidence", "coincident", "runs"}));
    EXPECT_EQ(json["version"], 1);
    EXPECT_EQ(keys(json["scene"]), (std::set<std::string>{"name", "objects", "items", "triangles",
                                                          "notes", "left_out"}));
    EXPECT_EQ(keys(json["device"]),
              (std::set<std::string>{"name", "api", "renderer", "deterministic"}));
    EXPECT_EQ(json["size"], Json::parse("[640, 360]"));

    const std::set<std::string> counters = {
        "queries",     "multiqueries", "boxes",       "multiqueries_failed", "state_changes",
        "batches",     "draw_calls",   "items_drawn", "triangles_drawn",     "nodes_visited",
        "waits",       "wait_ms",      "read_ms",     "cull_cpu_ms",         "depth_reads",
        "pixels_read", "cells_asked"};
    const Json& run = json["runs"][0];
    EXPECT_EQ(keys(run),
              (std::set<std::string>{"algorithm", "hierarchy", "device", "test", "guarantee",
                                     "frame_ms", "speedup_vs_frustum", "slowest_vs_frustum",
                                     "ratio_to_opt", "ratio_to_ideal", "per_frame",
                                     "overdraw_items_vs_exact", "differing_pixels",
                                     "differing_frames", "tied_pixels", "compared_frames",
                                     "decision_hash", "decision_hash_reproducible", "frames"}));
    EXPECT_EQ(keys(run["frame_ms"]),
              (std::set<std::string>{"median", "mean", "p95", "p99", "max", "total"}));
    EXPECT_EQ(keys(run["per_frame"]), counters);
    std::set<std::string> frame_keys = counters;
    frame_keys.insert({"frame", "frame_ms", "speedup_vs_frustum", "ratio_to_opt", "ratio_to_ideal",
                       "overdraw_items_vs_exact", "differing_pixels", "tied_pixels",
                       "decision_hash"});
    ASSERT_EQ(run["frames"].size(), 2u);
    EXPECT_EQ(keys(run["frames"][0]), frame_keys);
}

TEST(JsonReport, SumsUpByMediansAndMeans)
{
    const std::vector<BenchDocument> documents = {example()};
    const Json run = Json::parse(json_report(documents))["runs"][0];
    EXPECT_EQ(run["frame_ms"]["median"], 4.0);
    EXPECT_EQ(run["frame_ms"]["total"], 8.0);
    EXPECT_EQ(run["speedup_vs_frustum"], 8.0);
    EXPECT_EQ(run["ratio_to_opt"], 2.0);
    EXPECT_EQ(run["per_frame"]["queries"], 15.0);
    EXPECT_EQ(run["per_frame"]["wait_ms"], 1.0);
    EXPECT_EQ(run["frames"][1]["queries"], 20);
    EXPECT_EQ(run["decision_hash"].get<std::string>().size(), 16u);
}

TEST(JsonReport, WhatWasNotComparedIsNullAndNotZero)
{
    std::vector<BenchDocument> documents = {example()};
    Json run = Json::parse(json_report(documents))["runs"][0];
    EXPECT_TRUE(run["differing_pixels"].is_null());
    EXPECT_TRUE(run["frames"][0]["differing_pixels"].is_null());
    documents[0].runs[0].frames[0].verdict = Verdict{.differing_pixels = 7, .tied_pixels = 2};
    documents[0].runs[0].frames[1].verdict = Verdict{};
    run = Json::parse(json_report(documents))["runs"][0];
    EXPECT_EQ(run["differing_pixels"], 7);
    EXPECT_EQ(run["differing_frames"], 1);
    EXPECT_EQ(run["tied_pixels"], 2);
    EXPECT_EQ(run["frames"][1]["differing_pixels"], 0);
}

TEST(JsonReport, SeveralDocumentsAreAnArrayOfThem)
{
    const std::vector<BenchDocument> documents = {example(), example()};
    const Json json = Json::parse(json_report(documents));
    ASSERT_TRUE(json.is_array());
    ASSERT_EQ(json.size(), 2u);
    EXPECT_EQ(json[1]["version"], 1);
}

TEST(JsonReport, NamesThatAreNotUtf8DoNotBreakIt)
{
    std::vector<BenchDocument> documents = {example()};
    documents[0].scene = "caf\xe9";
    EXPECT_NO_THROW(Json::parse(json_report(documents)));
}

TEST(CsvReport, IsOneHeaderAndOneRowPerRunWithAsManyCells)
{
    std::vector<BenchDocument> documents = {example(), example()};
    documents[0].scene = documents[1].scene = "plain";
    std::istringstream lines{csv_report(documents)};
    std::string header;
    std::string row;
    ASSERT_TRUE(std::getline(lines, header));
    int rows = 0;
    while (std::getline(lines, row)) {
        ++rows;
        EXPECT_EQ(std::count(row.begin(), row.end(), ','),
                  std::count(header.begin(), header.end(), ','));
    }
    EXPECT_EQ(rows, 2);
    EXPECT_NE(header.find("frame_ms_median"), std::string::npos);
}

TEST(CsvReport, QuotesNamesWithCommasAndQuotes)
{
    const std::vector<BenchDocument> documents = {example()};
    EXPECT_NE(csv_report(documents).find("\"city, \"\"old\"\" </script>\""), std::string::npos);
}

TEST(Table, AlignsColumnsAndGroupsDigits)
{
    EXPECT_EQ(align_columns({{"a", "long"}, {"bcd", "1"}}), "a    long\nbcd     1\n");
    EXPECT_EQ(grouped(0), "0");
    EXPECT_EQ(grouped(999), "999");
    EXPECT_EQ(grouped(1000), "1,000");
    EXPECT_EQ(grouped(1234567), "1,234,567");
}

TEST(Table, SaysWhatAnAlgorithmThatChoosesHasChosen)
{
    BenchDocument document = example();
    EXPECT_EQ(bench_table(document).find("frames pyramid"), std::string::npos);
    AlgorithmRun& run = document.runs[0];
    for (FrameFigures& frame : run.frames) {
        frame.plan.kind = FramePlan::Kind::pyramid;
    }
    run.frames[0].plan.kind = FramePlan::Kind::draw_all;
    EXPECT_NE(bench_table(document).find(run.algorithm + ": 1 frames draw_all, " +
                                         std::to_string(run.frames.size() - 1) + " frames pyramid"),
              std::string::npos);
    const nlohmann::json json = nlohmann::json::parse(json_report({&document, 1}));
    EXPECT_EQ(json["runs"][0]["frames"][0]["plan"].get<std::string>().substr(0, 8), "draw_all");
}

TEST(Table, ShowsSceneSizeDeviceAndADashForWhatWasNotMeasured)
{
    const std::string table = bench_table(example());
    EXPECT_NE(table.find("12,345,678 triangles"), std::string::npos);
    EXPECT_NE(table.find("640x360"), std::string::npos);
    EXPECT_NE(table.find("(scalar)"), std::string::npos);
    const std::string row = table.substr(table.find("\nchc") + 1);
    EXPECT_EQ(row.substr(row.size() - 2), "-\n"); // differing pixels: not compared
}

TEST(HtmlReport, StandsAloneAndHoldsTheData)
{
    const std::vector<BenchDocument> documents = {example()};
    const std::string html = html_report(documents);
    for (size_t at = 0; (at = html.find(" src=\"", at)) != html.npos; ++at) {
        EXPECT_EQ(html.compare(at, 11, " src=\"data:"), 0) << "another file would be needed";
    }
    EXPECT_EQ(html.find("<link"), html.npos);
    EXPECT_NE(html.find("Chart.js v"), html.npos);
    const std::string opening = "id=\"occlude-data\">";
    const size_t begin = html.find(opening) + opening.size();
    const std::string data = html.substr(begin, html.find("</script>", begin) - begin);
    EXPECT_EQ(Json::parse(data)["scene"]["name"], documents[0].scene);
}

TEST(HtmlReport, NamesTheEntriesOfASuiteAndFoldsWhatMayDiffer)
{
    std::vector<BenchDocument> documents = {example(), example()};
    documents[0].entry = "city_street";
    documents[0].runs[0].frames[0].verdict = Verdict{.differing_pixels = 7};
    documents[1].runs[0].guarantee = Guarantee::latent(1);
    documents[1].runs[0].frames[0].verdict = Verdict{.differing_pixels = 7};
    const std::string html = html_report(documents);
    EXPECT_NE(html.find("<h2 id=\"section-0\">city_street: city, "), std::string::npos);
    EXPECT_NE(html.find("<a href=\"#section-1\">city, "), std::string::npos);
    const size_t open = html.find("<h3>Differences</h3>");
    const size_t folded = html.find("<details>");
    ASSERT_NE(open, std::string::npos); // chc broke its promise ...
    ASSERT_NE(folded, std::string::npos);
    EXPECT_LT(open, folded); // without a promise it is no alarm
    EXPECT_EQ(html.find("<h3>Differences</h3>", open + 1), std::string::npos);
}

// frustum, chc and ideal at 1, 4 and 8 times the speed of frustum culling; adaptive if asked for.
BenchDocument timed(bool with_adaptive)
{
    BenchDocument document = example();
    const AlgorithmRun run = document.runs[0];
    document.runs.clear();
    const auto add = [&](const char* name, double speedup) {
        document.runs.push_back(run);
        document.runs.back().algorithm = name;
        for (FrameFigures& frame : document.runs.back().frames) {
            frame.speedup_vs_frustum = speedup;
        }
    };
    add("frustum", 1.0);
    add("chc", 4.0);
    if (with_adaptive) {
        add("adaptive", 3.0);
    }
    add("ideal", 8.0);
    return document;
}

TEST(Headline, SpeaksOfAdaptiveOrElseOfTheFastestExactAlgorithm)
{
    BenchDocument document = timed(false);
    EXPECT_EQ(chosen_run(document), 1u);
    EXPECT_EQ(ideal_run(document, 1), 2u);
    EXPECT_EQ(chosen_run(timed(true)), 2u);
    document.runs[1].guarantee = Guarantee::latent(1);
    EXPECT_EQ(chosen_run(document), std::nullopt);
    EXPECT_NE(html_report({&document, 1}).find("No exact algorithm was timed"), std::string::npos);
}

TEST(Headline, SaysTheLimitWhatWasComparedAndThatCullingDoesNotPay)
{
    BenchDocument document = timed(true);
    std::string html = html_report({&document, 1});
    EXPECT_NE(html.find(">3.00</b> times as fast as frustum culling; the limit is <b"),
              std::string::npos);
    EXPECT_NE(html.find("<code>--verify</code>"), std::string::npos);
    EXPECT_EQ(html.find("does not pay"), std::string::npos);
    for (FrameFigures& frame : document.runs[2].frames) {
        frame.speedup_vs_frustum = 1.04;
        frame.verdict = Verdict{};
    }
    html = html_report({&document, 1});
    EXPECT_NE(html.find("does not pay here. All pixels of 2 frames were compared: none differs."),
              std::string::npos);
    document.runs[2].frames[0].verdict->differing_pixels = 5;
    EXPECT_NE(html_report({&document, 1}).find("But 5 pixels differ."), std::string::npos);
}

TEST(Headline, TheWorstFramesComeFirst)
{
    AlgorithmRun run = example().runs[0];
    run.frames[0].speedup_vs_frustum = 2.0;
    run.frames[1].speedup_vs_frustum = 1.5;
    EXPECT_EQ(worst_frames(run, 5), (std::vector<size_t>{1, 0}));
    EXPECT_EQ(worst_frames(run, 1), (std::vector<size_t>{1}));
    run.frames[1].speedup_vs_frustum = kNotMeasured;
    EXPECT_EQ(worst_frames(run, 5), (std::vector<size_t>{0}));
}

TEST(HtmlText, EncodesBytesAsBase64)
{
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64(std::string{"\xff\x00\xfe", 3}), "/wD+");
}

TEST(HtmlReport, EscapesWhatComesFromOutside)
{
    EXPECT_EQ(html_escaped("<a href=\"x\">&"), "&lt;a href=&quot;x&quot;&gt;&amp;");
    const std::vector<BenchDocument> documents = {example()};
    EXPECT_NE(html_report(documents).find("&quot;old&quot; &lt;/script&gt;, path auto"),
              std::string::npos);
}

} // namespace occlude::tools
