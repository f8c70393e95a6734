#include "options/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace occlude::tools {

// The whole text as a number, or nothing.
template <class Number>
static std::optional<Number> parse_number(std::string_view text)
{
    Number value{};
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc{} || end != text.data() + text.size()) {
        return std::nullopt;
    }
    return value;
}

Result<glm::ivec2> parse_size(std::string_view text)
{
    constexpr int kMaxSide = 16384;
    const size_t x = text.find('x');
    if (x != std::string_view::npos) {
        const auto width = parse_number<int>(text.substr(0, x));
        const auto height = parse_number<int>(text.substr(x + 1));
        if (width && height && *width >= 1 && *height >= 1 && *width <= kMaxSide &&
            *height <= kMaxSide) {
            return glm::ivec2{*width, *height};
        }
    }
    return Error{ErrorCode::invalid_argument,
                 fmt::format("--size: '{}' is not a size; write WIDTHxHEIGHT with sides from 1 to "
                             "{}, such as 1280x720",
                             text, kMaxSide)};
}

Result<FrameRange> parse_frame_range(std::string_view text)
{
    const size_t colon = text.find(':');
    if (colon != std::string_view::npos) {
        const auto first = parse_number<size_t>(text.substr(0, colon));
        const auto last = parse_number<size_t>(text.substr(colon + 1));
        if (first && last && *first <= *last) {
            return FrameRange{*first, *last};
        }
    }
    return Error{
        ErrorCode::invalid_argument,
        fmt::format("--frames: '{}' is not a range; write FIRST:LAST, such as 0:99", text)};
}

Result<SetOption> parse_set(std::string_view text)
{
    const size_t equals = text.find('=');
    const size_t dot = text.substr(0, equals).find('.');
    if (equals == std::string_view::npos || dot == std::string_view::npos || dot == 0 ||
        dot + 1 == equals) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--set: '{}' is not a setting; write ALGORITHM.OPTION=VALUE, such "
                                 "as chc.threshold=20, or HIERARCHY.OPTION=VALUE ('occlude list "
                                 "algorithms' and 'list hierarchies' name them)",
                                 text)};
    }
    return SetOption{std::string{text.substr(0, dot)},
                     std::string{text.substr(dot + 1, equals - dot - 1)},
                     std::string{text.substr(equals + 1)}};
}

std::vector<OptionValue> settings_of(std::string_view name, std::span<const std::string> sets)
{
    std::vector<OptionValue> values;
    for (const std::string& text : sets) {
        const auto set = parse_set(text);
        if (set && set->algorithm == name) {
            values.emplace_back(set->option, set->value);
        }
    }
    return values;
}

std::optional<NamedEntry> parse_entry(std::string_view text)
{
    NamedEntry entry{std::string{text.substr(0, text.find(':'))}, {}};
    for (size_t at = entry.name.size(); at < text.size();) {
        const size_t end = std::min(text.find(':', at + 1), text.size());
        const std::string_view part = text.substr(at + 1, end - at - 1);
        const size_t equals = part.find('=');
        if (equals == std::string_view::npos || equals == 0) {
            return std::nullopt;
        }
        entry.options.emplace_back(part.substr(0, equals), part.substr(equals + 1));
        at = end;
    }
    return entry;
}

std::vector<std::string> split_commas(std::string_view text)
{
    std::vector<std::string> parts;
    size_t begin = 0;
    while (begin <= text.size()) {
        const size_t end = std::min(text.find(',', begin), text.size());
        parts.emplace_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

} // namespace occlude::tools
