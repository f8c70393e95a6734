// What a generator's name may be followed by: "key=value,key=value".
#pragma once

#include <occlude/core/result.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace occlude::tools {

/// A whole number that the user may set: where it goes, and what is allowed.
struct Parameter {
    std::string_view key;
    uint64_t* value;
    uint64_t least;
    uint64_t most;
};

/// Any seed that can be typed.
inline constexpr uint64_t kMostSeed = 1000000000000;

/// What is wrong with a scene's source text.
Error bad_parameter(std::string_view source, const std::string& what);

/// Reads "key=value,key=value" into `parameters`; values are whole numbers with an optional suffix
/// k (thousand) or m (million). An error names the source, the key and what is allowed.
std::optional<Error> parse_parameters(std::string_view source, std::string_view text,
                                      std::span<const Parameter> parameters);

} // namespace occlude::tools
