// Options as text: describes the options that visit_options() names, and sets them by name.
//
// visit_options(options, visit) describes each option once:
//
//   visit("refine", o.refine, "description")                    a bool, or an enum whose values
//                                                               option_names() lists
//   visit("cell_size", o.cell_size, {1, 4096}, "description")   a number, and its range
//
// A number without a range does not compile. The range {} is any finite number from 0 on.
#pragma once

#include <occlude/core/option_range.h>

#include <charconv>
#include <cstddef>
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
    std::string accepted_values; ///< "a whole number from 1 to 4096", "one of off on"
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
    } else {
        std::string text = "one of";
        for (const std::string_view name : option_names(value)) {
            text += ' ';
            text += name;
        }
        return text;
    }
}

template <OptionNumber T>
std::string accepted_values(const OptionRange<T>& range)
{
    const std::string kind = std::is_integral_v<T> ? "a whole number" : "a number";
    if (!std::is_integral_v<T> && range.most == OptionRange<T>{}.most) {
        return kind + " that is at least " + to_text(range.least);
    }
    return kind + " from " + to_text(range.least) + " to " + to_text(range.most);
}

// A visitor for describe_options().
class OptionDescriber {
public:
    template <class T>
    requires(!OptionNumber<T>) void operator()(const char* name, const T& value,
                                               const char* description)
    {
        std::string text = description;
        if constexpr (std::is_enum_v<T>) {
            text += " (" + accepted_values(value) + ")";
        }
        infos.push_back({name, to_text(value), std::move(text), accepted_values(value)});
    }
    template <OptionNumber T>
    void operator()(const char* name, const T& value, OptionRange<std::type_identity_t<T>> range,
                    const char* description)
    {
        infos.push_back({name, to_text(value), description, accepted_values(range)});
    }

    std::vector<OptionInfo> infos;
};

// A visitor that sets one option from text.
class OptionSetter {
public:
    explicit OptionSetter(const OptionValue& setting)
        : setting_(setting)
    {
    }

    template <class T>
    requires(!OptionNumber<T>) void operator()(const char* name, T& value, const char*)
    {
        if (is_it(name) && !from_text(setting_.second, value)) {
            refuse(accepted_values(value));
        }
    }
    template <OptionNumber T>
    void operator()(const char* name, T& value, OptionRange<std::type_identity_t<T>> range,
                    const char*)
    {
        if (!is_it(name)) {
            return;
        }
        T read{};
        if (from_text(setting_.second, read) && range.contains(read)) {
            value = read;
        } else {
            refuse(accepted_values(range));
        }
    }

    // The error in the setting; the empty string if there is none.
    std::string problem() const
    {
        if (known_) {
            return problem_;
        }
        return "there is no option '" + setting_.first + "'; " +
               (names_.empty() ? "it has none" : "it has " + names_);
    }

private:
    bool is_it(const char* name)
    {
        names_ += names_.empty() ? "" : ", ";
        names_ += name;
        const bool same = setting_.first == name;
        known_ = known_ || same;
        return same;
    }
    void refuse(const std::string& accepted)
    {
        problem_ =
            "option '" + setting_.first + "' cannot be '" + setting_.second + "': give " + accepted;
    }

    const OptionValue& setting_;
    bool known_ = false;
    std::string names_;
    std::string problem_;
};

} // namespace detail

/// The options of a struct that has visit_options(), with their defaults.
template <class Options>
std::vector<OptionInfo> describe_options()
{
    Options defaults;
    detail::OptionDescriber describer;
    visit_options(defaults, describer);
    return std::move(describer.infos);
}

/// Sets one option by name. Returns the empty string, or the error: an unknown name with the list
/// of known ones, or a bad value with the accepted ones.
template <class Options>
std::string apply_option(Options& options, const OptionValue& setting)
{
    detail::OptionSetter setter(setting);
    visit_options(options, setter);
    return setter.problem();
}

/// Sets all of `values` in their order; stops at the first error.
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
