#include "generate/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace occlude::tools {
namespace {

/// A whole number with an optional suffix k (thousand) or m (million): "10m", "1.5m", "250k".
std::optional<uint64_t> parse_count(std::string_view text)
{
    uint64_t scale = 1;
    if (!text.empty() && (text.back() == 'k' || text.back() == 'K')) {
        scale = 1000;
    } else if (!text.empty() && (text.back() == 'm' || text.back() == 'M')) {
        scale = 1000000;
    }
    if (scale > 1) {
        text.remove_suffix(1);
    }
    uint64_t whole = 0;
    const char* end = text.data() + text.size();
    const auto [at, failed] = std::from_chars(text.data(), end, whole);
    constexpr uint64_t kMost = 1000000000000;
    if (failed != std::errc{} || whole > kMost) {
        return std::nullopt;
    }
    uint64_t value = whole * scale;
    if (at != end) {
        if (*at != '.' || scale == 1 || at + 1 == end) {
            return std::nullopt;
        }
        for (const char* digit = at + 1; digit != end; ++digit) {
            if (*digit < '0' || *digit > '9') {
                return std::nullopt;
            }
            scale /= 10;
            value += scale * static_cast<uint64_t>(*digit - '0');
        }
    }
    return value;
}

} // namespace

Error bad_parameter(std::string_view source, const std::string& what)
{
    return {ErrorCode::invalid_argument, fmt::format("{}: {}", source, what)};
}

std::optional<Error> parse_parameters(std::string_view source, std::string_view text,
                                      std::span<const Parameter> parameters)
{
    std::string known;
    for (const Parameter& parameter : parameters) {
        known += fmt::format("{}{}", known.empty() ? "" : ", ", parameter.key);
    }
    while (!text.empty()) {
        const std::string_view entry = text.substr(0, text.find(','));
        text.remove_prefix(std::min(text.size(), entry.size() + 1));
        const size_t equals = entry.find('=');
        const std::string_view key = entry.substr(0, equals);
        const Parameter* found = nullptr;
        for (const Parameter& parameter : parameters) {
            if (parameter.key == key) {
                found = &parameter;
            }
        }
        if (found == nullptr) {
            return bad_parameter(source,
                                 fmt::format("unknown parameter '{}'; known are {}", key, known));
        }
        const std::string_view digits =
            equals == std::string_view::npos ? std::string_view{} : entry.substr(equals + 1);
        const auto value = parse_count(digits);
        if (!value || *value < found->least || *value > found->most) {
            return bad_parameter(source, fmt::format("'{}' is not a value for {}; give a whole "
                                                     "number from {} to {} (10k, 1.5m allowed)",
                                                     digits, key, found->least, found->most));
        }
        *found->value = *value;
    }
    return std::nullopt;
}

} // namespace occlude::tools
