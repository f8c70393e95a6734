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
                                                 const DeviceCaps& caps, References references)
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
            contenders.push_back({run,
                                  [name = info.name, values = *settings](const Hierarchy& tree) {
                                      return make_culler(name, tree, values);
                                  },
                                  info.remembers});
        }
    }
    return contenders;
}

} // namespace occlude::tools
