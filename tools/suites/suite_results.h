// The results of a suite in a file: reads them, adds to them, and looks up figures.
#pragma once

#include <occlude/core/result.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools {

/// One algorithm on one entry. The name of a figure is its path in the JSON: "frame_ms.mean",
/// "per_frame.queries", "differing_pixels".
struct RunResult {
    std::string algorithm;
    std::string guarantee;
    std::map<std::string, double, std::less<>> figures;

    /// NaN if it was not measured.
    double operator[](std::string_view figure) const;
};

struct EntryResult {
    std::string name;
    std::string date;
    std::string scene;
    std::string path;
    std::string size; ///< "1280 x 720"
    std::string hierarchy;
    std::string device; ///< "gl: renderer"
    std::string split;
    std::vector<std::string> sets;
    std::map<std::string, double, std::less<>> figures; ///< numbers of the document, named as those
                                                        ///< of a run
    std::vector<RunResult> runs;

    /// NaN if it was not measured.
    double operator[](std::string_view figure) const;
    /// The run of that name, or null.
    const RunResult* run(std::string_view algorithm) const;
};

struct SuiteResults {
    std::string suite;
    std::string scale;
    std::vector<EntryResult> entries;

    /// The entry of that name, or null: it was not run.
    const EntryResult* entry(std::string_view name) const;
};

/// Reads what suite_report() wrote. Errors name `file`, which is only for messages, and the remedy.
Result<SuiteResults> parse_suite_results(const std::string& file, std::string_view text);

/// `measured` plus the entries of `kept` that it does not have, in the order of `names`. Errors:
/// texts that are not results, or of another suite or scale; they name `file`, which `kept` was
/// read from.
Result<std::string> add_to_results(const std::string& file, std::string_view kept,
                                   std::string_view measured,
                                   const std::vector<std::string>& names);

} // namespace occlude::tools
