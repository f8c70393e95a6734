#include "generate/city_generator.h"

#include "generate/city_buildings.h"
#include "generate/city_furniture.h"
#include "generate/city_paths.h"
#include "generate/shapes.h"
#include "model/mesh_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {
namespace {

constexpr float kFacadeLine = 30.0f; // metres from the middle of a block
constexpr float kKerb = 33.0f;
constexpr float kLot = 13.0f; // depth of a house, side of a corner house
constexpr uint32_t kHousesPerWidth = 6;
constexpr uint32_t kCornerHouses = 10;
constexpr uint32_t kTowers = 3;
constexpr uint32_t kVariants = 6; // of each kind of furniture
constexpr float kTowerWidth = 16.0f;
constexpr std::array<float, 6> kWidths{10.0f, 12.0f, 14.0f, 17.0f, 20.0f, 24.0f};

/// How the 34 m between two corner houses are divided: indices into kWidths.
struct Division {
    std::array<uint32_t, 3> widths{};
    uint32_t count = 0;
};
constexpr std::array<Division, 8> kDivisions{{{{0, 2, 0}, 3},
                                              {{0, 1, 1}, 3},
                                              {{1, 0, 1}, 3},
                                              {{3, 3, 0}, 2},
                                              {{2, 4, 0}, 2},
                                              {{4, 2, 0}, 2},
                                              {{0, 5, 0}, 2},
                                              {{5, 0, 0}, 2}}};

enum class MeshKind : uint8_t { ground, house, furniture };

/// One of the city's meshes before its triangles are decided.
struct Prototype {
    MeshKind kind = MeshKind::house;
    HousePlan house{};
    Furniture furniture = Furniture::tree;
    uint64_t seed = 0;
    uint64_t instances = 0;
};

/// Numbers are drawn one per statement: the order of arguments is the compiler's choice.
class City {
public:
    City(const CityOptions& options, const SceneOptions& scene_options);
    Result<SceneModel> generate();

private:
    void plan_prototypes();
    uint32_t add_house(const HousePlan& plan);
    void place(uint32_t prototype, const glm::mat4& world, const glm::vec3& color,
               const char* name);

    void lay_out_block(uint32_t row, uint32_t column);
    void lay_out_side(const glm::vec3& center, uint32_t side, uint64_t block_seed);
    void lay_out_yard(const glm::vec3& center, uint64_t block_seed);
    void furnish_side(const glm::vec3& center, uint32_t side, uint64_t block_seed);

    Mesh make_ground(size_t budget) const;
    Result<std::vector<Mesh>> make_meshes();
    uint32_t furniture(Furniture kind, uint64_t hash) const
    {
        return first_furniture_ + kVariants * static_cast<uint32_t>(kind) +
               uniform_below(hash, kVariants);
    }

    CityOptions options_;
    SceneOptions scene_options_;
    CityStreets streets_;
    std::vector<Prototype> prototypes_;
    uint32_t first_corner_ = 0;
    uint32_t first_tower_ = 0;
    uint32_t first_furniture_ = 0;
    SceneModel model_;
};

City::City(const CityOptions& options, const SceneOptions& scene_options)
    : options_(options)
    , scene_options_(scene_options)
    , streets_(options.blocks, options.seed)
{
    plan_prototypes();
}

uint32_t City::add_house(const HousePlan& plan)
{
    prototypes_.push_back({.kind = MeshKind::house, .house = plan});
    return static_cast<uint32_t>(prototypes_.size() - 1);
}

void City::plan_prototypes()
{
    prototypes_.push_back({.kind = MeshKind::ground});
    Rng rng(hash64(options_.seed, 100));
    for (float width : kWidths) {
        for (uint32_t i = 0; i < kHousesPerWidth; ++i) {
            HousePlan plan;
            plan.width = width;
            plan.depth = kLot;
            const uint32_t more = rng.below(2);
            plan.floors = 3 + (i + more) % 5;
            plan.floors += rng.below(8) == 0 ? 2 : 0;
            plan.pitched_roof = rng.below(5) < 2;
            plan.wing = width >= 14.0f && rng.below(2) == 0 ? 5.0f : 0.0f;
            plan.seed = rng.next();
            add_house(plan);
        }
    }
    first_corner_ = static_cast<uint32_t>(prototypes_.size());
    for (uint32_t i = 0; i < kCornerHouses; ++i) {
        HousePlan plan;
        plan.width = kLot;
        plan.depth = kLot;
        plan.floors = 4 + (i + rng.below(2)) % 4;
        plan.street_sides = HousePlan::kFront | HousePlan::kRight;
        plan.yard_sides = 0;
        plan.seed = rng.next();
        add_house(plan);
    }
    first_tower_ = static_cast<uint32_t>(prototypes_.size());
    for (uint32_t i = 0; i < kTowers; ++i) {
        HousePlan plan;
        plan.width = kTowerWidth;
        plan.depth = kTowerWidth;
        plan.floors = 11 + 3 * i + rng.below(3);
        plan.street_sides = HousePlan::kFront;
        plan.yard_sides = HousePlan::kAllSides & ~HousePlan::kFront;
        plan.seed = rng.next();
        add_house(plan);
    }
    first_furniture_ = static_cast<uint32_t>(prototypes_.size());
    for (uint32_t kind = 0; kind < kFurnitureKinds; ++kind) {
        for (uint32_t i = 0; i < kVariants; ++i) {
            prototypes_.push_back({.kind = MeshKind::furniture,
                                   .furniture = static_cast<Furniture>(kind),
                                   .seed = rng.next()});
        }
    }
}

void City::place(uint32_t prototype, const glm::mat4& world, const glm::vec3& color,
                 const char* name)
{
    ++prototypes_[prototype].instances;
    model_.instances.push_back({name, prototype, world, color});
}

glm::vec3 facade_color(uint64_t hash)
{
    constexpr std::array<glm::vec3, 8> kColors{{{0.72f, 0.62f, 0.48f},
                                                {0.66f, 0.44f, 0.34f},
                                                {0.75f, 0.70f, 0.62f},
                                                {0.58f, 0.55f, 0.52f},
                                                {0.78f, 0.68f, 0.42f},
                                                {0.55f, 0.33f, 0.27f},
                                                {0.62f, 0.66f, 0.68f},
                                                {0.70f, 0.56f, 0.50f}}};
    return (0.85f + 0.3f * uniform01(mix64(hash))) * kColors[uniform_below(hash, 8)];
}

/// The houses along one side of a block; `side` counts quarter turns from +z.
void City::lay_out_side(const glm::vec3& center, uint32_t side, uint64_t block_seed)
{
    const uint64_t seed = hash64(block_seed, side, 7);
    uint32_t slot = 0;
    const auto add = [&](uint32_t prototype, float x, uint64_t hash) {
        // Neighbours stand a little before or behind, above or below each other and overlap by a
        // centimetre: no gaps, and no two faces in one plane.
        const float step = static_cast<float>(slot % 5);
        const glm::mat4 turned = quarter_turned(side, center);
        const glm::vec4 at =
            turned * glm::vec4{x, 0.15f - 0.02f * step, kFacadeLine - 0.04f * step, 1.0f};
        glm::mat4 world = quarter_turned(side, glm::vec3{at});
        const float wider = 1.0f + 0.01f / prototypes_[prototype].house.width;
        world[0] *= wider;
        place(prototype, world, facade_color(hash), "house");
        ++slot;
    };
    const uint64_t corner = hash64(seed, 1);
    add(first_corner_ + uniform_below(corner, kCornerHouses), kFacadeLine - 0.5f * kLot, corner);
    const Division& division = kDivisions[uniform_below(hash64(seed, 2), kDivisions.size())];
    float x = -kFacadeLine + kLot;
    slot = 1;
    for (uint32_t i = 0; i < division.count; ++i) {
        const uint64_t hash = hash64(seed, 3, i);
        const uint32_t width = division.widths[i];
        add(1 + width * kHousesPerWidth + uniform_below(hash, kHousesPerWidth),
            x + 0.5f * kWidths[width], hash);
        x += kWidths[width];
    }
}

void City::lay_out_yard(const glm::vec3& center, uint64_t block_seed)
{
    const uint64_t hash = hash64(block_seed, 50);
    if (uniform_below(hash, 12) == 0) {
        const glm::vec3 at = center + glm::vec3{0.0f, 0.15f, 0.5f * kTowerWidth};
        place(first_tower_ + uniform_below(mix64(hash), kTowers), quarter_turned(0, at),
              facade_color(mix64(hash)), "tower");
        return;
    }
    Rng rng(hash);
    for (uint32_t i = 0; i < 3; ++i) {
        const glm::vec3 at{rng.range(-8.0f, 8.0f), 0.15f, rng.range(-8.0f, 8.0f)};
        const uint32_t tree = furniture(Furniture::tree, rng.next());
        place(tree, quarter_turned(rng.below(4), center + at), {0.25f, 0.45f, 0.2f}, "tree");
    }
}

/// Trees, lamps, benches, bins and a sign on the pavement, and parked cars before it.
void City::furnish_side(const glm::vec3& center, uint32_t side, uint64_t block_seed)
{
    Rng rng(hash64(block_seed, side, 60));
    const glm::mat4 turned = quarter_turned(side, center);
    const auto add = [&](Furniture kind, float x, float z, uint32_t turns, const glm::vec3& color,
                         const char* name) {
        const float y = kind == Furniture::car ? 0.0f : 0.15f;
        const glm::vec4 at = turned * glm::vec4{x, y, z, 1.0f};
        place(furniture(kind, rng.next()), quarter_turned(side + turns, glm::vec3{at}), color,
              name);
    };
    for (float x : {-24.0f, -8.0f, 8.0f, 24.0f}) {
        if (rng.below(5) > 0) {
            const glm::vec3 green{0.22f, rng.range(0.4f, 0.52f), 0.16f};
            add(Furniture::tree, x, 32.2f, rng.below(4), green, "tree");
        }
    }
    for (float x : {-16.0f, 16.0f}) {
        add(Furniture::lamp, x, 32.5f, 0, {0.25f, 0.27f, 0.28f}, "lamp");
    }
    for (float x = -27.0f; x <= 27.0f; x += 6.0f) {
        if (rng.below(3) == 0) {
            const float jitter = rng.range(-0.5f, 0.5f);
            const glm::vec3 color{rng.range(0.15f, 0.8f), rng.range(0.15f, 0.7f),
                                  rng.range(0.15f, 0.8f)};
            add(Furniture::car, x + jitter, 34.1f, 2 * rng.below(2), color, "car");
        }
    }
    add(Furniture::bench, rng.range(-5.0f, 5.0f), 31.9f, 2, {0.45f, 0.3f, 0.18f}, "bench");
    add(Furniture::bin, rng.range(10.0f, 14.0f), 32.4f, 0, {0.2f, 0.3f, 0.25f}, "bin");
    add(Furniture::sign, 29.0f, 32.3f, rng.below(2), {0.7f, 0.72f, 0.75f}, "sign");
}

void City::lay_out_block(uint32_t row, uint32_t column)
{
    const uint64_t seed = hash64(options_.seed, row, column, 5);
    const glm::vec3 center = streets_.block_center(row, column);
    place(0, quarter_turned(0, center), {0.42f, 0.42f, 0.43f}, "ground");
    for (uint32_t side = 0; side < 4; ++side) {
        lay_out_side(center, side, seed);
        furnish_side(center, side, seed);
    }
    lay_out_yard(center, seed);
}

/// The street around a block as far as the middle of it, the pavement and the yard.
Mesh City::make_ground(size_t budget) const
{
    constexpr float kHalf = 0.5f * CityStreets::kPitch;
    constexpr float kPavement = 0.15f;
    MeshBuilder builder;
    const auto flat = [&](glm::vec2 low, glm::vec2 high, float y) {
        builder.quad({low.x, y, high.y}, {high.x, y, high.y}, {high.x, y, low.y},
                     {low.x, y, low.y});
    };
    for (uint32_t side = 0; side < 4; ++side) {
        const glm::mat4 turned = quarter_turned(side, glm::vec3{0.0f});
        const auto at = [&](float x, float y, float z) {
            return glm::vec3{turned * glm::vec4{x, y, z, 1.0f}};
        };
        builder.quad(at(-kHalf, 0.0f, kHalf), at(kHalf, 0.0f, kHalf), at(kKerb, 0.0f, kKerb),
                     at(-kKerb, 0.0f, kKerb));
        builder.quad(at(-kKerb, 0.0f, kKerb), at(kKerb, 0.0f, kKerb), at(kKerb, kPavement, kKerb),
                     at(-kKerb, kPavement, kKerb));
        for (float x = -26.0f; x <= 26.0f && builder.triangles() + 60 < budget; x += 4.0f) {
            builder.quad(at(x, 0.02f, kHalf - 0.01f), at(x + 2.0f, 0.02f, kHalf - 0.01f),
                         at(x + 2.0f, 0.02f, kHalf - 0.15f), at(x, 0.02f, kHalf - 0.15f));
        }
        for (float z = 33.4f; z < 37.4f && builder.triangles() + 60 < budget; z += 0.8f) {
            builder.quad(at(30.0f, 0.025f, z + 0.4f), at(33.0f, 0.025f, z + 0.4f),
                         at(33.0f, 0.025f, z), at(30.0f, 0.025f, z));
        }
    }
    flat(glm::vec2{-kKerb}, glm::vec2{kKerb}, kPavement);
    return builder.take("ground", 0xffffffffu);
}

/// Spends the triangles: a quarter on furniture as far as it can use them, the rest on houses by
/// the area of their facades.
Result<std::vector<Mesh>> City::make_meshes()
{
    // What the kinds of furniture need relative to each other.
    constexpr std::array<float, kFurnitureKinds> kNeed{1.0f, 0.9f, 0.35f, 0.25f, 0.2f, 0.15f};
    constexpr uint32_t kWhole = 0xffffffffu; // parts are made once the budget is known to suit
    const auto total = static_cast<double>(options_.triangles);
    const double blocks = static_cast<double>(prototypes_[0].instances);
    double need = 0.0;
    double area = 0.0;
    for (const Prototype& prototype : prototypes_) {
        const auto count = static_cast<double>(prototype.instances);
        if (prototype.kind == MeshKind::house) {
            area += count * double{facade_area(prototype.house)};
        } else if (prototype.kind == MeshKind::furniture) {
            need += count * double{kNeed[static_cast<uint32_t>(prototype.furniture)]};
        }
    }

    std::vector<Mesh> meshes(prototypes_.size());
    double left = total;
    const auto pay = [&](size_t i, Mesh mesh) {
        left -= static_cast<double>(prototypes_[i].instances) *
                static_cast<double>(mesh.indices.size() / 3);
        meshes[i] = std::move(mesh);
    };
    pay(0, make_ground(static_cast<size_t>(0.05 * total / blocks)));
    const double furniture_unit = 0.25 * total / need;
    for (size_t i = first_furniture_; i < prototypes_.size(); ++i) {
        const Prototype& p = prototypes_[i];
        const double share = furniture_unit * double{kNeed[static_cast<uint32_t>(p.furniture)]};
        const size_t budget = std::min(static_cast<size_t>(share), furniture_limit(p.furniture));
        pay(i, make_furniture(p.furniture, p.seed, budget, kWhole));
    }
    const double per_area = std::max(left, 0.0) / area;
    for (size_t i = 1; i < first_furniture_; ++i) {
        const HousePlan& plan = prototypes_[i].house;
        const auto budget = static_cast<size_t>(per_area * double{facade_area(plan)});
        pay(i, make_house(plan, budget, fmt::format("house {}", i), kWhole));
    }
    // What is left over is less than one detail per house, or what no detail was found for.
    const double used = total - left;
    if (left < -0.05 * total || left > 0.05 * total) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("{} triangles do not suit {} x {} blocks, which can have about "
                                 "{:.0f} at {}; change triangles= or blocks=",
                                 options_.triangles, options_.blocks, options_.blocks, used,
                                 left < 0.0 ? "least" : "most")};
    }
    for (Mesh& mesh : meshes) {
        partition_mesh(mesh, std::max(scene_options_.item_triangles, 1u));
    }
    return meshes;
}

Result<SceneModel> City::generate()
{
    for (uint32_t row = 0; row < options_.blocks; ++row) {
        for (uint32_t column = 0; column < options_.blocks; ++column) {
            lay_out_block(row, column);
        }
    }
    auto meshes = make_meshes();
    if (!meshes) {
        return meshes.error();
    }
    model_.meshes = std::move(*meshes);
    // Prototypes that nothing was made of stay out.
    std::vector<uint32_t> renumbered(model_.meshes.size(), 0);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < model_.meshes.size(); ++i) {
        renumbered[i] = kept;
        if (prototypes_[i].instances > 0) {
            if (kept != i) {
                model_.meshes[kept] = std::move(model_.meshes[i]);
            }
            ++kept;
        }
    }
    model_.meshes.resize(kept);
    for (Instance& instance : model_.instances) {
        instance.mesh = renumbered[instance.mesh];
    }
    model_.name = fmt::format("city:blocks={},seed={},triangles={}", options_.blocks, options_.seed,
                              options_.triangles);
    model_.paths = city_paths(streets_);
    return std::move(model_);
}

} // namespace

Result<SceneModel> generate_city(const CityOptions& options, const SceneOptions& scene_options)
{
    return City(options, scene_options).generate();
}

} // namespace occlude::tools
