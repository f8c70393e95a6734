// The floors of a scene on a grid of columns: where a person could stand and step.
#pragma once

#include "model/scene_model.h"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace occlude::tools {

/// Space in cells, solid or free. Local axes: x and z along the ground, y up. A cell is solid if a
/// triangle may touch it, so free cells are free.
class SolidGrid {
public:
    /// Cells of a quarter metre, or larger where the scene would need more than 800 along the
    /// ground or 255 in height. O(drawn triangles + cells).
    explicit SolidGrid(const SceneModel& model);

    int size_x() const { return size_x_; }
    int size_y() const { return size_y_; }
    int size_z() const { return size_z_; }
    float cell() const { return cell_; }          ///< along the ground, world units
    float cell_height() const { return cell_y_; } ///< world units
    bool inside(int x, int z) const { return x >= 0 && z >= 0 && x < size_x_ && z < size_z_; }

    /// Cells above the top are free, those below the bottom are not asked for.
    bool solid(int x, int y, int z) const;
    /// True if any cell of [y_begin, y_end) is solid.
    bool any_solid(int x, int z, int y_begin, int y_end) const;
    /// How much there is to see in the cells around: 0 to 1, growing with the objects and triangles
    /// within some metres. Does not depend on how meshes are cut into items.
    float clutter(int x, int y, int z) const;
    bool column_empty(int x, int z) const { return !any_solid(x, z, 0, size_y_); }
    /// How many cells of the column are solid below a free one.
    int floors(int x, int z) const;

    /// From local cell coordinates to the world.
    glm::vec3 to_world(const glm::vec3& cells) const;
    glm::vec3 to_cells(const glm::vec3& world) const;

private:
    void prepare_clutter(float unit);
    void add_clutter(const glm::vec3& cells, uint32_t triangles);
    size_t clutter_cell(int x, int y, int z) const;
    uint32_t clutter_in(int x, int y, int z) const;
    void mark(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);
    void mark_range(int x, int z, float low, float high);

    glm::mat3 local_from_world_{1.0f};
    glm::vec3 origin_{0.0f}; ///< local
    float cell_ = 1.0f;
    float cell_y_ = 1.0f;
    int size_x_ = 1;
    int size_y_ = 1;
    int size_z_ = 1;
    int words_ = 1; ///< per column
    std::vector<uint64_t> bits_;
    glm::ivec3 clutter_cell_{1}; ///< cells per cell of clutter_
    glm::ivec3 clutter_size_{1};
    /// Triangles in coarse cells, and an allowance per object. Sparse: in a scene much larger than
    /// its walkers, coarse cells are as many as cells, and nearly all of them are empty.
    std::unordered_map<size_t, uint32_t> clutter_;
};

/// A place to stand: the free cell above a floor.
struct Foothold {
    int16_t x = 0; // 16 bits: large scenes have a million footholds
    int16_t y = 0;
    int16_t z = 0;
    float interest = 0.0f; ///< 0 (open all round) to 1 (walls near on four sides, much to see)
};

enum class Ground {
    real,       ///< only what the scene has
    made_up_too ///< also a floor in columns without any triangle, at the height of what is near
};

/// Footholds connected by steps.
struct Region {
    std::vector<uint32_t> footholds;
    float score = 0.0f; ///< grows with size and interest
};

/// All footholds with headroom and a little room around, and which can be stepped to from which.
class WalkGraph {
public:
    static constexpr uint32_t kNone = 0xffffffffu;

    /// `grid` outlives the graph. O(cells).
    WalkGraph(const SolidGrid& grid, float unit, Ground ground);

    std::span<const Foothold> footholds() const { return footholds_; }
    /// The foothold in a column within a step of height `y`, or kNone.
    uint32_t find(int x, int y, int z) const;
    /// Where one step leads from `foothold`, in the eight directions; kNone where it does not.
    uint32_t step(uint32_t foothold, int dx, int dz) const;
    /// The region that is largest and most interesting; empty if there is none of some size.
    Region best_region();

private:
    void reserve_footholds(bool makes_ground);
    void add_footholds(int x, int z, std::span<const int> floors);
    bool has_room(int x, int y, int z) const;
    float interest_at(const Foothold& foothold) const;

    const SolidGrid* grid_;
    float unit_;
    int head_;   ///< cells of headroom
    int climb_;  ///< cells of one step up or down
    int radius_; ///< cells of room around
    std::vector<Foothold> footholds_;
    std::vector<uint32_t> column_begin_; ///< into footholds_, by column; one more at the end
};

} // namespace occlude::tools
