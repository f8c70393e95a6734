#include "suites/suite_results.h"

#include "files/json.h"

#include <fmt/core.h>

#include <limits>

namespace occlude::tools {

namespace {

template <class Map>
double figure_of(const Map& figures, std::string_view name)
{
    const auto found = figures.find(name);
    return found != figures.end() ? found->second : std::numeric_limits<double>::quiet_NaN();
}

// The numbers below `json` by their path, with dots between the keys. Leaves out lists.
void collect_numbers(const Json& json, const std::string& prefix,
                     std::map<std::string, double, std::less<>>& figures)
{
    for (const auto& [key, value] : json.members()) {
        if (value.is_number()) {
            figures[prefix + key] = value.number();
        } else if (value.is_object()) {
            collect_numbers(value, prefix + key + '.', figures);
        }
    }
}

RunResult read_run(const Json& json)
{
    RunResult run;
    run.algorithm = json.at("algorithm").text();
    run.guarantee = json.at("guarantee").text();
    collect_numbers(json, "", run.figures);
    return run;
}

// Throws if something is missing or of another kind.
EntryResult read_entry(const Json& json)
{
    EntryResult entry;
    entry.name = json.at("entry").text();
    entry.date = json.at("date").text();
    entry.scene = json.at("scene").at("name").text();
    entry.path = json.at("path").text();
    const Json& size = json.at("size");
    entry.size = fmt::format("{} x {}", whole_number(size.at(size_t{0}), "size[0]"),
                             whole_number(size.at(size_t{1}), "size[1]"));
    entry.hierarchy = json.at("hierarchy").text();
    entry.device = fmt::format("{}: {}", json.at("device").at("api").text(),
                               json.at("device").at("renderer").text());
    entry.split = json.at("split").text();
    for (const Json& set : json.at("sets").elements()) {
        entry.sets.push_back(set.text());
    }
    collect_numbers(json, "", entry.figures);
    for (const Json& run : json.at("runs").elements()) {
        entry.runs.push_back(read_run(run));
    }
    return entry;
}

Error not_results(const std::string& file, const std::string& why)
{
    return {ErrorCode::bad_data,
            fmt::format("{}: these are no results of a suite ({}); give a file that 'occlude bench "
                        "--suite NAME --json FILE' wrote",
                        file, why)};
}

std::string name_of(const Json& document)
{
    return document.at("entry").text();
}

const Json* find_document(const Json& results, const std::string& name)
{
    for (const Json& document : results.at("documents").elements()) {
        if (name_of(document) == name) {
            return &document;
        }
    }
    return nullptr;
}

} // namespace

double RunResult::operator[](std::string_view figure) const
{
    return figure_of(figures, figure);
}

double EntryResult::operator[](std::string_view figure) const
{
    return figure_of(figures, figure);
}

const RunResult* EntryResult::run(std::string_view algorithm) const
{
    for (const RunResult& run : runs) {
        if (run.algorithm == algorithm) {
            return &run;
        }
    }
    return nullptr;
}

const EntryResult* SuiteResults::entry(std::string_view name) const
{
    for (const EntryResult& entry : entries) {
        if (entry.name == name) {
            return &entry;
        }
    }
    return nullptr;
}

Result<SuiteResults> parse_suite_results(const std::string& file, std::string_view text)
{
    std::string place;
    try {
        const Json json = Json::parse(text);
        SuiteResults results;
        results.suite = json.at("suite").text();
        results.scale = json.at("scale").text();
        for (const Json& document : json.at("documents").elements()) {
            place = fmt::format("documents[{}]: ", results.entries.size());
            results.entries.push_back(read_entry(document));
        }
        return results;
    } catch (const std::exception& error) {
        return not_results(file, place + error.what());
    }
}

Result<std::string> add_to_results(const std::string& file, std::string_view kept,
                                   std::string_view measured, const std::vector<std::string>& names)
{
    try {
        const Json old = Json::parse(kept);
        Json results = Json::parse(measured);
        for (const char* key : {"suite", "scale"}) {
            if (old.at(key) != results.at(key)) {
                return Error{ErrorCode::invalid_argument,
                             fmt::format("{}: its {} is {}, not {}; give another file, or omit "
                                         "--add to replace it",
                                         file, key, old.at(key).dump(), results.at(key).dump())};
            }
        }
        Json documents = Json::array();
        for (const std::string& name : names) {
            const Json* document = find_document(results, name);
            document = document != nullptr ? document : find_document(old, name);
            if (document != nullptr) {
                documents.push_back(*document);
            }
        }
        results.set("documents", std::move(documents));
        constexpr int kIndent = 1;
        return results.dump(kIndent) + "\n";
    } catch (const std::exception& error) {
        return not_results(file, error.what());
    }
}

} // namespace occlude::tools
