#include "session/contenders.h"

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>

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

std::string tree_names()
{
    std::string names;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        names += (names.empty() ? "" : ", ") + tree_set_name(kind.name);
    }
    return names;
}

bool runs_on(const AlgorithmInfo& info, const DeviceCaps& caps)
{
    return !info.needs.depth_read || caps.read_depth;
}

// One entry of --algorithms.
struct Choice {
    const AlgorithmInfo* info = nullptr;
    std::string label; ///< as it was typed
    std::vector<OptionValue> options;
};

// "lazy_grid:update=busy": an algorithm, and options for this entry alone.
Result<Choice> parse_choice(const std::string& text, const DeviceCaps& caps)
{
    const auto entry = parse_entry(text);
    if (!entry) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--algorithms: '{}' is not an algorithm with options; write "
                                 "ALGORITHM:OPTION=VALUE, such as chc:threshold=20",
                                 text)};
    }
    const std::string& name = entry->name;
    const Choice choice{find_algorithm(name), text, entry->options};
    if (choice.info == nullptr) {
        return Error{ErrorCode::not_found,
                     fmt::format("--algorithms: there is no algorithm '{}'; choose all, exact, "
                                 "or from: {}",
                                 name, all_names())};
    }
    if (!runs_on(*choice.info, caps)) {
        return Error{ErrorCode::unsupported,
                     fmt::format("--algorithms: {} reads the depth buffer, which the device "
                                 "'{}' does not offer; choose another --device",
                                 name, caps.name)};
    }
    return choice;
}

bool is_group(std::string_view name)
{
    return name == "all" || name == "exact";
}

// Each entry once, in the order of the registry.
Result<std::vector<Choice>> choose(const std::string& list, const DeviceCaps& caps,
                                   References references)
{
    std::vector<Choice> choices;
    const auto add = [&](Choice choice) {
        if (std::none_of(choices.begin(), choices.end(),
                         [&](const Choice& c) { return c.label == choice.label; })) {
            choices.push_back(std::move(choice));
        }
    };
    for (const std::string& entry : split_commas(list)) {
        if (is_group(entry)) {
            for (const AlgorithmInfo& info : algorithms()) {
                if (runs_on(info, caps) && (info.exact || entry == "all")) {
                    add({&info, info.name, {}});
                }
            }
            continue;
        }
        auto choice = parse_choice(entry, caps);
        if (!choice) {
            return choice.error();
        }
        add(std::move(*choice));
    }
    if (references == References::always) {
        for (const std::string_view name : kReferences) {
            add({find_algorithm(name), std::string{name}, {}});
        }
    }
    std::stable_sort(choices.begin(), choices.end(),
                     [](const Choice& a, const Choice& b) { return a.info < b.info; });
    return choices;
}

// Every setting must apply to something: a typing error must not pass as a measurement.
Result<bool> check_settings(std::span<const std::string> sets, std::span<const Choice> choices)
{
    for (const std::string& text : sets) {
        const auto set = parse_set(text);
        if (!set) {
            return set.error();
        }
        if (std::any_of(hierarchy_kinds().begin(), hierarchy_kinds().end(),
                        [&](const HierarchyKind& kind) {
                            return tree_set_name(kind.name) == set->algorithm;
                        })) {
            continue; // choose_hierarchies() checks it
        }
        if (find_algorithm(set->algorithm) == nullptr) {
            return Error{ErrorCode::not_found,
                         fmt::format("--set {}: there is no algorithm '{}'; there are: {}; and the "
                                     "hierarchies: {}",
                                     text, set->algorithm, all_names(), tree_names())};
        }
        if (std::none_of(choices.begin(), choices.end(),
                         [&](const Choice& c) { return c.info->name == set->algorithm; })) {
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
                                                 const SecondsClock& clock)
{
    const auto choices = choose(list, caps, references);
    if (!choices) {
        return choices.error();
    }
    if (const auto checked = check_settings(sets, *choices); !checked) {
        return checked.error();
    }
    std::vector<Contender> contenders;
    for (const Choice& choice : *choices) {
        std::vector<OptionValue> values = settings_of(choice.info->name, sets);
        values.insert(values.end(), choice.options.begin(), choice.options.end());
        const auto asked_time = std::make_shared<bool>(false);
        const SecondsClock noticing = [clock, asked_time] {
            *asked_time = true;
            return clock();
        };
        contenders.push_back({.name = choice.label,
                              .make =
                                  [name = choice.info->name, values = std::move(values),
                                   noticing](const Hierarchy& hierarchy) {
                                      return make_culler(name, hierarchy, values, noticing);
                                  },
                              .remembers = choice.info->remembers,
                              .asked_time = asked_time});
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

Pairing pair_with_hierarchies(std::span<const Contender> contenders,
                              std::span<const HierarchyChoice> trees, const std::string& algorithms,
                              const std::string& hierarchies)
{
    const std::vector<std::string> entries = split_commas(algorithms);
    const bool both_named =
        hierarchies != "all" && std::none_of(entries.begin(), entries.end(), is_group);
    Pairing pairing;
    for (const Contender& contender : contenders) {
        const AlgorithmInfo& info =
            *find_algorithm(contender.name.substr(0, contender.name.find(':')));
        std::vector<std::string> left_out;
        for (const HierarchyChoice& tree : trees) {
            if (!both_named && !info.hierarchies.empty() && !suits(info, tree.kind)) {
                left_out.push_back(tree.label);
                continue;
            }
            pairing.contenders.push_back(contender);
            pairing.contenders.back().hierarchy = tree.label;
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
