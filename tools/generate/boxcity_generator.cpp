#include "generate/boxcity_generator.h"

#include "generate/city_paths.h"
#include "model/mesh_tools.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace occlude::tools {
namespace {

constexpr float kBlock = 60.0f; // metres, from facade to facade
constexpr float kStreet = 12.0f;
constexpr float kPitch = kBlock + kStreet;
constexpr float kHouse = 14.0f; // depth of a house, width of a corner house
constexpr float kPavement = 2.0f;
constexpr float kEyeHeight = 1.7f;
constexpr uint32_t kSideHouses = 5; // on each side of a block, its corner among them
constexpr uint32_t kYardHouses = 4;
constexpr uint64_t kBoxesPerBlock = 100;

/// Counts of cells along the three edges of a box.
struct Cells {
    uint64_t x = 1;
    uint64_t y = 1;
    uint64_t z = 1;
    uint64_t triangles() const { return 4 * (x * y + y * z + z * x); }
};

/// The even grid whose triangles are nearest to `triangles`; y, along which boxes are tallest, has
/// the most cells.
Cells cells_for(uint64_t triangles)
{
    const auto off = [&](const Cells& cells) {
        const uint64_t has = cells.triangles();
        return has > triangles ? has - triangles : triangles - has;
    };
    Cells best;
    for (uint64_t x = 1; 12 * x * x <= 2 * triangles; ++x) {
        for (uint64_t z = x; z <= 2 * x; ++z) {
            for (uint64_t y = z; y <= 2 * x; ++y) {
                const Cells cells{x, y, z};
                // Of equals the most even one, which has the larger x.
                if (off(cells) < off(best) || (off(cells) == off(best) && x > best.x)) {
                    best = cells;
                }
            }
        }
    }
    return best;
}

struct PlacedBox {
    glm::vec3 low{0.0f};
    glm::vec3 high{0.0f};
};

class BoxCity {
public:
    BoxCity(const BoxCityOptions& options, SceneModel& model)
        : options_(options)
        , model_(model)
    {
        while ((blocks_ + 1) * (blocks_ + 1) * kBoxesPerBlock <= options.count) {
            ++blocks_;
        }
    }

    void fill()
    {
        const float half = half_size() + 20.0f;
        add({{-half, -1.0f, -half}, {half, 0.0f, half}}, glm::vec3{0.36f, 0.37f, 0.38f}, "ground");
        const uint64_t blocks = blocks_ * blocks_;
        for (uint64_t block = 0; block < blocks; ++block) {
            // The same number for every block, as far as that goes.
            const uint64_t begin = (options_.count - 1) * block / blocks;
            const uint64_t end = (options_.count - 1) * (block + 1) / blocks;
            fill_block(block, end - begin);
        }
    }

    std::vector<SceneModel::NamedPath> paths() const
    {
        const WalkStyle style{.look_ahead = 8.0f};
        const std::vector<Keyframe> street = walk_along(rounded(street_corners(), 4.0f), style);
        return {{"street", street}, {"roofs", rise_from(street.front().camera, 70.0f, 20.0f)}};
    }

private:
    float half_size() const { return 0.5f * kPitch * static_cast<float>(blocks_); }

    /// The middle of the street before block `i`.
    float street_at(uint64_t i) const { return kPitch * static_cast<float>(i) - half_size(); }

    void add(const PlacedBox& box, const glm::vec3& color, const char* name)
    {
        glm::mat4 world_from_mesh{1.0f};
        for (int axis = 0; axis < 3; ++axis) {
            world_from_mesh[axis][axis] = box.high[axis] - box.low[axis];
        }
        const glm::vec3 middle = 0.5f * (box.low + box.high);
        world_from_mesh[3] = {middle.x, box.low.y, middle.z, 1.0f};
        model_.instances.push_back({name, 0, world_from_mesh, color});
    }

    void fill_block(uint64_t block, uint64_t count)
    {
        Rng rng(hash64(options_.seed, block, 11));
        const glm::vec2 center{street_at(block % blocks_) + 0.5f * kPitch,
                               street_at(block / blocks_) + 0.5f * kPitch};
        std::vector<PlacedBox> houses;
        for (uint32_t side = 0; side < 4; ++side) {
            add_side(center, side, houses, rng);
        }
        for (uint32_t i = 0; i < kYardHouses; ++i) {
            add_yard_house(center, i, houses, rng);
        }
        for (const PlacedBox& house : houses) {
            add(house, house_color(rng), "house");
        }
        for (uint64_t i = houses.size(); i < count; ++i) {
            add_small_box(center, houses, i, rng);
        }
    }

    /// Houses along one side of a block, from its left corner to the next side's corner house.
    static void add_side(glm::vec2 center, uint32_t side, std::vector<PlacedBox>& houses, Rng& rng)
    {
        constexpr float kHalf = 0.5f * kBlock;
        const float width = (kBlock - 2.0f * kHouse) / static_cast<float>(kSideHouses - 1);
        float x = -kHalf;
        for (uint32_t i = 0; i < kSideHouses; ++i) {
            const float wide = i == 0 ? kHouse : width;
            const float setback = rng.range(0.0f, 0.6f); // no two facades in one plane
            const float height = rng.range(12.0f, 26.0f) + (rng.below(12) == 0 ? 14.0f : 0.0f);
            const glm::vec2 low{x, kHalf - kHouse};
            const glm::vec2 high{x + wide + 0.01f, kHalf - setback};
            houses.push_back(turned(center, side, low, high, 0.0f, height));
            x += wide;
        }
    }

    static void add_yard_house(glm::vec2 center, uint32_t which, std::vector<PlacedBox>& houses,
                               Rng& rng)
    {
        const glm::vec2 at{which % 2 == 0 ? -7.5f : 7.5f, which / 2 == 0 ? -7.5f : 7.5f};
        const glm::vec2 half{rng.range(3.0f, 6.0f), rng.range(3.0f, 6.0f)};
        houses.push_back(turned(center, 0, at - half, at + half, 0.0f, rng.range(3.0f, 11.0f)));
    }

    /// On a roof, on the pavement, or in the yard.
    void add_small_box(glm::vec2 center, const std::vector<PlacedBox>& houses, uint64_t index,
                       Rng& rng)
    {
        const float size = rng.range(0.4f, 2.4f);
        const float width = size * rng.range(0.6f, 1.4f);
        const float height = size * rng.range(0.5f, 1.5f);
        const glm::vec3 color{rng.range(0.25f, 0.8f), rng.range(0.25f, 0.75f),
                              rng.range(0.25f, 0.7f)};
        const uint64_t kind = index % 20;
        if (kind < 11) {
            const PlacedBox& house = houses[rng.below(static_cast<uint32_t>(houses.size()))];
            const float x = rng.range(house.low.x + 2.0f, house.high.x - 2.0f);
            const float z = rng.range(house.low.z + 2.0f, house.high.z - 2.0f);
            const float roof = house.high.y;
            add({{x - 0.5f * width, roof, z - 0.5f * size},
                 {x + 0.5f * width, roof + height, z + 0.5f * size}},
                color, "box on a roof");
        } else if (kind < 14) {
            // Wholly on the pavement, its back in the wall.
            const float deep = std::min(0.6f * size, kPavement - 0.3f);
            const float x = rng.range(-0.5f * kBlock + 1.0f, 0.5f * kBlock - 1.0f);
            const glm::vec2 low{x - 0.5f * width, 0.5f * kBlock - 0.7f};
            const glm::vec2 high{x + 0.5f * width, 0.5f * kBlock + deep};
            add(turned(center, rng.below(4), low, high, 0.0f, height), color, "box in a street");
        } else {
            const glm::vec2 at{rng.range(-14.0f, 14.0f), rng.range(-14.0f, 14.0f)};
            const glm::vec2 half{0.5f * width, 0.5f * size};
            add(turned(center, 0, at - half, at + half, 0.0f, height), color, "box in a yard");
        }
    }

    /// A box given for the side of a block that looks along +z, turned by quarter turns.
    static PlacedBox turned(glm::vec2 center, uint32_t side, glm::vec2 low, glm::vec2 high,
                            float from_y, float to_y)
    {
        for (uint32_t i = 0; i < side; ++i) {
            const glm::vec2 old_low = low;
            low = {old_low.y, -high.x};
            high = {high.y, -old_low.x};
        }
        low += center;
        high += center;
        return {{low.x, from_y, low.y}, {high.x, to_y, high.y}};
    }

    static glm::vec3 house_color(Rng& rng)
    {
        constexpr std::array<glm::vec3, 6> kColors{{{0.72f, 0.62f, 0.48f},
                                                    {0.66f, 0.44f, 0.34f},
                                                    {0.75f, 0.70f, 0.62f},
                                                    {0.55f, 0.56f, 0.60f},
                                                    {0.78f, 0.68f, 0.42f},
                                                    {0.50f, 0.58f, 0.52f}}};
        const float light = rng.range(0.85f, 1.15f);
        return light * kColors[rng.below(static_cast<uint32_t>(kColors.size()))];
    }

    /// From near one edge towards the other, a block to the left or right at every other crossing.
    std::vector<glm::vec3> street_corners() const
    {
        const auto at = [&](uint64_t column, uint64_t row) {
            return glm::vec3{street_at(column), kEyeHeight, street_at(row)};
        };
        uint64_t column = blocks_ / 5;
        uint64_t row = blocks_ / 2;
        std::vector<glm::vec3> corners{at(column, row) - glm::vec3{25.0f, 0.0f, 0.0f}};
        while (column < blocks_) {
            corners.push_back(at(column, row));
            row = row == blocks_ / 2 ? row + 1 : row - 1;
            corners.push_back(at(column, row));
            ++column;
        }
        corners.push_back(at(column, row));
        return corners;
    }

    const BoxCityOptions& options_;
    SceneModel& model_;
    uint64_t blocks_ = 1; ///< per side
};

} // namespace

Mesh make_subdivided_box(uint64_t triangles, uint32_t item_triangles)
{
    const Cells cells = cells_for(triangles);
    const std::array<uint64_t, 3> counts{cells.x, cells.y, cells.z};
    MeshBuilder builder;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        for (const float side : {-0.5f, 0.5f}) {
            const auto at = [&](uint64_t i, uint64_t j) {
                glm::vec3 point;
                point[axis] = side;
                point[u] = static_cast<float>(i) / static_cast<float>(counts[u]) - 0.5f;
                point[v] = static_cast<float>(j) / static_cast<float>(counts[v]) - 0.5f;
                point.y += 0.5f;
                return point;
            };
            for (uint64_t i = 0; i < counts[u]; ++i) {
                for (uint64_t j = 0; j < counts[v]; ++j) {
                    if (side > 0.0f) {
                        builder.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                    } else {
                        builder.quad(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
                    }
                }
            }
        }
    }
    Mesh mesh = builder.take("box", item_triangles);
    weld(mesh);
    return mesh;
}

SceneModel generate_boxcity(const BoxCityOptions& options, const SceneOptions& scene_options)
{
    SceneModel model;
    model.name = fmt::format("boxcity:count={},triangles={},seed={}", options.count,
                             options.triangles, options.seed);
    model.meshes.push_back(
        make_subdivided_box(options.triangles, std::max(scene_options.item_triangles, 1u)));
    model.instances.reserve(options.count);
    BoxCity city(options, model);
    city.fill();
    model.paths = city.paths();
    return model;
}

} // namespace occlude::tools
