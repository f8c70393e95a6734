// Parses JSON from others: limits the nesting for recursion, and checks the range of numbers.
#pragma once

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <stdexcept>
#include <string_view>

namespace occlude::tools {

/// Far more levels than any file needs, and far fewer than exhaust a stack.
constexpr int kDeepestJson = 256;

/// True if brackets outside strings are nested deeper than kDeepestJson.
inline bool nests_too_deeply(std::string_view json)
{
    int depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < json.size() && depth <= kDeepestJson; ++i) {
        const char c = json[i];
        if (c == '"') {
            in_string = !in_string;
        } else if (in_string) {
            i += c == '\\'; // an escaped character ends nothing
        } else {
            depth += (c == '{' || c == '[') - (c == '}' || c == ']');
        }
    }
    return depth > kDeepestJson;
}

/// Parses like Json::parse, but throws std::length_error if the nesting is too deep. (A callback of
/// the parser could tell, too, but it makes the parser visit all elements of a list after each
/// one.)
template <class Json>
Json parse_json(std::string_view text)
{
    if (nests_too_deeply(text)) {
        throw std::length_error{fmt::format("nested more than {} deep", kDeepestJson)};
    }
    return Json::parse(text);
}

/// A number that fits, without a fraction. Throws std::out_of_range for anything else; the sentence
/// quotes it and names it `what`.
template <class Json>
uint32_t whole_number(const Json& value, std::string_view what)
{
    if (!value.is_number_unsigned() || value.template get<uint64_t>() > UINT32_MAX) {
        throw std::out_of_range{fmt::format("{} must be a whole number from 0 to {}, not {}", what,
                                            UINT32_MAX, value.dump())};
    }
    return value.template get<uint32_t>();
}

} // namespace occlude::tools
