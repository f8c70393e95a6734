#include "commands/comparison.h"
#include "commands/open_session.h"
#include "measure/measure.h"
#include "measure/verify.h"
#include "report/json_report.h"
#include "report/table.h"
#include "suites/papers_report.h"
#include "suites/suite.h"
#include "suites/suite_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>

namespace occlude::tools {

namespace {

std::string today()
{
    const auto now = std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now());
    const std::chrono::year_month_day date{now};
    return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()),
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

Result<std::string> read_text(const std::string& file)
{
    std::ifstream stream{file, std::ios::binary};
    if (!stream) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: cannot be read; give a file that 'occlude bench --suite "
                                 "NAME --json FILE' wrote",
                                 file)};
    }
    return std::string{std::istreambuf_iterator<char>{stream}, {}};
}

Result<bool> write_text(const std::string& file, std::string_view text)
{
    auto opened = OutputFile::open(file);
    return opened ? opened->commit(text) : Result<bool>{opened.error()};
}

Result<Scale> parse_scale(const std::string& text)
{
    for (const Scale scale : {Scale::small, Scale::full}) {
        if (text == to_string(scale)) {
            return scale;
        }
    }
    return Error{ErrorCode::invalid_argument,
                 fmt::format("--scale: there is no scale '{}'; choose small or full", text)};
}

std::vector<std::string> names_of(const std::vector<SuiteEntry>& entries)
{
    std::vector<std::string> names;
    for (const SuiteEntry& entry : entries) {
        names.push_back(entry.name);
    }
    return names;
}

// Keeps only the entries that --only names.
Result<std::vector<SuiteEntry>> choose_entries(const std::vector<SuiteEntry>& all,
                                               const std::string& only)
{
    if (only.empty()) {
        return all;
    }
    std::vector<SuiteEntry> chosen;
    for (const std::string& name : split_commas(only)) {
        const auto found = std::find_if(
            all.begin(), all.end(), [&](const SuiteEntry& entry) { return entry.name == name; });
        if (found == all.end()) {
            return Error{ErrorCode::not_found,
                         fmt::format("--only: the suite has no entry '{}'; choose from {}", name,
                                     fmt::join(names_of(all), ", "))};
        }
        chosen.push_back(*found);
    }
    return chosen;
}

CompareOptions compare_options(const SuiteEntry& entry, const SuiteOptions& options)
{
    CompareOptions compare;
    compare.stage = entry.stage;
    compare.stage.device = options.device;
    compare.stage.cache_folder = options.cache_folder;
    compare.algorithms = entry.algorithms;
    return compare;
}

Result<BenchDocument> measure_entry(const SuiteEntry& entry, const SuiteOptions& options,
                                    const Streams& streams)
{
    const CompareOptions compare = compare_options(entry, options);
    const auto session = open_session(entry.scene, compare.stage, streams);
    if (!session) {
        return session.error();
    }
    const auto views = (*session)->views(compare.stage.path);
    if (!views) {
        return views.error();
    }
    const Stage stage = (*session)->stage();
    const auto contenders = contenders_of(**session, compare, References::always);
    if (!contenders) {
        return contenders.error();
    }
    Progress progress{streams.err, streams.watcher, "measuring " + entry.name};
    auto runs = measure(stage, *contenders, *views,
                        {.sample_every = std::min(entry.sample_every, views->size()),
                         .verify_every = entry.verify_every,
                         .progress = [&](double share) { progress.show(share); }});
    if (!runs) {
        return runs.error();
    }
    BenchDocument document = describe(**session, compare, compare.stage.path, views->size());
    document.entry = entry.name;
    document.date = today();
    document.sample_every = entry.sample_every;
    document.runs = std::move(*runs);
    return document;
}

// The files of the suite. The results are written after every entry, so that an interrupted run
// leaves what it has measured.
class SuiteFiles {
public:
    static Result<SuiteFiles> open(const SuiteOptions& options, const Suite& suite,
                                   std::vector<std::string> names)
    {
        SuiteFiles files;
        files.options_ = options;
        files.suite_ = &suite;
        files.names_ = std::move(names);
        if (files.options_.report.empty() && suite.has_papers) {
            files.options_.report = kDefaultReport;
            std::error_code ignored; // opening the file reports the error
            std::filesystem::create_directories(
                std::filesystem::path{files.options_.report}.parent_path(), ignored);
        }
        for (const std::string& file : {files.options_.json, files.options_.report}) {
            if (!file.empty()) {
                if (const auto opened = OutputFile::open(file); !opened) {
                    return opened.error();
                }
            }
        }
        if (options.add && std::filesystem::exists(options.json)) {
            auto text = read_text(options.json);
            if (!text) {
                return text.error();
            }
            files.kept_ = std::move(*text);
        }
        return files;
    }

    Result<bool> write(std::span<const BenchDocument> documents) const
    {
        std::string text = suite_report(options_.suite, options_.scale, documents);
        if (!kept_.empty()) {
            auto added = add_to_results(options_.json, kept_, text, names_);
            if (!added) {
                return added.error();
            }
            text = std::move(*added);
        }
        if (!options_.json.empty()) {
            if (const auto written = write_text(options_.json, text); !written) {
                return written.error();
            }
        }
        return write_report(text);
    }

    Result<bool> write_report(const std::string& results_text) const
    {
        if (!suite_->has_papers) {
            return true;
        }
        const auto results = parse_suite_results(options_.from, results_text);
        if (!results) {
            return results.error();
        }
        return write_text(options_.report, papers_report(*results));
    }

private:
    SuiteOptions options_;
    const Suite* suite_ = nullptr;
    std::vector<std::string> names_;
    std::string kept_;
};

// --from: reports without measuring.
Result<int> report_only(const SuiteOptions& options, const Suite& suite, const Streams& streams)
{
    if (!suite.has_papers) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--from: the suite {} has no published figures to report beside",
                                 suite.name)};
    }
    const auto text = read_text(options.from);
    if (!text) {
        return text.error();
    }
    const auto files = SuiteFiles::open(options, suite, {});
    if (!files) {
        return files.error();
    }
    const auto written = files->write_report(*text);
    if (!written) {
        return written.error();
    }
    streams.out << "reported on " << options.from << '\n';
    return kDone;
}

// The tables show what inexact algorithms leave out, so that no message is needed.
void print_broken_promises(std::span<const AlgorithmRun> runs, std::ostream& out)
{
    for (const AlgorithmRun& run : runs) {
        if (run.guarantee.kind == Guarantee::Kind::exact) {
            print_differences({&run, 1}, out);
        }
    }
}

// Errors in the suite's own tables and in the device are reported before any scene is made.
Result<bool> check_entries(std::span<const SuiteEntry> entries, const SuiteOptions& options,
                           std::ostream& notes)
{
    for (const SuiteEntry& entry : entries) {
        if (const auto checked = check_compare_options(compare_options(entry, options), notes);
            !checked) {
            return checked.error();
        }
    }
    return true;
}

Result<int> measure_suite(const SuiteOptions& options, const Suite& suite, const Streams& streams)
{
    const auto scale = parse_scale(options.scale);
    if (!scale) {
        return scale.error();
    }
    const std::vector<SuiteEntry> all = suite.entries(*scale);
    const auto entries = choose_entries(all, options.only);
    if (!entries) {
        return entries.error();
    }
    if (const auto checked = check_entries(*entries, options, streams.err); !checked) {
        return checked.error();
    }
    CompareOptions table_files;
    table_files.csv = options.csv;
    table_files.html = options.html;
    auto tables = ReportFiles::open(table_files);
    if (!tables) {
        return tables.error();
    }
    const auto files = SuiteFiles::open(options, suite, names_of(all));
    if (!files) {
        return files.error();
    }
    std::vector<BenchDocument> documents;
    bool kept = true;
    std::string failures; // an entry that cannot be measured does not stop the others
    ErrorCode first_failure{};
    for (const SuiteEntry& entry : *entries) {
        auto document = measure_entry(entry, options, streams);
        if (!document) {
            first_failure = failures.empty() ? document.error().code : first_failure;
            failures += fmt::format("{}{}: {}", failures.empty() ? "" : "; ", entry.name,
                                    document.error().message);
            continue;
        }
        streams.out << entry.name << '\n' << bench_table(*document) << std::endl;
        print_broken_promises(document->runs, streams.out);
        kept = kept && promises_kept(document->runs);
        documents.push_back(std::move(*document));
        if (const auto written = files->write(documents); !written) {
            return written.error();
        }
    }
    if (const auto written = tables->write(documents); !written) {
        return written.error();
    }
    if (!failures.empty()) {
        return Error{first_failure, "not measured: " + failures};
    }
    return kept ? kDone : kDiffers;
}

} // namespace

Result<int> suite_command(const SuiteOptions& options, const Streams& streams)
{
    const Suite* suite = find_suite(options.suite);
    if (suite == nullptr) {
        return Error{ErrorCode::not_found,
                     fmt::format("--suite: there is no suite '{}'; choose from {}", options.suite,
                                 suite_names())};
    }
    if (options.add && options.json.empty()) {
        return Error{ErrorCode::invalid_argument, "--add: name the file to add to with --json"};
    }
    return options.from.empty() ? measure_suite(options, *suite, streams)
                                : report_only(options, *suite, streams);
}

} // namespace occlude::tools
