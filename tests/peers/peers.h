// Scenes and checks for the tests of defects of other code.
#pragma once

#include "support/box_scene.h"
#include "support/trees.h"
#include "worlds/run_case.h"
#include "worlds/spec.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/registry.h>

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace occlude::test::peers {

inline constexpr std::array kExact{"stop_and_wait", "chc",       "chc_plus_plus", "two_phase",
                                   "statistical",   "lazy_grid", "two_level",     "adaptive"};

inline std::unique_ptr<Culler> make(std::string_view algorithm, const Hierarchy& tree,
                                    std::vector<OptionValue> options = {})
{
    auto made = make_culler(algorithm, tree, options);
    EXPECT_TRUE(made) << algorithm;
    return std::move(*made);
}

/// A wall at z = -6 with everything else behind it, but for what stands beside it.
inline std::vector<ItemBounds> behind_a_wall(int boxes)
{
    std::vector<ItemBounds> items{{{{-30, -30, -6.5f}, {30, 30, -6}}, 2000}};
    Rng rng{3};
    for (int i = 0; i < boxes; ++i) {
        const glm::vec3 at{rng.range(-12, 12), rng.range(-12, 12), rng.range(-40, -10)};
        items.push_back({{at - 0.5f, at + 0.5f}, 200});
    }
    return items;
}

inline std::vector<uint32_t> owners_of_everything(const CpuScene& scene, size_t items,
                                                  const View& view)
{
    CpuDevice device(scene);
    draw_everything(device, items, view);
    return owners(device);
}

/// Runs some random worlds changed by `change`. All must pass, and be evidence.
inline void expect_worlds_pass(const std::function<void(worlds::Spec&)>& change,
                               uint64_t first_seed, double least_hidden = 0.1)
{
    worlds::Counts counts;
    for (const char* algorithm : kExact) {
        for (uint64_t i = 0; i < 12; ++i) {
            worlds::Spec spec = worlds::random_spec(first_seed + i, algorithm);
            change(spec);
            ASSERT_EQ(run_case(spec, counts), "") << to_text(spec);
        }
    }
    EXPECT_GT(counts.hidden_share(), least_hidden);
    EXPECT_LT(counts.hidden_share(), 0.9);
}

} // namespace occlude::test::peers
