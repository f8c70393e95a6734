#include "walk/walk_grid.h"

#include "model/focus.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>

namespace occlude::tools {
namespace {

constexpr float kFinestCell = 0.25f; // metres
constexpr int kMostCells = 800;      // along the ground
constexpr int kMostLayers = 255;
constexpr float kClutterCell = 4.0f; // metres
/// An object counts as this many triangles beside its own.
constexpr uint32_t kTrianglesOfAnObject = 2048;

glm::mat3 local_axes(const glm::vec3& up)
{
    const glm::vec3 helper =
        std::abs(up.x) < 0.7f ? glm::vec3{1.0f, 0.0f, 0.0f} : glm::vec3{0.0f, 0.0f, -1.0f};
    const glm::vec3 x = glm::normalize(helper - glm::dot(helper, up) * up);
    return glm::transpose(glm::mat3{x, up, glm::cross(x, up)});
}

bool overlap(const Aabb& a, const Aabb& b)
{
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
           a.min.z <= b.max.z && b.min.z <= a.max.z;
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

/// The nearest of `size` cells. Clamped first: far away there are more cells than an int counts.
int cell_of(float at, int size)
{
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(size - 1)));
}

} // namespace

SolidGrid::SolidGrid(const SceneModel& model)
    : local_from_world_(local_axes(glm::normalize(model.up)))
{
    const Focus focus = find_focus(model);
    const Aabb bounds = transformed(glm::mat4{local_from_world_}, focus.box); // local
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
    prepare_clutter(model.unit);
    std::vector<glm::vec3> cells;
    for (const Instance& instance : model.instances) {
        const Mesh& mesh = model.meshes[instance.mesh];
        if (focus.left_out > 0 && !overlap(focus.box, world_box(model, instance))) {
            continue; // far away: its cells would be those at the edge
        }
        cells.clear();
        Aabb box;
        for (const glm::vec3& position : mesh.positions) {
            cells.push_back(
                to_cells(glm::vec3{instance.world_from_mesh * glm::vec4{position, 1.0f}}));
            box = merge(box, Aabb{cells.back(), cells.back()});
        }
        add_clutter(box.center(), kTrianglesOfAnObject);
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const glm::vec3& a = cells[mesh.indices[i]];
            const glm::vec3& b = cells[mesh.indices[i + 1]];
            const glm::vec3& c = cells[mesh.indices[i + 2]];
            add_clutter((a + b + c) / 3.0f, 1);
            mark(a, b, c);
        }
    }
}

void SolidGrid::prepare_clutter(float unit)
{
    const float size = kClutterCell * unit;
    clutter_cell_ = {std::max(1, static_cast<int>(size / cell_)),
                     std::max(1, static_cast<int>(size / cell_y_)),
                     std::max(1, static_cast<int>(size / cell_))};
    clutter_size_ = glm::ivec3{size_x_, size_y_, size_z_} / clutter_cell_ + 1;
}

void SolidGrid::add_clutter(const glm::vec3& cells, uint32_t triangles)
{
    const glm::ivec3 at{glm::clamp(cells, glm::vec3{0.0f}, glm::vec3{size_x_, size_y_, size_z_})};
    clutter_[clutter_cell(at.x, at.y, at.z)] += triangles;
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

uint32_t SolidGrid::clutter_in(int x, int y, int z) const
{
    const auto found = clutter_.find(clutter_cell(x, y, z));
    return found != clutter_.end() ? found->second : 0;
}

float SolidGrid::clutter(int x, int y, int z) const
{
    const auto triangles =
        static_cast<float>(clutter_in(x, y, z) + clutter_in(x, y + clutter_cell_.y, z));
    return std::min(1.0f, 0.25f * std::sqrt(triangles / kTrianglesOfAnObject));
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
    const int first = cell_of(low, size_y_);
    const int last = cell_of(high, size_y_);
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

int SolidGrid::floors(int x, int z) const
{
    const uint64_t* column =
        &bits_[(static_cast<size_t>(z) * static_cast<size_t>(size_x_) + static_cast<size_t>(x)) *
               static_cast<size_t>(words_)];
    int count = 0;
    for (int word = 0; word < words_; ++word) {
        const uint64_t from_next = word + 1 < words_ ? column[word + 1] << 63 : 0;
        count += std::popcount(column[word] & ~((column[word] >> 1) | from_next));
    }
    return count;
}

} // namespace occlude::tools
