#include "generate/plant_generator.h"

#include "generate/plant_parts.h"
#include "generate/shapes.h"
#include "walk/path_tools.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace occlude::tools {
namespace {

constexpr float kEyeHeight = 1.7f;
constexpr uint32_t kVariants = 3; // of each part that is instanced
constexpr uint32_t kMostFloors = 6;
constexpr float kYardShare = 0.08f; // of the objects

/// A mesh before its triangles are decided.
struct Prototype {
    PlantPart part = PlantPart::frame;
    uint64_t seed = 0;
    uint64_t instances = 0;
};

class Plant {
public:
    Plant(const PlantOptions& options, const SceneOptions& scene_options)
        : options_(options)
        , item_triangles_(std::max(scene_options.item_triangles, 1u))
    {
        const auto yard = static_cast<uint64_t>(kYardShare * static_cast<float>(options.objects));
        bay_objects_ = options.objects - 1 - yard; // the ground is one
        // About as many floors as half the bays along a side.
        while (4 * uint64_t{side_} * side_ * floors() < bay_objects_) {
            ++side_;
        }
        for (uint32_t part = 0; part < static_cast<uint32_t>(PlantPart::count); ++part) {
            for (uint32_t i = 0; i < kVariants; ++i) {
                prototypes_.push_back(
                    {static_cast<PlantPart>(part), hash64(options.seed, part, i, 41), 0});
            }
        }
    }

    Result<SceneModel> generate()
    {
        fill_bays();
        fill_yard();
        if (auto problem = make_meshes()) {
            return *problem;
        }
        add_ground();
        model_.name = fmt::format("plant:triangles={},objects={},seed={}", options_.triangles,
                                  options_.objects, options_.seed);
        const WalkStyle style{.look_ahead = 5.0f};
        model_.paths = {{"walk", walk_along(rounded(corners(), 1.5f), style)},
                        {"through", walk_along(aisle(), style)}};
        return std::move(model_);
    }

private:
    uint32_t floors() const { return std::min(kMostFloors, 1 + side_ / 2); }
    float bay_at(uint32_t i) const
    {
        return kPlantPitch * (static_cast<float>(i) - 0.5f * static_cast<float>(side_ - 1));
    }
    float half_size() const { return 0.5f * kPlantPitch * static_cast<float>(side_); }

    void place(uint32_t prototype, const glm::mat4& world, const glm::vec3& color)
    {
        ++prototypes_[prototype].instances;
        model_.instances.push_back(
            {plant_part_name(prototypes_[prototype].part), prototype, world, color});
    }

    void place_variant(PlantPart part, uint64_t hash, const glm::mat4& world)
    {
        const uint32_t variant = uniform_below(hash, kVariants);
        place(kVariants * static_cast<uint32_t>(part) + variant, world, color_of(part, hash));
    }

    static glm::vec3 color_of(PlantPart part, uint64_t hash)
    {
        constexpr std::array<glm::vec3, static_cast<size_t>(PlantPart::count)> kColors{
            {{0.62f, 0.45f, 0.32f},
             {0.60f, 0.42f, 0.36f},
             {0.45f, 0.58f, 0.62f},
             {0.74f, 0.74f, 0.70f},
             {0.30f, 0.50f, 0.42f},
             {0.52f, 0.50f, 0.55f},
             {0.72f, 0.62f, 0.25f},
             {0.48f, 0.50f, 0.52f},
             {0.55f, 0.36f, 0.28f},
             {0.60f, 0.66f, 0.72f},
             {0.66f, 0.58f, 0.40f},
             {0.80f, 0.80f, 0.78f}}};
        const float light = 0.8f + 0.35f * uniform01(mix64(hash));
        return light * kColors[static_cast<size_t>(part)];
    }

    void fill_bays()
    {
        for (uint32_t floor = 0; floor < floors(); ++floor) {
            for (uint32_t row = 0; row < side_; ++row) {
                for (uint32_t column = 0; column < side_; ++column) {
                    fill_bay(floor, row, column);
                }
            }
        }
        // What rounding left over: sheet around the core, then more pipework.
        for (uint32_t i = 0; model_.instances.size() < bay_objects_; ++i) {
            const uint32_t floor = i / (2 * side_);
            const uint64_t hash = hash64(options_.seed, i, 47);
            const float y = kPlantFloor * static_cast<float>(floor);
            const float out = half_size() + 0.1f;
            const float along = bay_at(i / 2 % side_);
            if (floor >= floors()) {
                add_pipework(hash, {bay_at(uniform_below(hash, side_)), 0.0f,
                                    bay_at(uniform_below(mix64(hash), side_))});
            } else if (i % 2 == 0) {
                place_variant(PlantPart::cladding, hash, quarter_turned(3, {-out, y, along}));
            } else {
                place_variant(PlantPart::cladding, hash, quarter_turned(2, {along, y, -out}));
            }
        }
    }

    void fill_bay(uint32_t floor, uint32_t row, uint32_t column)
    {
        const glm::vec3 at{bay_at(column), kPlantFloor * static_cast<float>(floor), bay_at(row)};
        const uint64_t hash = hash64(options_.seed, floor, row, column, 43);
        const glm::mat4 turned = quarter_turned(uniform_below(mix64(hash), 4), at);
        if (model_.instances.size() + 4 > bay_objects_) {
            return;
        }
        place_variant(PlantPart::frame, hash, turned);
        place_variant(content(floor, row, column, hash), mix64(hash), turned);
        add_pipework(hash, at);
        if (floor > 0) {
            place_variant(PlantPart::grating, hash, turned);
        }
    }

    /// Boilers and bundles in the middle, racks, vessels and machines towards the edge.
    PlantPart content(uint32_t floor, uint32_t row, uint32_t column, uint64_t hash) const
    {
        const uint32_t edge = std::min(std::min(row, column), side_ - 1 - std::max(row, column));
        const uint32_t dice = uniform_below(hash64(hash, 2), 12);
        if (dice == 0) {
            return PlantPart::stairs;
        }
        if (edge * 5 > side_) {
            return dice < 7 ? PlantPart::boiler : dice < 10 ? PlantPart::bundle : PlantPart::trays;
        }
        constexpr std::array<PlantPart, 6> kOuter{PlantPart::rack,    PlantPart::bundle,
                                                  PlantPart::trays,   PlantPart::vessel,
                                                  PlantPart::machine, PlantPart::boiler};
        return kOuter[(dice + floor) % kOuter.size()];
    }

    /// A mesh of its own.
    void add_pipework(uint64_t hash, const glm::vec3& at)
    {
        prototypes_.push_back({PlantPart::pipework, hash, 0});
        place(static_cast<uint32_t>(prototypes_.size() - 1), quarter_turned(0, at),
              color_of(PlantPart::pipework, hash));
    }

    /// Two rows of racks and tanks before the open sides, at +x and +z.
    void fill_yard()
    {
        for (uint32_t i = 0; model_.instances.size() + 1 < options_.objects; ++i) {
            const uint64_t hash = hash64(options_.seed, i, 53);
            const uint32_t lane = i / 2 / side_;
            const float out = half_size() + 12.0f + 15.0f * static_cast<float>(lane);
            const float along = bay_at(i / 2 % side_);
            const bool first = i % 2 == 0;
            const glm::vec3 at = first ? glm::vec3{out, 0.0f, along} : glm::vec3{along, 0.0f, out};
            const bool big = lane % 2 == 1;
            if (big && (i / 2) % 2 == 0) {
                place_variant(PlantPart::tank, hash, quarter_turned(uniform_below(hash, 4), at));
            } else {
                const PlantPart part =
                    uniform_below(mix64(hash), 3) > 0 ? PlantPart::rack : PlantPart::vessel;
                place_variant(part, hash, quarter_turned(first ? 1 : 0, at));
            }
        }
    }

    void add_ground()
    {
        MeshBuilder builder;
        const float half = half_size() + 60.0f;
        builder.box({-half, -0.5f, -half}, {half, -0.05f, half});
        model_.instances.push_back({"ground", static_cast<uint32_t>(model_.meshes.size()),
                                    glm::mat4{1.0f}, glm::vec3{0.40f, 0.39f, 0.37f}});
        model_.meshes.push_back(builder.take("ground", item_triangles_));
    }

    /// How the triangles of a part grow with its elements: nearly in a straight line.
    struct Growth {
        double few = 0.0; ///< triangles with 8 elements
        double each = 1.0;

        uint32_t elements(double budget) const
        {
            return static_cast<uint32_t>(
                std::clamp(8.0 + std::floor((budget - few) / each), 1.0, 100000.0));
        }
        double triangles(uint32_t elements) const { return few + each * (double(elements) - 8.0); }
    };
    using Growths = std::array<Growth, static_cast<size_t>(PlantPart::count)>;

    static Growths measure_growth(uint64_t seed)
    {
        constexpr uint32_t kSeeds = 4; // parts that are laid out at random differ
        constexpr uint32_t kMore = 64;
        Growths growths;
        for (uint32_t part = 0; part < growths.size(); ++part) {
            double few = 0.0;
            double many = 0.0;
            for (uint32_t i = 0; i < kSeeds; ++i) {
                const auto triangles = [&](uint32_t elements) {
                    const uint64_t part_seed = hash64(seed, i, 59);
                    const Mesh mesh =
                        make_plant_part(static_cast<PlantPart>(part), elements, part_seed);
                    return static_cast<double>(mesh.indices.size() / 3) / double{kSeeds};
                };
                few += triangles(8);
                many += triangles(8 + kMore);
            }
            growths[part] = {few, std::max((many - few) / double{kMore}, 1.0)};
        }
        return growths;
    }

    using Elements = std::array<uint32_t, static_cast<size_t>(PlantPart::count)>;

    /// The elements of each part with which all together have about `total` triangles.
    Elements choose_elements(const Growths& growths, double total) const
    {
        Elements elements{};
        double low = 0.0;
        double high = total;
        for (int step = 0; step < 60; ++step) {
            const double unit = 0.5 * (low + high);
            double used = 0.0;
            for (size_t part = 0; part < elements.size(); ++part) {
                elements[part] = growths[part].elements(
                    unit * double{plant_part_weight(static_cast<PlantPart>(part))});
            }
            for (const Prototype& p : prototypes_) {
                const auto part = static_cast<size_t>(p.part);
                used += static_cast<double>(p.instances) * growths[part].triangles(elements[part]);
            }
            (used < total ? low : high) = unit;
        }
        return elements;
    }

    /// Decides about the elements of each part, so that all together have the triangles asked for.
    std::optional<Error> make_meshes()
    {
        const Growths growths = measure_growth(options_.seed);
        const auto total = static_cast<double>(options_.triangles);
        double used = 0.0;
        double aim = total;
        // Growth is not quite even: what came out of the first time is made up for in a second.
        for (int round = 0; round < 2; ++round) {
            const Elements elements = choose_elements(growths, aim);
            used = 0.0;
            model_.meshes.clear();
            for (const Prototype& p : prototypes_) {
                const uint32_t count = elements[static_cast<size_t>(p.part)];
                model_.meshes.push_back(p.instances > 0 ? make_plant_part(p.part, count, p.seed)
                                                        : Mesh{});
                used += static_cast<double>(p.instances) *
                        static_cast<double>(model_.meshes.back().indices.size() / 3);
            }
            if (std::abs(used - total) < 0.03 * total) {
                break;
            }
            aim *= total / used;
        }
        if (std::abs(used - total) > 0.1 * total) {
            return Error{ErrorCode::invalid_argument,
                         fmt::format("{} triangles do not suit {} objects, which can have about "
                                     "{:.0f} at {}; change triangles= or objects=",
                                     options_.triangles, options_.objects, used,
                                     used > total ? "least" : "most")};
        }
        finish_meshes();
        return std::nullopt;
    }

    void finish_meshes()
    {
        std::vector<uint32_t> renumbered(model_.meshes.size(), 0);
        std::vector<Mesh> kept;
        for (size_t i = 0; i < model_.meshes.size(); ++i) {
            renumbered[i] = static_cast<uint32_t>(kept.size());
            if (prototypes_[i].instances > 0) {
                partition_mesh(model_.meshes[i], item_triangles_);
                kept.push_back(std::move(model_.meshes[i]));
            }
        }
        model_.meshes = std::move(kept);
        for (Instance& instance : model_.instances) {
            instance.mesh = renumbered[instance.mesh];
        }
    }

    /// Between the bays, turning at every other one, from a clad corner to the yard.
    std::vector<glm::vec3> corners() const
    {
        const auto at = [&](uint32_t column, uint32_t row) {
            return glm::vec3{bay_at(column) + 0.5f * kPlantPitch, kEyeHeight,
                             bay_at(row) + 0.5f * kPlantPitch};
        };
        uint32_t column = 0;
        uint32_t row = side_ / 2 > 0 ? side_ / 2 - 1 : 0;
        const uint32_t home = row;
        std::vector<glm::vec3> points{at(0, row) - glm::vec3{3.0f, 0.0f, 0.0f}, at(0, row)};
        while (column + 2 < side_) {
            const uint32_t other = row == home ? std::min(row + 1, side_ - 1) : home;
            if (other != row) {
                row = other;
                points.push_back(at(column, row));
            }
            ++column;
            points.push_back(at(column, row));
        }
        const float yard = half_size() + 6.0f;
        points.push_back({yard, kEyeHeight, points.back().z});
        points.push_back({yard, kEyeHeight, half_size() + 6.0f});
        return points;
    }

    /// Straight between the bays of the middle, the whole plant ahead, up to its last third.
    std::vector<glm::vec3> aisle() const
    {
        const float z = bay_at(side_ / 2) - 0.5f * kPlantPitch;
        const float begin = -half_size() - 6.0f;
        return {{begin, kEyeHeight, z}, {half_size() / 3.0f, kEyeHeight, z}};
    }

    PlantOptions options_;
    uint32_t item_triangles_;
    uint64_t bay_objects_ = 0;
    uint32_t side_ = 2; ///< bays along a side
    std::vector<Prototype> prototypes_;
    SceneModel model_;
};

} // namespace

Result<SceneModel> generate_plant(const PlantOptions& options, const SceneOptions& scene_options)
{
    return Plant(options, scene_options).generate();
}

} // namespace occlude::tools
