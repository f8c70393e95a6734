#include "generate/vienna_generator.h"

#include "generate/city_buildings.h"
#include "generate/city_furniture.h"
#include "generate/city_paths.h"
#include "generate/shapes.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace occlude::tools {
namespace {

constexpr float kPitch = 50.0f; // metres from crossing to crossing, before they are moved
constexpr float kShift = 6.5f;  // at most, along each axis
constexpr float kHalfStreet = 4.5f;
constexpr float kWidth = 12.0f; // of a house; stretched to fill its side of the block
constexpr float kDepth = 11.0f;
constexpr float kEyeHeight = 1.7f;
constexpr uint32_t kHouses = 24;
constexpr uint32_t kTrees = 4;
constexpr uint32_t kLamps = 2;

/// Three dormers for the front slope of a roof that rises 3 on 4 from y = 0 at z = 0.
Mesh make_dormers(uint32_t item_triangles)
{
    constexpr float kHalf = 0.6f;
    constexpr float kFront = -0.9f;
    constexpr float kEaves = 1.9f; // above the house's own
    constexpr float kRidge = 2.4f;
    MeshBuilder builder;
    for (const float x : {-3.6f, 0.0f, 3.6f}) {
        const float foot = -0.75f * kFront - 0.1f;
        const float back_eaves = -kEaves / 0.75f; // where they meet the slope
        const float back_ridge = -kRidge / 0.75f;
        const glm::vec3 a{x - kHalf, foot, kFront};
        const glm::vec3 b{x + kHalf, foot, kFront};
        const glm::vec3 c{x + kHalf, kEaves, kFront};
        const glm::vec3 d{x - kHalf, kEaves, kFront};
        const glm::vec3 top{x, kRidge, kFront};
        builder.quad(a, b, c, d);
        builder.triangle(d, c, top);
        builder.triangle(b, {x + kHalf, kEaves, back_eaves}, c);
        builder.triangle(a, d, {x - kHalf, kEaves, back_eaves});
        const glm::vec3 ridge_end{x, kRidge, back_ridge};
        builder.quad(c, {x + kHalf, kEaves, back_eaves}, ridge_end, top);
        builder.quad(d, top, ridge_end, {x - kHalf, kEaves, back_eaves});
        builder.box({x - 0.4f, foot + 0.3f, kFront}, {x + 0.4f, kEaves - 0.15f, kFront + 0.03f},
                    MeshBuilder::kAllFaces & ~MeshBuilder::kNegZ);
    }
    return builder.take("dormers", item_triangles);
}

class Vienna {
public:
    Vienna(const ViennaOptions& options, uint32_t item_triangles)
        : options_(options)
        , item_triangles_(item_triangles)
        , blocks_(static_cast<uint32_t>(options.blocks))
    {
        plan_houses();
    }

    Result<SceneModel> generate()
    {
        for (uint32_t row = 0; row < blocks_; ++row) {
            for (uint32_t column = 0; column < blocks_; ++column) {
                build_block(row, column);
            }
        }
        model_.name = fmt::format("vienna:blocks={},triangles={},seed={}", options_.blocks,
                                  options_.triangles, options_.seed);
        if (auto problem = make_meshes()) {
            return *problem;
        }
        add_ground();
        add_paths();
        return std::move(model_);
    }

private:
    // Meshes: the houses, then their dormers, then trees, then lamps.
    static constexpr uint32_t kDormers = kHouses;
    static constexpr uint32_t kFirstTree = kHouses + 1;
    static constexpr uint32_t kFirstLamp = kFirstTree + kTrees;
    static constexpr uint32_t kMeshes = kFirstLamp + kLamps;

    float half_size() const { return 0.5f * kPitch * static_cast<float>(blocks_); }

    glm::vec2 crossing(uint32_t column, uint32_t row) const
    {
        const uint64_t hash = hash64(options_.seed, column, row, 91);
        const float x = 2.0f * uniform01(hash) - 1.0f;
        const float z = 2.0f * uniform01(mix64(hash)) - 1.0f;
        return {kPitch * static_cast<float>(column) - half_size() + kShift * x,
                kPitch * static_cast<float>(row) - half_size() + kShift * z};
    }

    void plan_houses()
    {
        Rng rng(hash64(options_.seed, 93));
        for (uint32_t i = 0; i < kHouses; ++i) {
            HousePlan plan;
            plan.width = kWidth;
            plan.depth = kDepth;
            const uint32_t more = rng.below(2);
            plan.floors = 4 + (i + more) % 3;
            plan.pitched_roof = i % 8 != 7;
            plan.wing = i % 3 == 1 ? 4.5f : 0.0f;
            plan.seed = rng.next();
            plans_.push_back(plan);
        }
    }

    void add(uint32_t mesh, const glm::mat4& world, const glm::vec3& color, const char* name)
    {
        ++uses_[mesh];
        model_.instances.push_back({name, mesh, world, color});
    }

    /// The corners of a block, counter-clockwise seen from above: the crossings around it, moved
    /// inward by half a street.
    std::array<glm::vec2, 4> corners_of(uint32_t row, uint32_t column) const
    {
        const std::array<glm::vec2, 4> outer{crossing(column, row + 1),
                                             crossing(column + 1, row + 1),
                                             crossing(column + 1, row), crossing(column, row)};
        std::array<glm::vec2, 4> inner;
        for (size_t i = 0; i < 4; ++i) {
            const glm::vec2 in = glm::normalize(outer[i] - outer[(i + 3) % 4]);
            const glm::vec2 out = glm::normalize(outer[(i + 1) % 4] - outer[i]);
            const glm::vec2 left_of_in{in.y, -in.x};
            const glm::vec2 left_of_out{out.y, -out.x};
            // Where the two streets' edges meet.
            const glm::vec2 sum = left_of_in + left_of_out;
            inner[i] = outer[i] + sum * (2.0f * kHalfStreet / glm::dot(sum, sum));
        }
        return inner;
    }

    void build_block(uint32_t row, uint32_t column)
    {
        const std::array<glm::vec2, 4> corners = corners_of(row, column);
        const uint64_t seed = hash64(options_.seed, row, column, 97);
        glm::vec2 middle{0.0f};
        for (size_t side = 0; side < 4; ++side) {
            build_side(corners, side, hash64(seed, side));
            middle += 0.25f * corners[side];
        }
        Rng rng(hash64(seed, 4));
        for (uint32_t i = 0; i < 3; ++i) {
            const float x = middle.x + rng.range(-4.0f, 4.0f);
            const glm::vec3 at{x, 0.0f, middle.y + rng.range(-4.0f, 4.0f)};
            add(kFirstTree + rng.below(kTrees), quarter_turned(rng.below(4), at),
                {0.22f, 0.42f, 0.16f}, "tree");
        }
    }

    /// How far from a sharp corner the houses must end so as not to stand out into the other
    /// street.
    static float trim(const glm::vec2& along, const glm::vec2& other)
    {
        const float cosine = glm::dot(along, other); // of the block's angle there
        return cosine <= 0.0f ? 0.0f : kDepth * cosine / std::sqrt(1.0f - cosine * cosine);
    }

    void build_side(const std::array<glm::vec2, 4>& corners, size_t side, uint64_t seed)
    {
        const glm::vec2& from = corners[side];
        const glm::vec2& to = corners[(side + 1) % 4];
        const glm::vec2 along = glm::normalize(to - from);
        const float begin = trim(along, glm::normalize(corners[(side + 3) % 4] - from));
        const float end = trim(-along, glm::normalize(corners[(side + 2) % 4] - to));
        const float length = glm::distance(from, to) - begin - end;
        const auto count = std::max(1u, static_cast<uint32_t>(length / kWidth + 0.5f));
        const float width = length / static_cast<float>(count);
        // The front looks to the right of the way along the side: +z of the house.
        const glm::vec2 out{-along.y, along.x};
        for (uint32_t i = 0; i < count; ++i) {
            const uint64_t hash = hash64(seed, i);
            const uint32_t house = uniform_below(hash, kHouses);
            const float setback = 0.05f * static_cast<float>(i % 3);
            const glm::vec2 at =
                from + (begin + width * (static_cast<float>(i) + 0.5f)) * along - setback * out;
            glm::mat4 world = turned_about_y(out.x, out.y, {at.x, 0.0f, at.y});
            world[0] *= (width + 0.02f) / kWidth;
            add(house, world, house_color(hash), "house");
            if (plans_[house].pitched_roof) {
                world[3].y = house_height(plans_[house]);
                add(kDormers, world, {0.45f, 0.30f, 0.24f}, "dormers");
            }
            if (i % 2 == 0) {
                const glm::vec2 lamp = at + 0.6f * out;
                add(kFirstLamp + uniform_below(mix64(hash), kLamps),
                    turned_about_y(out.x, out.y, {lamp.x, 0.0f, lamp.y}), {0.2f, 0.22f, 0.22f},
                    "lamp");
            }
        }
    }

    static glm::vec3 house_color(uint64_t hash)
    {
        constexpr std::array<glm::vec3, 6> kColors{{{0.80f, 0.72f, 0.50f},
                                                    {0.74f, 0.66f, 0.58f},
                                                    {0.70f, 0.62f, 0.40f},
                                                    {0.78f, 0.74f, 0.68f},
                                                    {0.66f, 0.50f, 0.42f},
                                                    {0.60f, 0.64f, 0.58f}}};
        return (0.85f + 0.25f * uniform01(mix64(hash))) * kColors[uniform_below(hash, 6)];
    }

    /// A fifth on trees and lamps as far as they can use it, the rest on the houses.
    std::optional<Error> make_meshes()
    {
        constexpr uint32_t kWhole = 0xffffffffu;
        const auto total = static_cast<double>(options_.triangles);
        double used = 0.0;
        double area = 0.0;
        double furniture = 0.0;
        for (uint32_t i = 0; i < kMeshes; ++i) {
            const auto uses = static_cast<double>(uses_[i]);
            (i < kHouses ? area : furniture) +=
                i < kHouses ? uses * double{facade_area(plans_[i])} : uses;
        }
        model_.meshes.resize(kMeshes);
        const auto pay = [&](uint32_t i, Mesh mesh) {
            used += static_cast<double>(uses_[i]) * static_cast<double>(mesh.indices.size() / 3);
            model_.meshes[i] = std::move(mesh);
        };
        pay(kDormers, make_dormers(kWhole));
        for (uint32_t i = kFirstTree; i < kMeshes; ++i) {
            const Furniture kind = i < kFirstLamp ? Furniture::tree : Furniture::lamp;
            const auto share = static_cast<size_t>(0.2 * total / furniture);
            pay(i, make_furniture(kind, hash64(options_.seed, i, 99),
                                  std::min(share, furniture_limit(kind)), kWhole));
        }
        const double per_area = std::max(total - used, 0.0) / area;
        for (uint32_t i = 0; i < kHouses; ++i) {
            const auto budget = static_cast<size_t>(per_area * double{facade_area(plans_[i])});
            pay(i, make_house(plans_[i], budget, fmt::format("house {}", i), kWhole));
        }
        if (std::abs(used - total) > 0.1 * total) {
            return Error{
                ErrorCode::invalid_argument,
                fmt::format("{} triangles do not suit {} x {} blocks, which can have about "
                            "{:.0f} at {}; change triangles= or blocks=",
                            options_.triangles, blocks_, blocks_, used,
                            used > total ? "least" : "most")};
        }
        drop_unused();
        for (Mesh& mesh : model_.meshes) {
            partition_mesh(mesh, item_triangles_);
        }
        return std::nullopt;
    }

    void drop_unused()
    {
        std::array<uint32_t, kMeshes> renumbered{};
        std::vector<Mesh> kept;
        for (uint32_t i = 0; i < kMeshes; ++i) {
            renumbered[i] = static_cast<uint32_t>(kept.size());
            if (uses_[i] > 0) {
                kept.push_back(std::move(model_.meshes[i]));
            }
        }
        model_.meshes = std::move(kept);
        for (Instance& instance : model_.instances) {
            instance.mesh = renumbered[instance.mesh];
        }
    }

    void add_ground()
    {
        const float half = half_size() + 20.0f;
        MeshBuilder builder;
        builder.box({-half, -0.5f, -half}, {half, -0.02f, half});
        model_.instances.push_back({"ground", static_cast<uint32_t>(model_.meshes.size()),
                                    glm::mat4{1.0f}, glm::vec3{0.42f, 0.41f, 0.40f}});
        model_.meshes.push_back(builder.take("ground", item_triangles_));
    }

    /// From crossing to crossing, turning at every other one, from a quarter of the town onward.
    void add_paths()
    {
        const auto at = [&](uint32_t column, uint32_t row) {
            const glm::vec2 point = crossing(column, row);
            return glm::vec3{point.x, kEyeHeight, point.y};
        };
        uint32_t column = blocks_ / 4;
        uint32_t row = blocks_ / 2;
        const uint32_t home = row;
        std::vector<glm::vec3> corners{0.5f * (at(column, row) + at(column + 1, row))};
        while (++column < blocks_) {
            corners.push_back(at(column, row));
            row = row == home ? row + 1 : home;
            corners.push_back(at(column, row));
        }
        corners.push_back(at(blocks_, row));
        const WalkStyle style{.look_ahead = 9.0f};
        const std::vector<Keyframe> street = walk_along(rounded(corners, 5.0f), style);
        model_.paths = {{"street", street},
                        {"rise", rise_from(street.front().camera, 60.0f, 12.0f)},
                        {"roofs", over_the_roofs()}};
    }

    std::vector<Keyframe> over_the_roofs() const
    {
        std::vector<Keyframe> keys;
        for (uint32_t i = 0; i <= 4; ++i) {
            const float t = 0.25f * static_cast<float>(i);
            Keyframe key{12.0f * static_cast<float>(i), {}, false};
            key.camera.eye = {half_size() * (0.8f * t - 0.4f), 45.0f, 0.4f * half_size()};
            key.camera.target = key.camera.eye + glm::vec3{8.0f * (t - 0.5f), -3.5f, -12.0f};
            keys.push_back(key);
        }
        return keys;
    }

    ViennaOptions options_;
    uint32_t item_triangles_;
    uint32_t blocks_;
    std::vector<HousePlan> plans_;
    std::array<uint64_t, kMeshes> uses_{};
    SceneModel model_;
};

} // namespace

Result<SceneModel> generate_vienna(const ViennaOptions& options, const SceneOptions& scene_options)
{
    return Vienna(options, std::max(scene_options.item_triangles, 1u)).generate();
}

} // namespace occlude::tools
