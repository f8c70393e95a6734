#include "commands/contenders.h"

#include <occlude/cull/registry.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

namespace occlude::tools {

namespace {

constexpr std::array<std::string_view, 3> kReferences = {"frustum", "opt", "ideal"};

// A run by its name: an algorithm, and after '@' a label that tells runs of it apart.
struct RunName {
    std::string algorithm;
    std::string label; // empty: none
};

RunName parse_run_name(const std::string& text)
{
    const size_t at = text.find('@');
    return at == std::string::npos ? RunName{text, ""}
                                   : RunName{text.substr(0, at), text.substr(at + 1)};
}

std::string all_names()
{
    std::string names;
    for (const AlgorithmInfo& info : algorithms()) {
        names += (names.empty() ? "" : ", ") + info.name;
    }
    return names;
}

bool runs_on(const AlgorithmInfo& info, const DeviceCaps& caps)
{
    return !info.needs.depth_read || caps.read_depth;
}

Result<bool> check_name(const std::string& text, const DeviceCaps& caps)
{
    const RunName name = parse_run_name(text);
    const AlgorithmInfo* info = find_algorithm(name.algorithm);
    if (info == nullptr) {
        return Error{ErrorCode::not_found,
                     fmt::format("--algorithms: there is no algorithm '{}'; choose all, exact, "
                                 "or from: {}",
                                 name.algorithm, all_names())};
    }
    const bool plain = std::all_of(name.label.begin(), name.label.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    });
    if (!plain || (name.label.empty() && text.back() == '@')) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--algorithms: '{}' has no proper label; write ALGORITHM@LABEL "
                                 "with a label of letters, digits, '_' and '-', such as {}@other",
                                 text, name.algorithm)};
    }
    if (!runs_on(*info, caps)) {
        return Error{ErrorCode::unsupported,
                     fmt::format("--algorithms: {} reads the depth buffer, which the device "
                                 "'{}' does not offer; choose another --device",
                                 text, caps.name)};
    }
    return true;
}

// The names of all runs, as typed.
Result<std::set<std::string>> chosen_names(const std::string& list, const DeviceCaps& caps)
{
    std::set<std::string> chosen;
    for (const std::string& part : split_commas(list)) {
        if (part == "all" || part == "exact") {
            for (const AlgorithmInfo& info : algorithms()) {
                if (runs_on(info, caps) && (info.exact || part == "all")) {
                    chosen.insert(info.name);
                }
            }
            continue;
        }
        if (const auto checked = check_name(part, caps); !checked) {
            return checked.error();
        }
        chosen.insert(part);
    }
    return chosen;
}

Result<std::vector<OptionValue>> settings_of(const std::string& run,
                                             std::span<const std::string> sets)
{
    std::vector<OptionValue> values;
    for (const std::string& text : sets) {
        const auto set = parse_set(text);
        if (!set) {
            return set.error();
        }
        if (set->algorithm == run) {
            values.emplace_back(set->option, set->value);
        }
    }
    return values;
}

// Every setting must reach somebody: a typing error must not pass as a measurement.
Result<bool> check_settings(std::span<const std::string> sets, const std::set<std::string>& chosen)
{
    for (const std::string& text : sets) {
        const auto set = parse_set(text);
        if (!set) {
            return set.error();
        }
        if (find_algorithm(parse_run_name(set->algorithm).algorithm) == nullptr) {
            return Error{ErrorCode::not_found,
                         fmt::format("--set {}: there is no algorithm '{}'; there are: {}", text,
                                     set->algorithm, all_names())};
        }
        if (!chosen.contains(set->algorithm)) {
            return Error{ErrorCode::invalid_argument,
                         fmt::format("--set {}: {} does not take part; add it to --algorithms",
                                     text, set->algorithm)};
        }
    }
    return true;
}

} // namespace

Result<std::vector<Contender>> choose_contenders(const std::string& list,
                                                 std::span<const std::string> sets,
                                                 const DeviceCaps& caps, References references,
                                                 const Clock& clock)
{
    auto chosen = chosen_names(list, caps);
    if (!chosen) {
        return chosen.error();
    }
    if (references == References::always) {
        chosen->insert(kReferences.begin(), kReferences.end());
    }
    if (const auto checked = check_settings(sets, *chosen); !checked) {
        return checked.error();
    }
    std::vector<Contender> contenders;
    for (const AlgorithmInfo& info : algorithms()) {
        for (const std::string& run : *chosen) { // the one without a label first
            if (parse_run_name(run).algorithm != info.name) {
                continue;
            }
            const auto settings = settings_of(run, sets);
            if (!settings) {
                return settings.error();
            }
            contenders.push_back(
                {.name = run,
                 .make =
                     [name = info.name, values = *settings, clock](const Hierarchy& tree) {
                         return make_culler(name, tree, values, clock);
                     },
                 .remembers = info.remembers});
        }
    }
    return contenders;
}

namespace {

bool suits(const AlgorithmInfo& info, const std::string& kind)
{
    return std::find(info.hierarchies.begin(), info.hierarchies.end(), kind) !=
           info.hierarchies.end();
}

std::string left_out_note(const AlgorithmInfo& info, std::span<const std::string> kinds)
{
    return fmt::format("{} is left out on {}: it tests leaves, and there many items are in inner "
                       "nodes; name it in --algorithms and the hierarchy in --hierarchy to run it "
                       "all the same",
                       info.name, fmt::join(kinds, ", "));
}

} // namespace

Result<Pairing> pair_with_hierarchies(std::span<const Contender> contenders,
                                      const std::string& algorithms, const std::string& hierarchies)
{
    const auto kinds = parse_hierarchies(hierarchies);
    if (!kinds) {
        return kinds.error();
    }
    const std::vector<std::string> named = split_commas(algorithms);
    const bool both_named =
        std::none_of(named.begin(), named.end(),
                     [](const std::string& part) { return part == "all" || part == "exact"; }) &&
        hierarchies != "all";
    Pairing pairing;
    for (const Contender& contender : contenders) {
        const AlgorithmInfo& info = *find_algorithm(parse_run_name(contender.name).algorithm);
        std::vector<std::string> left_out;
        for (const std::string& kind : *kinds) {
            if (!both_named && !info.hierarchies.empty() && !suits(info, kind)) {
                left_out.push_back(kind);
                continue;
            }
            pairing.contenders.push_back(contender);
            pairing.contenders.back().hierarchy = kind;
            if (info.hierarchies.empty()) {
                break;
            }
        }
        if (!left_out.empty()) {
            pairing.notes.push_back(left_out_note(info, left_out));
        }
    }
    return pairing;
}

} // namespace occlude::tools
