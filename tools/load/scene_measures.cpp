#include "load/scene_measures.h"

#include "model/focus.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <ranges>
#include <span>
#include <string_view>
#include <vector>

namespace occlude::tools {
namespace {

struct KnownUnit {
    float per_metre;
    const char* name;
};
constexpr std::array kKnownUnits = {
    KnownUnit{1.0f, "metres"},        KnownUnit{3.28084f, "feet"},
    KnownUnit{32.0f, "32 a metre"},   KnownUnit{39.3701f, "inches"},
    KnownUnit{100.0f, "centimetres"}, KnownUnit{1000.0f, "millimetres"},
};

/// The usual unit nearest to a number, by ratio; beyond all of them the nearest power of two.
UnitGuess nearest_known(float per_metre, const std::string& because)
{
    constexpr float kBeyond = 16.0f; // times the largest unit
    if (per_metre > kBeyond * kKnownUnits.back().per_metre) {
        const float power = std::exp2(std::round(std::log2(per_metre)));
        return {power, fmt::format("guessed {:g} units a metre: {}", power, because)};
    }
    const auto ratio = [per_metre](const KnownUnit& unit) {
        return std::abs(std::log2(unit.per_metre / per_metre));
    };
    const auto best = std::min_element(
        kKnownUnits.begin(), kKnownUnits.end(),
        [&](const KnownUnit& a, const KnownUnit& b) { return ratio(a) < ratio(b); });
    return {best->per_metre, fmt::format("guessed {}: {}", best->name, because)};
}

struct Triangle {
    glm::vec3 corners[3];
};

/// Calls `visit` for about 100,000 triangles of the scene, evenly chosen.
template <class Visit>
void sample_triangles(const SceneModel& model, Visit&& visit)
{
    constexpr uint64_t kSamples = 100000;
    const uint64_t stride = drawn_triangles(model) / kSamples + 1;
    uint64_t triangle = 0;
    for (const Instance& instance : model.instances) {
        const Mesh& mesh = model.meshes[instance.mesh];
        const uint64_t count = mesh.indices.size() / 3;
        for (uint64_t i = (stride - triangle % stride) % stride; i < count; i += stride) {
            Triangle sample;
            for (uint64_t k = 0; k < 3; ++k) {
                const glm::vec3& p = mesh.positions[mesh.indices[3 * i + k]];
                sample.corners[k] = glm::vec3{instance.world_from_mesh * glm::vec4{p, 1.0f}};
            }
            visit(sample);
        }
        triangle += count;
    }
}

bool names_a_door(const std::string& name)
{
    std::string lower = name;
    for (char& c : lower) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    const size_t at = lower.find("door");
    const bool longer_word = at != std::string::npos && at > 0 && lower[at - 1] >= 'a' &&
                             lower[at - 1] <= 'z'; // outdoor, indoor
    return at != std::string::npos && !longer_word;
}

/// The median height of what is called a door; nothing without any.
std::optional<float> door_height(const SceneModel& model)
{
    std::vector<float> heights;
    for (const Instance& instance : model.instances) {
        if (!names_a_door(instance.name) && !names_a_door(model.meshes[instance.mesh].name)) {
            continue;
        }
        heights.push_back(glm::dot(world_box(model, instance).extent(), glm::abs(model.up)));
    }
    if (heights.empty()) {
        return std::nullopt;
    }
    std::sort(heights.begin(), heights.end());
    const float median = heights[heights.size() / 2];
    return median > 0.0f ? std::optional{median} : std::nullopt;
}

/// A height at which a scene has level surface.
struct Level {
    float height = 0.0f;
    double area = 0.0;
};

/// Joins levels that lie within `distance` of the first of their group, at its height.
std::vector<Level> joined(std::span<const Level> ascending, float distance)
{
    std::vector<Level> groups;
    for (const Level& level : ascending) {
        if (groups.empty() || level.height - groups.back().height > distance) {
            groups.push_back(level);
        } else {
            groups.back().area += level.area;
        }
    }
    return groups;
}

} // namespace

std::optional<float> storey_height(const SceneModel& model)
{
    constexpr float kLevel = 0.98f;       // cosine
    constexpr float kSameHeight = 0.005f; // share of the scene's height
    constexpr double kLargeLevel = 0.25;  // share of the largest level's area
    constexpr float kSameStorey = 0.4f;   // share of the largest gap: floor and ceiling of a slab
    constexpr float kEven = 0.15f;        // how far a gap may be from the middle one
    constexpr size_t kLeastLevels = 4;
    std::vector<Level> levels;
    sample_triangles(model, [&](const Triangle& t) {
        const glm::vec3 area = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
        if (std::abs(glm::dot(area, model.up)) > kLevel * glm::length(area)) {
            const glm::vec3 middle = (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0f;
            levels.push_back({glm::dot(middle, model.up), glm::length(area)});
        }
    });
    if (levels.empty()) {
        return std::nullopt;
    }
    std::ranges::sort(levels, {}, &Level::height);
    levels = joined(levels, kSameHeight * (levels.back().height - levels.front().height));
    const double largest = std::ranges::max_element(levels, {}, &Level::area)->area;
    std::erase_if(levels, [&](const Level& level) { return level.area < kLargeLevel * largest; });
    const auto gap = [&](size_t i) { return levels[i + 1].height - levels[i].height; };
    float largest_gap = 0.0f;
    for (size_t i = 0; i + 1 < levels.size(); ++i) {
        largest_gap = std::max(largest_gap, gap(i));
    }
    levels = joined(levels, kSameStorey * largest_gap);
    if (levels.size() < kLeastLevels) {
        return std::nullopt;
    }
    std::vector<float> gaps;
    for (size_t i = 0; i + 1 < levels.size(); ++i) {
        gaps.push_back(gap(i));
    }
    std::ranges::sort(gaps);
    const float median = gaps[gaps.size() / 2];
    const bool even =
        gaps.front() > (1.0f - kEven) * median && gaps.back() < (1.0f + kEven) * median;
    return even && median > 0.0f ? std::optional{median} : std::nullopt;
}

UnitGuess guess_unit(const SceneModel& model, UnitSource source)
{
    // A metre is not believed where ...
    constexpr float kLargestScene = 20000.0f; // ... a scene would be longer than this,
    constexpr float kLongShortEdge = 20.0f;   // ... or nine edges of ten were longer than this.
    constexpr float kLargeUnsaid = 1000.0f;   // Where nobody said metres, less is suspicious:
    constexpr float kLongEdge = 8.0f;         // a large scene with a long median edge.
    constexpr float kTypicalEdge = 2.0f;      // metres
    constexpr float kDoorHeight = 2.05f;      // metres
    constexpr float kLeastDoor = 1.0f;        // metres: lower and ...
    constexpr float kMostDoor = 6.0f;         // ... higher ones than these speak of another unit.
    constexpr float kStoreyHeight = 3.0f;     // metres
    constexpr float kMostStorey = 7.0f;       // metres: halls have higher ones, so a file that ...
    constexpr float kMostStoreySaid = 20.0f;  // ... says metres is believed up to here.

    if (const auto door = door_height(model)) {
        const std::string why = fmt::format("its doors are {:.3g} units high", *door);
        return *door < kLeastDoor || *door > kMostDoor ? nearest_known(*door / kDoorHeight, why)
                                                       : UnitGuess{1.0f, "metres: " + why};
    }
    const float most_storey = source == UnitSource::metres ? kMostStoreySaid : kMostStorey;
    if (const auto storey = storey_height(model); storey && *storey > most_storey) {
        return nearest_known(*storey / kStoreyHeight,
                             fmt::format("its storeys are {:.3g} units high", *storey));
    }
    std::vector<float> edges;
    sample_triangles(model, [&](const Triangle& t) {
        edges.push_back(std::max({glm::distance(t.corners[0], t.corners[1]),
                                  glm::distance(t.corners[1], t.corners[2]),
                                  glm::distance(t.corners[2], t.corners[0])}));
    });
    if (edges.empty()) {
        return {1.0f, "metres"};
    }
    std::sort(edges.begin(), edges.end());
    const float short_edge = edges[edges.size() / 10];
    const float median = edges[edges.size() / 2];
    const float size = glm::length(find_focus(model).box.extent());
    const bool absurd = size > kLargestScene || short_edge > kLongShortEdge;
    const bool suspicious =
        source == UnitSource::unknown && size > kLargeUnsaid && median > kLongEdge;
    if (absurd || suspicious) {
        return nearest_known(median / kTypicalEdge,
                             fmt::format("it is {:.3g} units large, half of its triangles larger "
                                         "than {:.3g}",
                                         size, median));
    }
    return {1.0f, source == UnitSource::metres ? "metres, by its format" : "metres, assumed"};
}

glm::vec3 guess_up(const SceneModel& model)
{
    constexpr uint64_t kFewTriangles = 50; // say nothing about a ground
    constexpr float kLevel = 0.98f;        // cosine
    constexpr float kBottom = 0.2f;        // share of the height
    constexpr float kClear = 2.0f;         // how much more level surface z must have
    const glm::vec3 y_up{0.0f, 1.0f, 0.0f};
    if (drawn_triangles(model) < kFewTriangles) {
        return y_up;
    }
    const Aabb box = find_focus(model).box;
    const glm::vec3 low_enough = box.min + kBottom * box.extent();
    double level_y = 0.0;
    double level_z = 0.0;
    sample_triangles(model, [&](const Triangle& t) {
        const glm::vec3 area = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
        const float length = glm::length(area);
        const glm::vec3 middle = (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0f;
        if (!(length > 0.0f)) {
            return;
        }
        level_y += std::abs(area.y) > kLevel * length && middle.y <= low_enough.y ? length : 0.0f;
        level_z += std::abs(area.z) > kLevel * length && middle.z <= low_enough.z ? length : 0.0f;
    });
    return level_z > double{kClear} * level_y ? glm::vec3{0.0f, 0.0f, 1.0f} : y_up;
}

} // namespace occlude::tools
