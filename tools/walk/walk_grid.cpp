#include "walk/walk_grid.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace occlude::tools {
namespace {

constexpr float kFinestCell = 0.25f; // metres
constexpr int kMostCells = 800;      // along the ground
constexpr int kMostLayers = 255;
constexpr float kHeadroom = 1.95f;      // metres
constexpr float kStep = 0.6f;           // metres
constexpr float kShoulder = 0.35f;      // metres
constexpr float kClutterCell = 4.0f;    // metres
constexpr float kInterestReach = 15.0f; // metres

glm::mat3 local_axes(const glm::vec3& up)
{
    const glm::vec3 helper =
        std::abs(up.x) < 0.7f ? glm::vec3{1.0f, 0.0f, 0.0f} : glm::vec3{0.0f, 0.0f, -1.0f};
    const glm::vec3 x = glm::normalize(helper - glm::dot(helper, up) * up);
    return glm::transpose(glm::mat3{x, up, glm::cross(x, up)});
}

/// A convex polygon of at most 7 corners: a triangle cut by four planes.
struct Polygon {
    std::array<glm::vec3, 8> corners;
    int count = 0;
};

/// The part of `polygon` where sign * (p[axis] - at) >= 0.
Polygon clipped(const Polygon& polygon, int axis, float at, float sign)
{
    Polygon out;
    for (int i = 0; i < polygon.count; ++i) {
        const glm::vec3& a = polygon.corners[static_cast<size_t>(i)];
        const glm::vec3& b = polygon.corners[static_cast<size_t>((i + 1) % polygon.count)];
        const float da = sign * (a[axis] - at);
        const float db = sign * (b[axis] - at);
        if (da >= 0.0f && out.count < 8) {
            out.corners[static_cast<size_t>(out.count++)] = a;
        }
        if ((da >= 0.0f) != (db >= 0.0f) && out.count < 8) {
            out.corners[static_cast<size_t>(out.count++)] = a + (b - a) * (da / (da - db));
        }
    }
    return out;
}

} // namespace

SolidGrid::SolidGrid(const SceneModel& model)
    : local_from_world_(local_axes(glm::normalize(model.up)))
{
    const Aabb bounds =
        transformed(glm::mat4{local_from_world_}, world_bounds(model)); // of the scene, local
    const glm::vec3 extent = bounds.extent();
    const float finest = kFinestCell * model.unit;
    cell_ = std::max(finest, std::max(extent.x, extent.z) / static_cast<float>(kMostCells));
    cell_y_ = std::max(0.8f * finest, extent.y / static_cast<float>(kMostLayers));
    origin_ = bounds.min - 0.5f * glm::vec3{cell_, cell_y_, cell_};
    size_x_ = static_cast<int>(extent.x / cell_) + 2;
    size_y_ = static_cast<int>(extent.y / cell_y_) + 2;
    size_z_ = static_cast<int>(extent.z / cell_) + 2;
    words_ = (size_y_ + 63) / 64;
    bits_.assign(static_cast<size_t>(size_x_) * static_cast<size_t>(size_z_) *
                     static_cast<size_t>(words_),
                 0);
    count_items(model);
    std::vector<glm::vec3> cells;
    for (const Instance& instance : model.instances) {
        const Mesh& mesh = model.meshes[instance.mesh];
        cells.clear();
        for (const glm::vec3& position : mesh.positions) {
            cells.push_back(
                to_cells(glm::vec3{instance.world_from_mesh * glm::vec4{position, 1.0f}}));
        }
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            mark(cells[mesh.indices[i]], cells[mesh.indices[i + 1]], cells[mesh.indices[i + 2]]);
        }
    }
}

void SolidGrid::count_items(const SceneModel& model)
{
    const float size = kClutterCell * model.unit;
    clutter_cell_ = {std::max(1, static_cast<int>(size / cell_)),
                     std::max(1, static_cast<int>(size / cell_y_)),
                     std::max(1, static_cast<int>(size / cell_))};
    clutter_size_ = glm::ivec3{size_x_, size_y_, size_z_} / clutter_cell_ + 1;
    items_.assign(static_cast<size_t>(clutter_size_.x) * static_cast<size_t>(clutter_size_.y) *
                      static_cast<size_t>(clutter_size_.z),
                  0);
    for (const Instance& instance : model.instances) {
        for (const MeshPart& part : model.meshes[instance.mesh].parts) {
            const Aabb box = transformed(instance.world_from_mesh, part.box);
            const glm::ivec3 at{to_cells(box.center())};
            ++items_[clutter_cell(at.x, at.y, at.z)];
        }
    }
}

size_t SolidGrid::clutter_cell(int x, int y, int z) const
{
    const glm::ivec3 at =
        glm::clamp(glm::ivec3{x, y, z} / clutter_cell_, glm::ivec3{0}, clutter_size_ - 1);
    return (static_cast<size_t>(at.z) * static_cast<size_t>(clutter_size_.y) +
            static_cast<size_t>(at.y)) *
               static_cast<size_t>(clutter_size_.x) +
           static_cast<size_t>(at.x);
}

float SolidGrid::clutter(int x, int y, int z) const
{
    const auto count = static_cast<float>(items_[clutter_cell(x, y, z)] +
                                          items_[clutter_cell(x, y + clutter_cell_.y, z)]);
    return std::min(1.0f, 0.25f * std::sqrt(count));
}

glm::vec3 SolidGrid::to_cells(const glm::vec3& world) const
{
    return (local_from_world_ * world - origin_) / glm::vec3{cell_, cell_y_, cell_};
}

glm::vec3 SolidGrid::to_world(const glm::vec3& cells) const
{
    return glm::transpose(local_from_world_) * (cells * glm::vec3{cell_, cell_y_, cell_} + origin_);
}

void SolidGrid::mark_range(int x, int z, float low, float high)
{
    const int first = std::clamp(static_cast<int>(low), 0, size_y_ - 1);
    const int last = std::clamp(static_cast<int>(high), 0, size_y_ - 1);
    uint64_t* column =
        &bits_[(static_cast<size_t>(z) * static_cast<size_t>(size_x_) + static_cast<size_t>(x)) *
               static_cast<size_t>(words_)];
    for (int y = first; y <= last; ++y) {
        column[y / 64] |= uint64_t{1} << (y % 64);
    }
}

void SolidGrid::mark(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    const glm::vec3 low = glm::min(a, glm::min(b, c));
    const glm::vec3 high = glm::max(a, glm::max(b, c));
    const auto cell_of = [](float at, int size) {
        return std::clamp(static_cast<int>(at), 0, size - 1);
    };
    const int x_first = cell_of(low.x, size_x_);
    const int x_last = cell_of(high.x, size_x_);
    const int z_first = cell_of(low.z, size_z_);
    const int z_last = cell_of(high.z, size_z_);
    if (x_first == x_last && z_first == z_last) {
        mark_range(x_first, z_first, low.y, high.y);
        return;
    }
    const Polygon triangle{{a, b, c}, 3};
    for (int z = z_first; z <= z_last; ++z) {
        const Polygon above = clipped(triangle, 2, static_cast<float>(z), 1.0f);
        const Polygon row = clipped(above, 2, static_cast<float>(z + 1), -1.0f);
        for (int x = x_first; row.count > 0 && x <= x_last; ++x) {
            const Polygon right = clipped(row, 0, static_cast<float>(x), 1.0f);
            const Polygon piece = clipped(right, 0, static_cast<float>(x + 1), -1.0f);
            if (piece.count == 0) {
                continue;
            }
            float bottom = piece.corners[0].y;
            float top = bottom;
            for (int i = 1; i < piece.count; ++i) {
                bottom = std::min(bottom, piece.corners[static_cast<size_t>(i)].y);
                top = std::max(top, piece.corners[static_cast<size_t>(i)].y);
            }
            mark_range(x, z, bottom, top);
        }
    }
}

bool SolidGrid::solid(int x, int y, int z) const
{
    if (y >= size_y_) {
        return false;
    }
    const size_t column =
        static_cast<size_t>(z) * static_cast<size_t>(size_x_) + static_cast<size_t>(x);
    const uint64_t word = bits_[column * static_cast<size_t>(words_) + static_cast<size_t>(y / 64)];
    return ((word >> (y % 64)) & 1) != 0;
}

bool SolidGrid::any_solid(int x, int z, int y_begin, int y_end) const
{
    for (int y = std::max(y_begin, 0); y < std::min(y_end, size_y_);) {
        const size_t column =
            static_cast<size_t>(z) * static_cast<size_t>(size_x_) + static_cast<size_t>(x);
        const uint64_t word =
            bits_[column * static_cast<size_t>(words_) + static_cast<size_t>(y / 64)] >> (y % 64);
        const int here = std::min(64 - y % 64, std::min(y_end, size_y_) - y);
        const uint64_t mask = here == 64 ? ~uint64_t{0} : (uint64_t{1} << here) - 1;
        if ((word & mask) != 0) {
            return true;
        }
        y += here;
    }
    return false;
}

namespace {

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

void WalkGraph::add_footholds(int x, int z, std::span<const int> floors)
{
    for (int floor : floors) {
        if (!grid_->any_solid(x, z, floor + 1, floor + 1 + head_) && has_room(x, floor + 1, z)) {
            footholds_.push_back({x, floor + 1, z, 0.0f});
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
