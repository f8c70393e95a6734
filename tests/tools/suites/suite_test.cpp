// Suites: their tables, the results that they store, and the page beside the published figures.
#include "suites/suite.h"

#include "commands/cli.h"
#include "commands/comparison.h"
#include "report/json_report.h"
#include "suites/findings.h"
#include "suites/papers_report.h"
#include "suites/published_figures.h"
#include "suites/suite_results.h"

#include "support/source_dir.h"
#include "tools/temp_folder.h"

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

namespace occlude::tools {

namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

// Mean values of one frame.
struct Means {
    double ms;
    uint64_t triangles;
    uint64_t queries;
};

AlgorithmRun run_of(const std::string& name, const Means& means)
{
    AlgorithmRun run{name, Guarantee::exact(), std::vector<FrameFigures>(1)};
    FrameFigures& frame = run.frames[0];
    frame.frame_ms = means.ms;
    frame.wait_ms = 0.4 * means.ms;
    frame.read_ms = 0.0;
    frame.cull_cpu_ms = 0.05 * means.ms;
    frame.counters.triangles_drawn = means.triangles;
    frame.counters.queries = means.queries;
    frame.counters.items_drawn = means.triangles / 100;
    frame.verdict = Verdict{};
    return run;
}

BenchDocument entry_of(const std::string& name, std::vector<AlgorithmRun> runs)
{
    BenchDocument document;
    document.entry = name;
    document.date = "2030-01-02";
    document.scene = "made up";
    document.device = "gl";
    document.api = "gl 4.5";
    document.renderer = "software";
    document.hierarchy = "bsp";
    document.path = "auto";
    document.size = {640, 480};
    document.frames = 1;
    document.split = "centroid";
    document.runs = std::move(runs);
    return document;
}

SuiteResults results_of(std::vector<BenchDocument> documents, const char* scale = "small")
{
    auto results = parse_suite_results("test", suite_report("papers", scale, documents));
    EXPECT_TRUE(results);
    return *results;
}

std::string content_of(const fs::path& file)
{
    std::ifstream stream{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{stream}, {}};
}

// The row of the power plant's statistical gain, and the sentence about it.
std::string plant_lines(const Means& frustum, const Means& statistical, const Means& ideal,
                        const Means& opt)
{
    const SuiteResults results = results_of(
        {entry_of("plant_2m", {run_of("frustum", frustum), run_of("statistical", statistical),
                               run_of("opt", opt), run_of("ideal", ideal)})});
    std::istringstream page{papers_report(results)};
    std::string lines;
    for (std::string line; std::getline(page, line);) {
        if (line.find("power plant, 2 million") != std::string::npos &&
            line.find("No OC over Stat. OC") != std::string::npos) {
            lines += line + '\n';
        }
    }
    return lines;
}

int run(std::vector<std::string> arguments, std::string* err = nullptr)
{
    arguments.insert(arguments.begin(), "occlude");
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) {
        argv.push_back(argument.c_str());
    }
    std::ostringstream out;
    std::ostringstream errors;
    const int code = run_program(static_cast<int>(argv.size()), argv.data(), {out, errors});
    if (err != nullptr) {
        *err = errors.str();
    }
    return code;
}

} // namespace

TEST(Suites, EntriesHaveNamesOfTheirOwnAndOptionsThatExist)
{
    for (const Suite& suite : suites()) {
        for (const Scale scale : {Scale::small, Scale::full}) {
            std::set<std::string> names;
            for (const SuiteEntry& entry : suite.entries(scale)) {
                EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
                CompareOptions options;
                options.stage = entry.stage;
                options.algorithms = entry.algorithms;
                std::ostringstream notes;
                const auto checked = check_compare_options(options, notes);
                EXPECT_TRUE(checked) << entry.name << ": " << checked.error().message;
                EXPECT_LE(entry.sample_every, entry.stage.frames);
                EXPECT_GT(entry.verify_every, 0u);
            }
        }
    }
    EXPECT_EQ(find_suite("papers"), &suites()[0]);
    EXPECT_EQ(find_suite("paper"), nullptr);
}

TEST(PublishedFigures, SpeakOfEntriesThatTheSuiteHasAndOfRunsThatTheyMake)
{
    // Every entry with every algorithm that it names: every figure must be found.
    std::vector<BenchDocument> documents;
    for (const SuiteEntry& entry : find_suite("papers")->entries(Scale::full)) {
        std::vector<AlgorithmRun> runs;
        for (const std::string& name : split_commas(entry.algorithms)) {
            AlgorithmRun made = run_of(name, {10.0, 1000, 10});
            made.frames[0].counters.state_changes = 5;
            made.frames[0].counters.cells_asked = 7;
            made.frames[0].counters.batches = 2;
            runs.push_back(made);
        }
        documents.push_back(entry_of(entry.name, std::move(runs)));
        documents.back().preparation = {1.0, 0.5, 2.0, 100};
        documents.back().triangles = 110;
    }
    const SuiteResults results = results_of(std::move(documents));
    std::set<std::string_view> papers_met;
    for (const PublishedFigure& figure : published_figures()) {
        EXPECT_FALSE(std::isnan(figure.find(results, figure.target).value))
            << figure.paper << ": " << figure.scene << ": " << figure.what;
        papers_met.insert(figure.paper);
    }
    EXPECT_EQ(papers_met.size(), papers().size());
}

TEST(PapersReport, SaysReachedOnlyIfTheMeasuredRatioReaches)
{
    const Means ideal{10.0, 5000, 0};
    const Means opt{20.0, 10000, 0};
    EXPECT_NE(plant_lines({100.0, 100000, 0}, {50.0, 40000, 10}, ideal, opt)
                  .find("| 100 ms / 50.0 ms = **2.00** | triangles 2.50 | at least 1.95 | yes |"),
              std::string::npos);
    EXPECT_NE(plant_lines({100.0, 100000, 0}, {52.0, 40000, 10}, ideal, opt).find("| **short** |"),
              std::string::npos);
}

TEST(PapersReport, TheCountersChooseTheSentenceAboutWhatFallsShort)
{
    const Means frustum{100.0, 100000, 0};
    const Means good{10.0, 5000, 0};
    // No algorithm could do better: the scene hides too little.
    EXPECT_NE(plant_lines(frustum, {90.0, 80000, 10}, {60.0, 60000, 0}, good)
                  .find("The scene sets the limit: `ideal`, which is told what is visible and "
                        "tests nothing, is 1.67 times as fast"),
              std::string::npos);
    // Fewer triangles, and the same time: the tests are too expensive.
    const std::string expensive = plant_lines(frustum, {80.0, 20000, 100}, good, good);
    EXPECT_NE(expensive.find("Triangles fall by the published factor and more (5.00)"),
              std::string::npos);
    EXPECT_NE(expensive.find("about 25% is drawing"), std::string::npos);
    EXPECT_NE(expensive.find("40% waiting for answers"), std::string::npos);
    EXPECT_NE(expensive.find("as much per test as 600 triangles"), std::string::npos);
    // The leaves hold too much.
    EXPECT_NE(plant_lines(frustum, {80.0, 70000, 10}, good, {50.0, 60000, 0})
                  .find("triangles can fall 1.67-fold at most (`opt`)"),
              std::string::npos);
    // The algorithm keeps drawing too much.
    EXPECT_NE(plant_lines(frustum, {80.0, 70000, 10}, good, good)
                  .find("Triangles fall 1.43-fold where 20.0-fold was possible"),
              std::string::npos);
}

TEST(PapersReport, NamesWhatWasNotMeasuredAndTheScale)
{
    const std::string page = papers_report(results_of({}, "full"));
    EXPECT_NE(page.find("Of 0 figures with something to reach, 0 are reached."), std::string::npos);
    EXPECT_NE(page.find("Scale: **full**"), std::string::npos);
    EXPECT_NE(page.find("| - |  | at least 1.95 | not measured |"), std::string::npos);
}

TEST(SuiteResults, HashesAreSaidToRepeatOnlyWhereTheyMust)
{
    AlgorithmRun polled = run_of("chc", {1.0, 1, 1});
    polled.polled = true;
    std::vector<BenchDocument> documents = {
        entry_of("a", {polled, run_of("stop_and_wait", {1.0, 1, 1})})};
    const auto reproducible = [&](size_t index) {
        return Json::parse(
            suite_report("quick", "small",
                         documents))["documents"][0]["runs"][index]["decision_hash_reproducible"];
    };
    EXPECT_EQ(reproducible(0), false); // answers arrive when they arrive
    EXPECT_EQ(reproducible(1), true);  // it always waits
    documents[0].device = "cpu";       // answers arrive at once
    EXPECT_EQ(reproducible(0), true);
    documents[0].runs[0].asked_time = true; // but no two runs have the same clock
    EXPECT_EQ(reproducible(0), false);
}

TEST(SuiteResults, PiecesAreAddedInTheOrderOfTheSuite)
{
    const std::vector<std::string> names = {"a", "b", "c"};
    const std::string kept =
        suite_report("papers", "small",
                     std::vector{entry_of("c", {run_of("chc", {1.0, 1, 1})}), entry_of("a", {})});
    const std::string measured =
        suite_report("papers", "small",
                     std::vector{entry_of("b", {}), entry_of("c", {run_of("chc", {2.0, 1, 1})})});
    const auto added = add_to_results("old.json", kept, measured, names);
    ASSERT_TRUE(added);
    const auto results = parse_suite_results("", *added);
    ASSERT_TRUE(results);
    ASSERT_EQ(results->entries.size(), 3u);
    EXPECT_EQ(results->entries[0].name, "a");
    EXPECT_EQ(results->entries[1].name, "b");
    EXPECT_EQ((*results->entry("c")->run("chc"))["frame_ms.median"], 2.0); // the new one

    const std::string full = suite_report("papers", "full", std::vector<BenchDocument>{});
    const auto refused = add_to_results("old.json", full, measured, names);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("old.json: its scale is \"full\""), std::string::npos);
    EXPECT_FALSE(add_to_results("old.json", "nonsense", measured, names));
    EXPECT_FALSE(parse_suite_results("x", "[]"));
}

TEST(SuiteResults, WhatNestsTooDeeplyIsRefused)
{
    std::string text = suite_report("papers", "small", std::vector{entry_of("a", {})});
    ASSERT_TRUE(parse_suite_results("x.json", text));
    std::string opened;
    constexpr size_t kDepth = 300000; // one stack frame for each would overflow the stack
    for (size_t i = 0; i < kDepth; ++i) {
        opened += "{\"a\":";
    }
    text.insert(text.find("\"entry\""),
                "\"deep\":" + opened + '1' + std::string(kDepth, '}') + ',');
    const auto results = parse_suite_results("x.json", text);
    ASSERT_FALSE(results);
    EXPECT_NE(results.error().message.find("x.json: these are no results of a suite (nested more"),
              std::string::npos)
        << results.error().message;
    EXPECT_FALSE(add_to_results("x.json", text, text, {}));
}

TEST(Findings, NumbersAreReadableWhateverAFileSays)
{
    EXPECT_EQ(readable(0.125), "0.12");
    EXPECT_EQ(readable(12345.6), "12,346");
    EXPECT_EQ(readable(-12345.6), "-12,346");
    EXPECT_EQ(readable(999999999999999.0), "999,999,999,999,999");
    EXPECT_EQ(readable(1e15), "1e+15");
    EXPECT_EQ(readable(-1e300), "-1e+300");
    EXPECT_EQ(readable(NAN), "-");
}

TEST(SuiteResults, SizesThatAreNoSizesAreNamedWithTheirPlace)
{
    const Json results = Json::parse(
        suite_report("papers", "small", std::vector{entry_of("a", {}), entry_of("b", {})}));
    for (const char* size :
         {"-1", "0.5", "1e300", "4294967296", "18446744073709551617", "\"640\"", "null", "[1]"}) {
        for (const char* axis : {"0", "1"}) {
            Json broken = results;
            broken["documents"][1]["size"][std::stoul(axis)] = Json::parse(size);
            const auto read = parse_suite_results("x.json", broken.dump());
            ASSERT_FALSE(read) << size;
            EXPECT_NE(
                read.error().message.find("x.json: these are no results of a suite "
                                          "(documents[1]: size[" +
                                          std::string{axis} +
                                          "] must be a whole number from 0 to 4294967295, not "),
                std::string::npos)
                << read.error().message;
        }
    }
    Json largest = results;
    largest["documents"][1]["size"] = {4294967295, 0};
    const auto read = parse_suite_results("x.json", largest.dump());
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->entries[1].size, "4294967295 x 0");

    Json without = results;
    without["documents"][0].erase("size");
    const auto refused = parse_suite_results("x.json", without.dump());
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("documents[0]: "), std::string::npos);
}

TEST(SuiteCommand, MistakesAreNamedWithWhatWouldWork)
{
    const auto refused = [](std::vector<std::string> arguments, const std::string& words) {
        arguments.insert(arguments.begin(), "bench");
        std::string err;
        EXPECT_EQ(run(arguments, &err), 2) << err;
        EXPECT_NE(err.find(words), std::string::npos) << err;
    };
    refused({"--suite", "quik"}, "no suite 'quik'; choose from papers, quick, trees");
    refused({"--suite", "quick", "--scale", "huge"}, "no scale 'huge'; choose small or full");
    refused({"--suite", "quick", "--only", "moon"}, "no entry 'moon'; choose from city_street");
    refused({"--suite", "quick", "--frames", "3"}, "--frames: a suite decides this itself");
    refused({"--suite", "quick", "boxes"}, "scenes: a suite decides this itself");
    refused({"boxes", "--scale", "full"}, "--scale: goes with --suite only");
    refused({"--suite", "quick", "--add"}, "--add: name the file to add to with --json");
    refused({"--suite", "quick", "--from", "x.json"}, "no published figures");
    refused({"--suite", "papers", "--from", "no/such.json"}, "no/such.json");
    refused({"--suite", "quick", "--json", "no/such/folder.json"}, "no/such/folder.json");
}

TEST(SuiteCommand, MeasuresPiecesAndAddsThem)
{
    const TempFolder folder;
    const std::string kept =
        suite_report("quick", "small", std::vector{entry_of("city_street", {})});
    const std::string json = folder.write("results.json", kept);
    std::string err;
    ASSERT_EQ(run({"bench", "--suite", "quick", "--only", "boxes", "--device", "cpu", "--json",
                   json, "--add"},
                  &err),
              0)
        << err;
    const auto results = parse_suite_results(json, content_of(json));
    ASSERT_TRUE(results);
    ASSERT_EQ(results->entries.size(), 2u);
    EXPECT_EQ(results->entries[0].name, "city_street");
    const RunResult* chc = results->entries[1].run("chc");
    ASSERT_NE(chc, nullptr);
    EXPECT_EQ((*chc)["differing_pixels"], 0.0);
    EXPECT_GT((*chc)["per_frame.queries"], 0.0);
}

TEST(SuiteCommand, TheCommittedPageIsWhatTheCommittedResultsSay)
{
    const fs::path root{source_dir()};
    const TempFolder folder;
    const std::string page = folder.path("papers.md");
    const std::string committed = content_of(root / "docs/papers.md");
    const std::string scale =
        committed.find("Scale: **full**") != std::string::npos ? "full" : "small";
    const std::string results =
        (root / ("benchmarks/results/llvmpipe-2core/papers-" + scale + ".json")).string();
    ASSERT_EQ(run({"bench", "--suite", "papers", "--from", results, "--report", page}), 0);
    EXPECT_EQ(content_of(page), committed) << "write it anew: occlude bench --suite papers --from "
                                           << results << " --report docs/papers.md";
}

} // namespace occlude::tools
