#include "options/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

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

static Error bad_option(std::string_view option, std::string_view text, std::string_view what)
{
    return {ErrorCode::invalid_argument, fmt::format("{}: '{}' is not {}", option, text, what)};
}

static Result<glm::dvec3> parse_origin(std::string_view text)
{
    const std::vector<std::string> parts = split_commas(text);
    glm::dvec3 origin{0.0};
    for (size_t axis = 0; axis < 3; ++axis) {
        const auto number = axis < parts.size() ? parse_number<double>(parts[axis]) : std::nullopt;
        if (parts.size() != 3 || !number || !std::isfinite(*number)) {
            return bad_option("--origin", text, "a point; write X,Y,Z, such as 442437,0,4481087");
        }
        origin[static_cast<int>(axis)] = *number;
    }
    return origin;
}

static Result<float> parse_unit(std::string_view text)
{
    constexpr std::pair<std::string_view, float> kNames[] = {
        {"m", 1.0f},      {"metres", 1.0f},         {"cm", 100.0f},   {"centimetres", 100.0f},
        {"mm", 1000.0f},  {"millimetres", 1000.0f}, {"in", 39.3701f}, {"inches", 39.3701f},
        {"ft", 3.28084f}, {"feet", 3.28084f},       {"km", 0.001f},   {"quake", 32.0f}};
    for (const auto& [name, units] : kNames) {
        if (name == text) {
            return units;
        }
    }
    const auto number = parse_number<float>(text);
    if (number && *number >= 1e-12f && *number <= 1e12f) {
        return *number;
    }
    return bad_option("--unit", text,
                      "a unit; write m, cm, mm, in, ft, or how many units make a "
                      "metre");
}

static Result<glm::vec3> parse_up(std::string_view text)
{
    const bool has_sign = !text.empty() && (text[0] == '+' || text[0] == '-');
    const std::string_view axis = text.substr(has_sign ? 1 : 0);
    if (axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z') {
        glm::vec3 up{0.0f};
        up[axis[0] - 'x'] = text[0] == '-' ? -1.0f : 1.0f;
        return up;
    }
    return bad_option("--up", text,
                      "an axis; write x, y or z, with a minus sign if it points down");
}

Result<SceneOptions> parse_file_options(const FileOptions& file, SceneOptions options)
{
    options.load_seconds = file.load_seconds;
    options.load_memory_mib = file.load_memory_mib;
    if (!file.origin.empty()) {
        const auto origin = parse_origin(file.origin);
        if (!origin) {
            return origin.error();
        }
        options.origin = *origin;
    }
    if (!file.unit.empty()) {
        const auto unit = parse_unit(file.unit);
        if (!unit) {
            return unit.error();
        }
        options.units_per_metre = *unit;
    }
    if (!file.up.empty()) {
        const auto up = parse_up(file.up);
        if (!up) {
            return up.error();
        }
        options.up = *up;
    }
    return options;
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
