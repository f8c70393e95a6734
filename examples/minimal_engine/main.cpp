// A complete integration without a window: a walk through a small town with CHC++. Every frame is
// compared with one that draws everything in the frustum.
#include "ray_device.h"

#include <occlude/core/rng.h>
#include <occlude/cull/chc_plus_plus.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <cstdio>

using namespace occlude;

// Streets between 14 x 14 houses. Each house has three pieces of furniture that are never visible
// from outside.
static std::vector<ItemBounds> make_town()
{
    Rng rng{7};
    std::vector<ItemBounds> items;
    for (uint32_t i = 0; i < 14 * 14; ++i) {
        const uint32_t row = i / 14;
        const uint32_t column = i % 14;
        const glm::vec3 corner{10.0f * static_cast<float>(column), 0.0f,
                               10.0f * static_cast<float>(row)};
        const glm::vec3 size{7.0f, rng.range(4.0f, 20.0f), 7.0f};
        items.push_back({{corner, corner + size}, 12});
        for (int piece = 0; piece < 3; ++piece) {
            const glm::vec3 place =
                corner + glm::vec3{rng.range(1.0f, 5.0f), 0.1f, rng.range(1.0f, 5.0f)};
            items.push_back({{place, place + 1.0f}, 12});
        }
    }
    return items;
}

int main()
{
    const std::vector<ItemBounds> town = make_town();
    const Hierarchy hierarchy = build_bvh(town, {.leaf_triangles = 12}); // one item per leaf

    // One culler per view: it remembers what was visible to this camera.
    ChcPlusPlus culler{hierarchy};
    FrustumCuller reference{hierarchy};
    minimal_engine::RayDevice device{town};
    // Asserts every line of the device contract: use one while you write a device of your own.
    ValidatingDevice checked{device};

    const glm::ivec2 size{96, 54};
    const glm::mat4 clip_from_view =
        glm::perspectiveFov(glm::radians(60.0f), 96.0f, 54.0f, 0.1f, 400.0f);
    constexpr int kFrames = 24;
    uint64_t drawn = 0;
    uint64_t drawn_by_reference = 0;
    uint64_t tests = 0;
    size_t differing_pixels = 0;
    for (int i = 0; i < kFrames; ++i) {
        const float t = static_cast<float>(i) / kFrames;
        const glm::vec3 eye{8.5f, 1.7f, -5.0f + 100.0f * t};
        const glm::vec3 target{8.5f + 60.0f * t, 1.7f, 140.0f};
        const glm::mat4 view_from_world = glm::lookAt(eye, target, {0.0f, 1.0f, 0.0f});
        const View view = View::from_clip(clip_from_view * view_from_world, size);

        const FrameReport report = culler.cull(view, checked);
        const std::vector<ItemId> image = device.image();
        const FrameReport everything = reference.cull(view, checked);

        drawn += report.counters.items_drawn;
        drawn_by_reference += everything.counters.items_drawn;
        tests += report.counters.queries;
        for (size_t pixel = 0; pixel < image.size(); ++pixel) {
            differing_pixels += image[pixel] != device.image()[pixel] ? 1 : 0;
        }
    }
    std::printf("%d frames: %llu of %llu items drawn, %llu tests, %zu differing pixels\n", kFrames,
                static_cast<unsigned long long>(drawn),
                static_cast<unsigned long long>(drawn_by_reference),
                static_cast<unsigned long long>(tests), differing_pixels);
    return differing_pixels == 0 && drawn * 2 < drawn_by_reference ? 0 : 1;
}
