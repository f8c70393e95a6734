#include "commands/contenders.h"

#include <occlude/cull/registry.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace occlude::tools {

namespace {

constexpr std::array<std::string_view, 3> kReferences = {"frustum", "opt", "ideal"};

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

Result<std::set<std::string>> chosen_names(const std::string& list, const DeviceCaps& caps)
{
    std::set<std::string> chosen;
    if (list == "all" || list == "exact") {
        for (const AlgorithmInfo& info : algorithms()) {
            if (runs_on(info, caps) && (info.exact || list == "all")) {
                chosen.insert(info.name);
            }
        }
        return chosen;
    }
    for (const std::string& name : split_commas(list)) {
        const AlgorithmInfo* info = find_algorithm(name);
        if (info == nullptr) {
            return Error{ErrorCode::not_found,
                         fmt::format("--algorithms: there is no algorithm '{}'; choose all, exact, "
                                     "or from: {}",
                                     name, all_names())};
        }
        if (!runs_on(*info, caps)) {
            return Error{ErrorCode::unsupported,
                         fmt::format("--algorithms: {} reads the depth buffer, which the device "
                                     "'{}' does not offer; choose another --device",
                                     name, caps.name)};
        }
        chosen.insert(name);
    }
    return chosen;
}

Result<std::vector<OptionValue>> settings_of(const AlgorithmInfo& info,
                                             std::span<const std::string> sets)
{
    std::vector<OptionValue> values;
    for (const std::string& text : sets) {
        const auto set = parse_set(text);
        if (!set) {
            return set.error();
        }
        if (set->algorithm == info.name) {
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
        if (find_algorithm(set->algorithm) == nullptr) {
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
        if (!chosen->contains(info.name)) {
            continue;
        }
        const auto settings = settings_of(info, sets);
        if (!settings) {
            return settings.error();
        }
        contenders.push_back(
            {info.name, [name = info.name, values = *settings, clock](const Hierarchy& hierarchy) {
                 return make_culler(name, hierarchy, values, clock);
             }});
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
    const bool both_named = algorithms != "all" && algorithms != "exact" && hierarchies != "all";
    Pairing pairing;
    for (const Contender& contender : contenders) {
        const AlgorithmInfo& info = *find_algorithm(contender.name);
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
