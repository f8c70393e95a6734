#include "walk/walk_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {
namespace {

constexpr float kHeadroom = 1.95f;      // metres
constexpr float kStep = 0.6f;           // metres
constexpr float kShoulder = 0.35f;      // metres
constexpr float kInterestReach = 15.0f; // metres

/// Heights of made-up ground, by column: in columns with triangles the lowest one's, elsewhere
/// that of the nearest such column, smoothed.
std::vector<float> ground_heights(const SolidGrid& grid)
{
    const int width = grid.size_x();
    const int depth = grid.size_z();
    const auto at = [&](int x, int z) {
        return static_cast<size_t>(z) * static_cast<size_t>(width) + static_cast<size_t>(x);
    };
    std::vector<float> height(static_cast<size_t>(width) * static_cast<size_t>(depth), -1.0f);
    std::vector<std::pair<int, int>> front;
    for (int z = 0; z < depth; ++z) {
        for (int x = 0; x < width; ++x) {
            for (int y = 0; y < grid.size_y() && height[at(x, z)] < 0.0f; ++y) {
                if (grid.solid(x, y, z)) {
                    height[at(x, z)] = static_cast<float>(y);
                    front.emplace_back(x, z);
                }
            }
        }
    }
    std::vector<std::pair<int, int>> empty;
    constexpr std::array<std::pair<int, int>, 4> kSides{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    for (size_t i = 0; i < front.size(); ++i) { // grows while it is walked: breadth first
        const auto [x, z] = front[i];
        for (const auto& [dx, dz] : kSides) {
            if (grid.inside(x + dx, z + dz) && height[at(x + dx, z + dz)] < 0.0f) {
                height[at(x + dx, z + dz)] = height[at(x, z)];
                front.emplace_back(x + dx, z + dz);
                empty.emplace_back(x + dx, z + dz);
            }
        }
    }
    for (int pass = 0; pass < 24; ++pass) {
        for (const auto& [x, z] : empty) {
            float sum = 0.0f;
            float count = 0.0f;
            for (const auto& [dx, dz] : kSides) {
                if (grid.inside(x + dx, z + dz)) {
                    sum += height[at(x + dx, z + dz)];
                    count += 1.0f;
                }
            }
            height[at(x, z)] = sum / count;
        }
    }
    return height;
}

} // namespace

WalkGraph::WalkGraph(const SolidGrid& grid, float unit, Ground ground)
    : grid_(&grid)
    , unit_(unit)
    , head_(static_cast<int>(std::ceil(kHeadroom * unit / grid.cell_height())))
    , climb_(std::max(1, static_cast<int>(std::lround(kStep * unit / grid.cell_height()))))
    , radius_(grid.cell() > kShoulder * unit
                  ? static_cast<int>(grid.cell() < 2.0f * kShoulder * unit)
                  : static_cast<int>(std::ceil(kShoulder * unit / grid.cell())))
{
    const bool makes_ground = ground == Ground::made_up_too;
    const std::vector<float> heights = makes_ground ? ground_heights(grid) : std::vector<float>{};
    reserve_footholds(makes_ground);
    std::vector<int> floors;
    size_t column = 0;
    for (int z = 0; z < grid.size_z(); ++z) {
        for (int x = 0; x < grid.size_x(); ++x, ++column) {
            column_begin_.push_back(static_cast<uint32_t>(footholds_.size()));
            floors.clear();
            if (makes_ground && grid.column_empty(x, z)) {
                floors.push_back(static_cast<int>(heights[column]));
            }
            for (int y = 0; y < grid.size_y(); ++y) {
                if (grid.solid(x, y, z) && !grid.solid(x, y + 1, z)) {
                    floors.push_back(y);
                }
            }
            add_footholds(x, z, floors);
        }
    }
    column_begin_.push_back(static_cast<uint32_t>(footholds_.size()));
}

/// Room for a foothold over each floor. Memory that stays unused costs no page; growing a vector
/// would hold the footholds twice.
void WalkGraph::reserve_footholds(bool makes_ground)
{
    size_t most = 0;
    for (int z = 0; z < grid_->size_z(); ++z) {
        for (int x = 0; x < grid_->size_x(); ++x) {
            const int floors = grid_->floors(x, z);
            most += static_cast<size_t>(makes_ground ? std::max(floors, 1) : floors);
        }
    }
    footholds_.reserve(most);
    column_begin_.reserve(
        static_cast<size_t>(grid_->size_x()) * static_cast<size_t>(grid_->size_z()) + 1);
}

void WalkGraph::add_footholds(int x, int z, std::span<const int> floors)
{
    for (int floor : floors) {
        if (!grid_->any_solid(x, z, floor + 1, floor + 1 + head_) && has_room(x, floor + 1, z)) {
            footholds_.push_back({static_cast<int16_t>(x), static_cast<int16_t>(floor + 1),
                                  static_cast<int16_t>(z), 0.0f});
        }
    }
}

/// No wall within the shoulders; steps that could be climbed do not count.
bool WalkGraph::has_room(int x, int y, int z) const
{
    for (int dz = -radius_; dz <= radius_; ++dz) {
        for (int dx = -radius_; dx <= radius_; ++dx) {
            if (!grid_->inside(x + dx, z + dz) ||
                grid_->any_solid(x + dx, z + dz, y + climb_, y + head_)) {
                return false;
            }
        }
    }
    return true;
}

uint32_t WalkGraph::find(int x, int y, int z) const
{
    if (!grid_->inside(x, z)) {
        return kNone;
    }
    const size_t column =
        static_cast<size_t>(z) * static_cast<size_t>(grid_->size_x()) + static_cast<size_t>(x);
    uint32_t best = kNone;
    int best_distance = climb_ + 1;
    for (uint32_t i = column_begin_[column]; i < column_begin_[column + 1]; ++i) {
        const int distance = std::abs(footholds_[i].y - y);
        if (distance < best_distance) {
            best_distance = distance;
            best = i;
        }
    }
    return best;
}

uint32_t WalkGraph::step(uint32_t foothold, int dx, int dz) const
{
    const Foothold& from = footholds_[foothold];
    const uint32_t to = find(from.x + dx, from.y, from.z + dz);
    if (to == kNone || dx == 0 || dz == 0) {
        return to;
    }
    // No cutting of corners.
    const bool free =
        find(from.x + dx, from.y, from.z) != kNone && find(from.x, from.y, from.z + dz) != kNone;
    return free ? to : kNone;
}

float WalkGraph::interest_at(const Foothold& foothold) const
{
    const int eye = foothold.y + (3 * head_) / 4;
    const auto reach = static_cast<int>(kInterestReach * unit_ / grid_->cell());
    constexpr std::array<std::pair<int, int>, 4> kSides{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    int walls = 0;
    for (const auto& [dx, dz] : kSides) {
        for (int i = 1; i <= std::max(reach, 2); ++i) {
            const int x = foothold.x + i * dx;
            const int z = foothold.z + i * dz;
            if (!grid_->inside(x, z)) {
                break;
            }
            if (grid_->solid(x, eye, z)) {
                ++walls;
                break;
            }
        }
    }
    const float clutter = grid_->clutter(foothold.x, foothold.y, foothold.z);
    return 0.25f * static_cast<float>(walls) * (0.25f + 0.75f * clutter);
}

Region WalkGraph::best_region()
{
    std::vector<bool> seen(footholds_.size(), false);
    Region best;
    for (uint32_t start = 0; start < footholds_.size(); ++start) {
        if (seen[start]) {
            continue;
        }
        std::vector<uint32_t> region{start};
        seen[start] = true;
        for (size_t i = 0; i < region.size(); ++i) { // breadth first
            for (int side = 0; side < 4; ++side) {
                const int dx = side == 0 ? 1 : side == 1 ? -1 : 0;
                const int dz = side == 2 ? 1 : side == 3 ? -1 : 0;
                const uint32_t next = step(region[i], dx, dz);
                if (next != kNone && !seen[next]) {
                    seen[next] = true;
                    region.push_back(next);
                }
            }
        }
        if (region.size() < 16) {
            continue;
        }
        float score = 0.0f;
        for (uint32_t foothold : region) {
            const float interest = interest_at(footholds_[foothold]);
            footholds_[foothold].interest = interest;
            score += 0.02f + interest * interest;
        }
        if (score > best.score) {
            best = {std::move(region), score};
        }
    }
    return best;
}

} // namespace occlude::tools
