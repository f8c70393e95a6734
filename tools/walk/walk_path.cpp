#include "walk/walk_path.h"

#include "model/focus.h"
#include "walk/path_tools.h"
#include "walk/walk_grid.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

namespace occlude::tools {
namespace {

constexpr float kEyeHeight = 1.7f;    // metres
constexpr float kLegLength = 90.0f;   // metres: how far the next waypoint may be
constexpr float kWalkLength = 300.0f; // metres
constexpr float kLeastLength = 10.0f; // metres: less is no walk
constexpr float kLeastArea = 40.0f;   // square metres: less is no floor
constexpr float kRealGround = 1.5f;   // made-up ground must score this much higher
constexpr uint32_t kMostWaypoints = 8;

constexpr std::array<std::array<int, 2>, 8> kDirections{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};

/// Plans over one region of a walk graph. Lengths in cells.
class Planner {
public:
    Planner(const WalkGraph& graph, std::vector<uint32_t> region, float cells_per_metre)
        : graph_(graph)
        , region_(std::move(region))
        , cells_per_metre_(cells_per_metre)
        , wall_distance_(graph.footholds().size(), 0)
        , cost_(graph.footholds().size())
        , came_from_(graph.footholds().size())
    {
        measure_walls();
    }

    /// Footholds of a walk from waypoint to waypoint.
    std::vector<uint32_t> plan();

private:
    const Foothold& at(uint32_t i) const { return graph_.footholds()[i]; }
    void measure_walls();
    uint32_t start() const;
    void explore(uint32_t from, float longest);
    uint32_t next_waypoint(const std::vector<uint32_t>& walk) const;

    const WalkGraph& graph_;
    std::vector<uint32_t> region_;
    float cells_per_metre_;
    std::vector<int> wall_distance_; ///< steps to the edge of the region
    std::vector<float> cost_;
    std::vector<uint32_t> came_from_;
};

void Planner::measure_walls()
{
    std::vector<uint32_t> front;
    for (uint32_t i : region_) {
        for (const auto& [dx, dz] : kDirections) {
            if (graph_.step(i, dx, dz) == WalkGraph::kNone) {
                wall_distance_[i] = 1;
                front.push_back(i);
                break;
            }
        }
    }
    for (size_t i = 0; i < front.size(); ++i) {
        for (const auto& [dx, dz] : kDirections) {
            const uint32_t next = graph_.step(front[i], dx, dz);
            if (next != WalkGraph::kNone && wall_distance_[next] == 0) {
                wall_distance_[next] = wall_distance_[front[i]] + 1;
                front.push_back(next);
            }
        }
    }
}

/// A foothold that is enclosed, has room, and lies near the middle of what is enclosed.
uint32_t Planner::start() const
{
    glm::vec2 sum{0.0f};
    float weight = 0.0f;
    for (uint32_t i : region_) {
        const float w = 0.01f + at(i).interest * at(i).interest;
        sum += w * glm::vec2{at(i).x, at(i).z};
        weight += w;
    }
    const glm::vec2 middle = sum / weight;
    uint32_t best = region_.front();
    float best_score = -std::numeric_limits<float>::max();
    for (uint32_t i : region_) {
        const auto room = static_cast<float>(std::min(wall_distance_[i], 6));
        const float distance = glm::distance(middle, glm::vec2{at(i).x, at(i).z});
        const float score = 60.0f * at(i).interest + room - distance / cells_per_metre_;
        if (score > best_score) {
            best_score = score;
            best = i;
        }
    }
    return best;
}

/// Least costs from `from` as far as `longest`; steps along walls cost more than free ones.
void Planner::explore(uint32_t from, float longest)
{
    std::fill(cost_.begin(), cost_.end(), std::numeric_limits<float>::infinity());
    using Entry = std::pair<float, uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    cost_[from] = 0.0f;
    came_from_[from] = from;
    open.emplace(0.0f, from);
    while (!open.empty()) {
        const auto [cost, i] = open.top();
        open.pop();
        if (cost > cost_[i] || cost > longest) {
            continue;
        }
        for (const auto& [dx, dz] : kDirections) {
            const uint32_t next = graph_.step(i, dx, dz);
            if (next == WalkGraph::kNone) {
                continue;
            }
            const float length = dx != 0 && dz != 0 ? 1.41421356f : 1.0f;
            const float next_cost =
                cost + length * (1.0f + 2.0f / static_cast<float>(wall_distance_[next]));
            if (next_cost < cost_[next]) {
                cost_[next] = next_cost;
                came_from_[next] = i;
                open.emplace(next_cost, next);
            }
        }
    }
}

/// What is reached and lies farthest from the walk so far, enclosed places first.
uint32_t Planner::next_waypoint(const std::vector<uint32_t>& walk) const
{
    const size_t stride = std::max(size_t{1}, walk.size() / 64);
    const size_t candidate_stride = std::max(size_t{1}, region_.size() / 20000);
    uint32_t best = walk.back();
    float best_score = 0.0f;
    for (size_t c = 0; c < region_.size(); c += candidate_stride) {
        const uint32_t candidate = region_[c];
        if (!std::isfinite(cost_[candidate])) {
            continue;
        }
        float nearest = std::numeric_limits<float>::max();
        for (size_t i = 0; i < walk.size(); i += stride) {
            const glm::vec3 apart{at(walk[i]).x - at(candidate).x, at(walk[i]).y - at(candidate).y,
                                  at(walk[i]).z - at(candidate).z};
            nearest = std::min(nearest, glm::dot(apart, apart));
        }
        const float score = std::sqrt(nearest) * (0.2f + at(candidate).interest);
        if (score > best_score) {
            best_score = score;
            best = candidate;
        }
    }
    return best;
}

std::vector<uint32_t> Planner::plan()
{
    std::vector<uint32_t> walk{start()};
    const auto longest = static_cast<size_t>(kWalkLength * cells_per_metre_) + 32;
    for (uint32_t i = 0; i < kMostWaypoints && walk.size() < longest; ++i) {
        explore(walk.back(), std::max(kLegLength * cells_per_metre_, 48.0f));
        const uint32_t goal = next_waypoint(walk);
        if (goal == walk.back()) {
            break;
        }
        std::vector<uint32_t> leg;
        for (uint32_t foothold = goal; foothold != walk.back(); foothold = came_from_[foothold]) {
            leg.push_back(foothold);
        }
        walk.insert(walk.end(), leg.rbegin(), leg.rend());
    }
    return walk;
}

/// Pulls the walk taut without leaving the footholds. Points are in cells, y on the ground.
std::vector<glm::vec3> smoothed(const WalkGraph& graph, const std::vector<uint32_t>& walk)
{
    constexpr int kPasses = 160;
    std::vector<uint32_t> under = walk;
    std::vector<glm::vec3> points;
    for (uint32_t i : walk) {
        const Foothold& foothold = graph.footholds()[i];
        points.emplace_back(static_cast<float>(foothold.x) + 0.5f, static_cast<float>(foothold.y),
                            static_cast<float>(foothold.z) + 0.5f);
    }
    const auto foothold_at = [&](const glm::vec3& p, uint32_t near) {
        return graph.find(static_cast<int>(p.x), graph.footholds()[near].y, static_cast<int>(p.z));
    };
    for (int pass = 0; pass < kPasses; ++pass) {
        for (size_t i = 1; i + 1 < points.size(); ++i) {
            glm::vec3 moved = 0.5f * points[i] + 0.25f * (points[i - 1] + points[i + 1]);
            const uint32_t below = foothold_at(moved, under[i]);
            const bool free =
                below != WalkGraph::kNone &&
                foothold_at(0.5f * (moved + points[i - 1]), below) != WalkGraph::kNone &&
                foothold_at(0.5f * (moved + points[i + 1]), below) != WalkGraph::kNone;
            if (free) {
                moved.y = static_cast<float>(graph.footholds()[below].y);
                points[i] = moved;
                under[i] = below;
            }
        }
    }
    return points;
}

/// Eyes above the points of a walk, without the jerks of single steps.
std::vector<glm::vec3> eyes_above(const std::vector<glm::vec3>& points, const SolidGrid& grid,
                                  float unit)
{
    const float metre = unit / grid.cell_height(); // in cells of height
    std::vector<float> heights;
    for (const glm::vec3& p : points) {
        heights.push_back(p.y + kEyeHeight * metre);
    }
    const auto passes = static_cast<int>(std::min(64.0f, 2.0f * unit / grid.cell())) + 8;
    for (int pass = 0; pass < passes; ++pass) {
        for (size_t i = 1; i + 1 < heights.size(); ++i) {
            const float mean = 0.5f * heights[i] + 0.25f * (heights[i - 1] + heights[i + 1]);
            // The headroom is free; below it the nearest stairs may be.
            heights[i] = std::clamp(mean, points[i].y + 1.3f * metre, points[i].y + 1.85f * metre);
        }
    }
    std::vector<glm::vec3> eyes;
    for (size_t i = 0; i < points.size(); ++i) {
        eyes.push_back(grid.to_world({points[i].x, heights[i], points[i].z}));
    }
    return eyes;
}

float length_of(const std::vector<glm::vec3>& points)
{
    float length = 0.0f;
    for (size_t i = 1; i < points.size(); ++i) {
        length += glm::distance(points[i - 1], points[i]);
    }
    return length;
}

/// Replaces graph and region where ground below what is open to the sky makes a much better walk.
void prefer_made_up_ground(const SolidGrid& grid, float unit, WalkGraph& graph, Region& region)
{
    WalkGraph outdoors(grid, unit, Ground::made_up_too);
    if (outdoors.footholds().size() <= graph.footholds().size()) {
        return;
    }
    Region outside = outdoors.best_region();
    if (outside.score > kRealGround * region.score) {
        graph = std::move(outdoors);
        region = std::move(outside);
    }
}

} // namespace

std::vector<Keyframe> find_walk(const SceneModel& model)
{
    const Aabb bounds = find_focus(model).box;
    const float unit = model.unit;
    if (!bounds.is_bounded() || glm::length(bounds.extent()) < kLeastLength * unit) {
        return {};
    }
    const SolidGrid grid(model);
    WalkGraph graph(grid, unit, Ground::real);
    Region region = graph.best_region();
    prefer_made_up_ground(grid, unit, graph, region);
    const float area = static_cast<float>(region.footholds.size()) * grid.cell() * grid.cell();
    if (area < kLeastArea * unit * unit) {
        return {};
    }
    Planner planner(graph, std::move(region.footholds), unit / grid.cell());
    const std::vector<uint32_t> walk = planner.plan();
    const std::vector<glm::vec3> eyes = eyes_above(smoothed(graph, walk), grid, unit);
    if (length_of(eyes) < kLeastLength * unit) {
        return {};
    }
    const float scale = std::max(unit, 0.5f * grid.cell());
    return walk_along(eyes, {.speed = 1.4f * unit,
                             .look_ahead = 4.0f * scale,
                             .key_distance = 0.5f * scale,
                             .up = model.up});
}

} // namespace occlude::tools
