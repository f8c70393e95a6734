// The image of the CPU device against ray casting in double, and its bits on every machine.
#include "backends/cpu_test_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace occlude {
namespace {

using namespace test;

struct Hit {
    uint32_t item = 0xffffffffu;
    double depth = 1.0;
};

// The nearest triangle on the ray through a window position, found by solving for the ray in
// double. It shares no code with the rasteriser.
Hit brute_force(const TestScene& scene, const View& view, glm::dvec2 pixel)
{
    const glm::dmat4 clip_from_world{view.clip_from_world()};
    const glm::dmat4 world_from_clip = glm::inverse(clip_from_world);
    const glm::dvec2 ndc = 2.0 * pixel / glm::dvec2{view.size_px()} - 1.0;
    const bool zero_to_one = view.convention().range == DepthRange::zero_to_one;
    const bool reversed = view.convention().order == DepthOrder::near_is_large;
    const auto unproject = [&](double z) {
        const glm::dvec4 world = world_from_clip * glm::dvec4{ndc, z, 1.0};
        return glm::dvec3{world} / world.w;
    };
    const glm::dvec3 low = unproject(zero_to_one ? 0.0 : -1.0);
    const glm::dvec3 high = unproject(1.0);
    const glm::dvec3 origin = reversed ? high : low;
    const glm::dvec3 direction = (reversed ? low : high) - origin;
    Hit best;
    double best_t = 1.0;
    for (size_t item = 0; item < scene.meshes.size(); ++item) {
        const TestMesh& mesh = scene.meshes[item];
        const glm::dmat4 world{mesh.world_from_mesh};
        for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
            glm::dvec3 p[3];
            for (size_t k = 0; k < 3; ++k) {
                const glm::dvec3 local{mesh.positions[mesh.indices[i + k]]};
                p[k] = glm::dvec3{world * glm::dvec4{local, 1.0}};
            }
            // origin + t d = p0 + u e1 + v e2
            const glm::dmat3 system{-direction, p[1] - p[0], p[2] - p[0]};
            if (std::abs(glm::determinant(system)) < 1e-14) {
                continue;
            }
            const glm::dvec3 tuv = glm::inverse(system) * (origin - p[0]);
            if (tuv.x >= 0.0 && tuv.x < best_t && tuv.y >= 0.0 && tuv.z >= 0.0 &&
                tuv.y + tuv.z <= 1.0) {
                best_t = tuv.x;
                const glm::dvec4 clip =
                    clip_from_world * glm::dvec4{origin + best_t * direction, 1.0};
                const double z = clip.z / clip.w;
                const double z01 = zero_to_one ? z : 0.5 * z + 0.5;
                best = {static_cast<uint32_t>(item), reversed ? 1.0 - z01 : z01};
            }
        }
    }
    return best;
}

TEST(CpuDeviceDraw, AgreesWithRayCastingInDouble)
{
    // The most that snapping by half of 1/256 px may change, with a margin: rays at the corners
    // around.
    const glm::dvec2 nudges[] = {
        {0.004, 0.004}, {-0.004, 0.004}, {0.004, -0.004}, {-0.004, -0.004}};
    int compared = 0;
    int ambiguous = 0;
    int hits = 0;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
        Rng rng(seed);
        const TestScene scene = random_scene(rng, 40);
        const ClipConvention convention = kConventions[seed % 4];
        const View view = perspective_view({0, 1, 9}, {0, 0, 0}, {641, 359}, convention);
        CpuDevice device(scene);
        draw_frame(device, view, scene.all());
        for (int i = 0; i < 100; ++i) {
            const uint32_t x = rng.below(641);
            const uint32_t y = rng.below(359);
            const glm::dvec2 centre{x + 0.5, y + 0.5};
            const Hit truth = brute_force(scene, view, centre);
            double depth_min = truth.depth;
            double depth_max = truth.depth;
            bool same = true;
            for (const glm::dvec2& nudge : nudges) {
                const Hit hit = brute_force(scene, view, centre + nudge);
                same = same && hit.item == truth.item;
                depth_min = std::min(depth_min, hit.depth);
                depth_max = std::max(depth_max, hit.depth);
            }
            if (!same) {
                ++ambiguous;
                continue;
            }
            ++compared;
            hits += truth.item != 0xffffffffu ? 1 : 0;
            const size_t pixel = size_t{y} * 641 + x;
            ASSERT_EQ(device.owner(pixel).item.value, truth.item)
                << "seed " << seed << " pixel " << x << "," << y;
            ASSERT_GE(device.depth()[pixel], depth_min - 0x1p-22);
            ASSERT_LE(device.depth()[pixel], depth_max + 0x1p-22);
        }
    }
    EXPECT_LT(ambiguous, 20);
    EXPECT_GT(hits, compared / 5) << "the scene is not evidence";
    EXPECT_LT(hits, compared);
}

// The same on every compiler and in every build type: a golden hash of depths and owners.
TEST(CpuDeviceDraw, DrawsTheSameBitsEverywhere)
{
    // Literals and RNG only: library functions such as tan may differ.
    Rng rng(5);
    TestScene scene;
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 centre = random_point(rng, 6.0f);
        const glm::vec3 b = centre + random_point(rng, 2.0f);
        const glm::vec3 c = centre + random_point(rng, 2.0f);
        scene.add({{centre, b, c, b - centre + c}, {0, 1, 2, 1, 2, 3}});
    }
    glm::mat4 clip{1.0f};
    clip[1][1] = 1.75f;
    clip[2] = {0.0f, 0.0f, -1.0f, -1.0f};
    clip[3] = {0.0f, 0.0f, 6.5f, 8.0f};
    const View view = View::from_clip(clip, {321, 179});
    CpuDevice device(scene);
    const auto hash = [&device] {
        uint64_t h = 0;
        for (size_t pixel = 0; pixel < device.depth().size(); ++pixel) {
            const auto depth = static_cast<uint64_t>(double{device.depth()[pixel]} * 0x1p40);
            const CpuDevice::Owner owner = device.owner(pixel);
            h = hash64(h, depth, owner.item.value, owner.triangle);
        }
        return h;
    };
    constexpr uint64_t kGolden = 12679376326155875205u;
    std::vector<ItemId> items = scene.all();
    draw_frame(device, view, items);
    EXPECT_GT(covered(device), 5000u);
    EXPECT_EQ(hash(), kGolden);
    std::reverse(items.begin(), items.end());
    draw_frame(device, view, items);
    EXPECT_EQ(hash(), kGolden) << "drawn in reverse";
}

} // namespace
} // namespace occlude
