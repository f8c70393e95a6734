#include "load/assimp_files.h"

#include "load/mapped_file.h"

#include <assimp/MemoryIOWrapper.h>

#include <fmt/format.h>

#include <glm/common.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

namespace occlude::tools {
namespace {

/// Three numbers behind the "v" of a vertex line, and where they end; false if there are not three.
bool read_vertex(std::string_view line, glm::dvec3& out, size_t& end)
{
    size_t at = 1;
    for (int axis = 0; axis < 3; ++axis) {
        while (at < line.size() && (line[at] == ' ' || line[at] == '\t')) {
            ++at;
        }
        const char* begin = line.data() + at + (at < line.size() && line[at] == '+' ? 1 : 0);
        const auto [stop, failed] = std::from_chars(begin, line.data() + line.size(), out[axis]);
        if (failed != std::errc{}) {
            return false;
        }
        at = static_cast<size_t>(stop - line.data());
    }
    end = at;
    return true;
}

/// Calls `visit(line, vertex, rest)` for vertex lines and `other(line)` for all others; lines keep
/// their ends.
template <class Visit, class Other>
void for_each_line(std::string_view text, Visit&& visit, Other&& other)
{
    while (!text.empty()) {
        const size_t stop = text.find('\n');
        const std::string_view line =
            text.substr(0, stop == std::string_view::npos ? stop : stop + 1);
        text.remove_prefix(line.size());
        glm::dvec3 vertex{0.0};
        size_t end = 0;
        const bool is_vertex =
            line.size() > 2 && line[0] == 'v' && (line[1] == ' ' || line[1] == '\t');
        if (is_vertex && read_vertex(line, vertex, end)) {
            visit(vertex, line.substr(end));
        } else {
            other(line);
        }
    }
}

} // namespace

glm::dvec3 far_offset_of_obj(std::string_view text)
{
    constexpr size_t kMostSamples = 1 << 17;
    std::vector<glm::dvec3> samples; // every stride-th vertex
    size_t stride = 1;
    size_t count = 0;
    for_each_line(
        text,
        [&](const glm::dvec3& v, std::string_view) {
            if (!std::isfinite(v.x + v.y + v.z) || count++ % stride != 0) {
                return;
            }
            samples.push_back(v);
            if (samples.size() == kMostSamples) { // every other one of them
                stride *= 2;
                for (size_t i = 0; i < samples.size() / 2; ++i) {
                    samples[i] = samples[2 * i];
                }
                samples.resize(samples.size() / 2);
            }
        },
        [](std::string_view) {});
    if (samples.empty()) {
        return glm::dvec3{0.0};
    }
    // Quartiles: a few vertices elsewhere, such as a marker at the origin, must not decide.
    glm::dvec3 middle{0.0};
    double extent = 0.0;
    double away = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        std::ranges::sort(samples, {}, [axis](const glm::dvec3& v) { return v[axis]; });
        const auto at = [&](size_t quarters) {
            return samples[(samples.size() - 1) * quarters / 4][axis];
        };
        middle[axis] = at(2);
        extent = std::max(extent, 2.0 * (at(3) - at(1)));
        away = std::max(away, std::abs(middle[axis]));
    }
    if (!(extent > 0.0) || away <= kFarRatio * extent) {
        return glm::dvec3{0.0};
    }
    const double step = std::exp2(std::ceil(std::log2(extent)));
    return glm::round(middle / step) * step;
}

std::string moved_obj(std::string_view text, const glm::dvec3& offset)
{
    std::string out;
    out.reserve(text.size() + text.size() / 8);
    for_each_line(
        text,
        [&](const glm::dvec3& v, std::string_view rest) {
            const glm::dvec3 moved = v - offset;
            fmt::format_to(std::back_inserter(out), "v {:.9g} {:.9g} {:.9g}{}", moved.x, moved.y,
                           moved.z, rest);
        },
        [&](std::string_view line) { out += line; });
    return out;
}

std::string utf8_of_utf16(std::string_view text)
{
    const bool little = text.starts_with("\xFF\xFE");
    if ((!little && !text.starts_with("\xFE\xFF")) || text.size() % 2 != 0) {
        return {};
    }
    const auto unit = [&](size_t at) {
        const auto first = static_cast<uint8_t>(text[at]);
        const auto second = static_cast<uint8_t>(text[at + 1]);
        return little ? char32_t{first} | char32_t{second} << 8
                      : char32_t{second} | char32_t{first} << 8;
    };
    const auto is_surrogate = [](char32_t code, char32_t kind) { return (code >> 10) == kind; };
    constexpr char32_t kHigh = 0xD800 >> 10;
    constexpr char32_t kLow = 0xDC00 >> 10;
    std::string out;
    out.reserve(text.size() / 2);
    for (size_t at = 2; at < text.size(); at += 2) {
        char32_t code = unit(at);
        if (is_surrogate(code, kHigh) && at + 2 < text.size() && is_surrogate(unit(at + 2), kLow)) {
            code = 0x10000 + ((code & 0x3ff) << 10 | (unit(at + 2) & 0x3ff));
            at += 2;
        } else if (is_surrogate(code, kHigh) || is_surrogate(code, kLow)) {
            return {};
        }
        const auto more = [&](int bits) { // six bits of a character of several bytes
            out += static_cast<char>(0x80 | (code >> bits & 0x3f));
        };
        if (code < 0x80) {
            out += static_cast<char>(code);
        } else if (code < 0x800) {
            out += static_cast<char>(0xC0 | code >> 6);
            more(0);
        } else if (code < 0x10000) {
            out += static_cast<char>(0xE0 | code >> 12);
            more(6);
            more(0);
        } else {
            out += static_cast<char>(0xF0 | code >> 18);
            more(12);
            more(6);
            more(0);
        }
    }
    return out;
}

std::string AssimpFiles::replaced_text(const std::string& file)
{
    const auto mapped = MappedFile::open(file);
    if (!mapped) {
        return {};
    }
    const auto bytes = mapped->bytes();
    std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    std::string converted = utf8_of_utf16(text);
    text = converted.empty() ? text : std::string_view{converted};
    if (file == scene_ && (file.ends_with(".obj") || file.ends_with(".OBJ"))) {
        offset_ = far_offset_of_obj(text);
        if (offset_ != glm::dvec3{0.0}) {
            return moved_obj(text, offset_);
        }
    }
    return converted;
}

Assimp::IOStream* AssimpFiles::Open(const char* name, const char* mode)
{
    opened_.emplace_back(name);
    if (const std::string text = replaced_text(name); !text.empty()) {
        auto* content = new uint8_t[text.size()]; // the stream owns it
        std::memcpy(content, text.data(), text.size());
        return new Assimp::MemoryIOStream(content, text.size(), true);
    }
    return DefaultIOSystem::Open(name, mode);
}

} // namespace occlude::tools
