#include "session/hierarchies.h"

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools {

std::string tree_set_name(std::string_view kind)
{
    const std::string name{kind};
    return find_algorithm(name) == nullptr ? name : name + "_tree";
}

namespace {

std::vector<std::string> all_kinds()
{
    std::vector<std::string> names;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        names.emplace_back(kind.name);
    }
    return names;
}

// Errors name the place where it was set.
Result<bool> check_options(std::string_view kind, std::span<const OptionValue> options,
                           std::string_view where)
{
    const auto tree = find_hierarchy_kind(kind)->build_with({}, 0, options);
    return tree ? Result<bool>{true}
                : Error{tree.error().code, fmt::format("{}: {}", where, tree.error().message)};
}

// A setting for a tree that is not built must not pass as a measurement.
Result<bool> check_settings(std::span<const std::string> sets,
                            std::span<const HierarchyChoice> choices)
{
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        const std::vector<OptionValue> values = settings_of(tree_set_name(kind.name), sets);
        if (values.empty()) {
            continue;
        }
        if (std::none_of(choices.begin(), choices.end(),
                         [&](const HierarchyChoice& c) { return c.kind == kind.name; })) {
            return Error{ErrorCode::invalid_argument,
                         fmt::format("--set {}.{}: the hierarchy {} does not take part; name it in "
                                     "--hierarchy",
                                     tree_set_name(kind.name), values.front().first, kind.name)};
        }
        if (const auto checked =
                check_options(kind.name, values, "--set " + tree_set_name(kind.name));
            !checked) {
            return checked.error();
        }
    }
    return true;
}

Result<HierarchyChoice> parse_choice(const std::string& text, std::span<const std::string> sets)
{
    const auto entry = parse_entry(text);
    if (!entry) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--hierarchy: '{}' is not a hierarchy with options; write "
                                 "HIERARCHY:OPTION=VALUE, such as bvh:leaf_triangles=400",
                                 text)};
    }
    if (find_hierarchy_kind(entry->name) == nullptr) {
        return Error{ErrorCode::unsupported,
                     fmt::format("--hierarchy: '{}' is not available in this version; choose all, "
                                 "or from: {}",
                                 entry->name, hierarchy_names())};
    }
    if (const auto checked = check_options(entry->name, entry->options, "--hierarchy " + text);
        !checked) {
        return checked.error();
    }
    HierarchyChoice choice{entry->name, text, settings_of(tree_set_name(entry->name), sets)};
    choice.options.insert(choice.options.end(), entry->options.begin(), entry->options.end());
    return choice;
}

} // namespace

std::string hierarchy_names()
{
    return fmt::format("{}", fmt::join(all_kinds(), ", "));
}

Result<std::vector<HierarchyChoice>> choose_hierarchies(std::string_view text,
                                                        std::span<const std::string> sets)
{
    std::vector<HierarchyChoice> choices;
    for (const std::string& entry : text == "all" ? all_kinds() : split_commas(text)) {
        auto choice = parse_choice(entry, sets);
        if (!choice) {
            return choice.error();
        }
        if (std::none_of(choices.begin(), choices.end(),
                         [&](const HierarchyChoice& c) { return c.label == choice->label; })) {
            choices.push_back(std::move(*choice));
        }
    }
    if (const auto checked = check_settings(sets, choices); !checked) {
        return checked.error();
    }
    return choices;
}

} // namespace occlude::tools
