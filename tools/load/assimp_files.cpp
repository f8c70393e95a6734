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
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};
    for_each_line(
        text,
        [&](const glm::dvec3& v, std::string_view) {
            if (std::isfinite(v.x + v.y + v.z)) {
                low = glm::min(low, v);
                high = glm::max(high, v);
            }
        },
        [](std::string_view) {});
    if (!(low.x <= high.x)) {
        return glm::dvec3{0.0};
    }
    const glm::dvec3 middle = 0.5 * (low + high);
    const glm::dvec3 extent = high - low;
    const double largest = std::max({extent.x, extent.y, extent.z});
    const double away = std::max({std::abs(middle.x), std::abs(middle.y), std::abs(middle.z)});
    return away > kFarRatio * largest ? glm::round(middle) : glm::dvec3{0.0};
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

Assimp::IOStream* AssimpFiles::Open(const char* name, const char* mode)
{
    opened_.emplace_back(name);
    const std::string_view file = name;
    if (file == scene_ && (file.ends_with(".obj") || file.ends_with(".OBJ"))) {
        const auto mapped = MappedFile::open(scene_);
        const auto bytes = mapped ? mapped->bytes() : std::span<const uint8_t>{};
        const std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
        offset_ = far_offset_of_obj(text);
        if (offset_ != glm::dvec3{0.0}) {
            const std::string moved = moved_obj(text, offset_);
            auto* content = new uint8_t[moved.size()]; // the stream owns it
            std::memcpy(content, moved.data(), moved.size());
            return new Assimp::MemoryIOStream(content, moved.size(), true);
        }
    }
    return DefaultIOSystem::Open(name, mode);
}

} // namespace occlude::tools
