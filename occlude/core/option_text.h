// Options as text: structs whose options visit_options() names are described, and set by name.
//
// visit_options(options, visit) calls visit(name, value, description) for each option: bool, a
// number, or an enum whose values option_names() lists.
#pragma once

#include <charconv>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

namespace occlude {

struct OptionInfo {
    std::string name;
    std::string default_value;
    std::string description;
};

/// Name and value.
using OptionValue = std::pair<std::string, std::string>;

namespace detail {

inline std::string to_text(bool value)
{
    return value ? "true" : "false";
}

template <class T>
std::string to_text(const T& value)
{
    if constexpr (std::is_enum_v<T>) {
        return std::string{option_names(value)[static_cast<size_t>(value)]};
    } else {
        char buffer[64];
        const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
        return {buffer, end};
    }
}

inline bool from_text(std::string_view text, bool& value)
{
    const bool yes = text == "true" || text == "on" || text == "1";
    const bool no = text == "false" || text == "off" || text == "0";
    value = yes;
    return yes || no;
}

template <class T>
bool from_text(std::string_view text, T& value)
{
    if constexpr (std::is_enum_v<T>) {
        const auto names = option_names(value);
        for (size_t i = 0; i < names.size(); ++i) {
            if (names[i] == text) {
                value = static_cast<T>(i);
                return true;
            }
        }
        return false;
    } else {
        const char* end = text.data() + text.size();
        const auto result = std::from_chars(text.data(), end, value);
        return result.ec == std::errc{} && result.ptr == end;
    }
}

template <class T>
std::string accepted_values(const T& value)
{
    if constexpr (std::is_same_v<T, bool>) {
        return "true or false";
    } else if constexpr (std::is_enum_v<T>) {
        std::string text = "one of";
        for (const std::string_view name : option_names(value)) {
            text += ' ';
            text += name;
        }
        return text;
    } else if constexpr (std::is_integral_v<T>) {
        return "a whole number from 0 to " + std::to_string(std::numeric_limits<T>::max());
    } else {
        return "a number";
    }
}

} // namespace detail

/// The options of a struct that visit_options() knows, with their defaults.
template <class Options>
std::vector<OptionInfo> describe_options()
{
    std::vector<OptionInfo> infos;
    Options defaults;
    visit_options(defaults, [&](const char* name, const auto& value, const char* description) {
        std::string text = description;
        if constexpr (std::is_enum_v<std::remove_cvref_t<decltype(value)>>) {
            text += " (" + detail::accepted_values(value) + ")";
        }
        infos.push_back({name, detail::to_text(value), text});
    });
    return infos;
}

/// Sets one option by name. The empty string, or what is wrong: the unknown name with the known
/// ones, or the value with what it may be.
template <class Options>
std::string apply_option(Options& options, const OptionValue& setting)
{
    bool known = false;
    std::string problem;
    std::string names;
    visit_options(options, [&](const char* name, auto& value, const char*) {
        names += names.empty() ? "" : ", ";
        names += name;
        if (setting.first != name) {
            return;
        }
        known = true;
        if (!detail::from_text(setting.second, value)) {
            problem = "option '" + setting.first + "' cannot be '" + setting.second + "': give " +
                      detail::accepted_values(value);
        }
    });
    if (!known) {
        problem = "there is no option '" + setting.first + "'; " +
                  (names.empty() ? "it has none" : "it has " + names);
    }
    return problem;
}

/// Sets all of `values`, in their order, up to the first that is wrong.
template <class Options>
std::string apply_options(Options& options, std::span<const OptionValue> values)
{
    for (const OptionValue& value : values) {
        if (std::string problem = apply_option(options, value); !problem.empty()) {
            return problem;
        }
    }
    return {};
}

} // namespace occlude
