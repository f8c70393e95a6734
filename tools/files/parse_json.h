// JSON that others wrote: parsed to a depth that may be walked by recursion, numbers in range.
#pragma once

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <stdexcept>
#include <string_view>

namespace occlude::tools {

/// Far more levels than any file needs, far fewer than end a stack.
constexpr int kDeepestJson = 256;

/// Whether brackets outside of strings are nested deeper than kDeepestJson.
inline bool nests_too_deeply(std::string_view json)
{
    int depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < json.size() && depth <= kDeepestJson; ++i) {
        const char c = json[i];
        if (c == '"') {
            in_string = !in_string;
        } else if (in_string) {
            i += c == '\\'; // what is escaped ends nothing
        } else {
            depth += (c == '{' || c == '[') - (c == '}' || c == ']');
        }
    }
    return depth > kDeepestJson;
}

/// Parses as Json::parse does, and throws std::length_error for what nests too deeply. (A callback
/// of the parser could tell, too, but makes it look at all elements of a list after each.)
template <class Json>
Json parse_json(std::string_view text)
{
    if (nests_too_deeply(text)) {
        throw std::length_error{fmt::format("nested more than {} deep", kDeepestJson)};
    }
    return Json::parse(text);
}

/// A number that fits, without a fraction; throws std::out_of_range for anything else, which is
/// quoted and said to be `what`.
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
