// Runs a culler beside the reference on the exact CPU device, for tests of invariant I6: the image
// of an exact algorithm equals that of drawing everything in the frustum.
#pragma once

#include "support/all_methods_device.h"
#include "support/trees.h"

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/registry.h>
#include <occlude/device/delaying_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

namespace occlude::test::exactness {

/// Boxes of twelve triangles: item i is bounds[i] exactly, or a pyramid in it, which leaves most of
/// its box empty.
class BoxScene final : public CpuScene {
public:
    explicit BoxScene(std::vector<ItemBounds> items)
        : bounds(std::move(items))
    {
        for (ItemBounds& item : bounds) {
            item.triangles = 12;
        }
        positions_.resize(bounds.size());
        rebuild();
    }

    void rebuild()
    {
        for (size_t i = 0; i < bounds.size(); ++i) {
            const Aabb& box = bounds[i].box;
            auto& corners = positions_[i];
            corners.clear();
            for (int c = 0; c < 8; ++c) {
                glm::vec3 p{(c & 1) != 0 ? box.max.x : box.min.x,
                            (c & 2) != 0 ? box.max.y : box.min.y,
                            (c & 4) != 0 ? box.max.z : box.min.z};
                if (i % 3 == 0 && (c & 2) != 0) {
                    p = {box.center().x, box.max.y, box.center().z};
                }
                corners.push_back(p);
            }
        }
    }

    CpuItem item(ItemId item) const override
    {
        static const std::vector<uint32_t> kIndices{0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7,
                                                    0, 4, 1, 1, 4, 5, 2, 3, 6, 6, 3, 7,
                                                    0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};
        return {.positions = positions_[item.value],
                .indices = kIndices,
                .translucent = has_flag(bounds[item.value].flags, ItemFlags::translucent)};
    }

    std::vector<ItemBounds> bounds;

private:
    std::vector<std::vector<glm::vec3>> positions_;
};

struct Picture {
    std::vector<float> depth;
    std::vector<CpuDevice::Owner> owners;
    std::vector<CpuDevice::TranslucentFragment> translucent;

    bool operator==(const Picture&) const = default;
};

inline Picture picture_of(const CpuDevice& device)
{
    Picture picture;
    picture.depth.assign(device.depth().begin(), device.depth().end());
    for (size_t i = 0; i < picture.depth.size(); ++i) {
        picture.owners.push_back(device.owner(i));
    }
    const auto fragments = device.translucent_fragments();
    picture.translucent.assign(fragments.begin(), fragments.end());
    return picture;
}

inline View with_convention(const View& view, ClipConvention convention)
{
    glm::mat4 fix{1.0f};
    const bool reversed = convention.order == DepthOrder::near_is_large;
    if (convention.range == DepthRange::zero_to_one) {
        fix[2][2] = reversed ? -0.5f : 0.5f;
        fix[3][2] = 0.5f;
    } else if (reversed) {
        fix[2][2] = -1.0f;
    }
    return View::from_clip(fix * view.clip_from_world(), view.size_px(), convention);
}

// A walk with jumps and 90 degree turns, inside and outside of the boxes.
inline View camera(uint64_t frame, glm::ivec2 size)
{
    const float t = static_cast<float>(frame);
    if (frame % 10 == 5) {
        return test::look({-30.0f, 3.0f, 8.0f}, {30.0f, 0.0f, 0.0f}, size);
    }
    if (frame % 10 > 7) {
        return test::look({1.0f, 0.0f, 20.0f - t}, {60.0f, 0.0f, 20.0f - t}, size);
    }
    return test::look({1.0f, 0.5f, 26.0f - 2.0f * t}, {0.4f * t, 0.0f, -60.0f}, size);
}

struct Case {
    std::string algorithm;
    std::vector<OptionValue> options = {};
    ClipConvention convention = {};
    glm::ivec2 size{161, 89};
    bool moving = false;
    bool late_answers = false;
    std::string_view hierarchy = "bvh";
    TestMethod method = TestMethod::queries;
    bool flags = false; ///< some items are translucent, some never cull, some never occlude
    bool culls = true;  ///< must draw visibly less than what is in the frustum
    /// The triangles that an item claims to have, by which algorithms decide whether a test pays.
    uint32_t triangles_claimed = 12;
};

/// True if the algorithm is exact by default, and decides by tests what to draw.
inline bool culls_exactly(const AlgorithmInfo& info)
{
    return info.exact && !info.needs.visible_set && info.name != "frustum";
}

// Runs an algorithm beside the reference and expects the same picture in every frame.
inline void expect_exact(const Case& setup)
{
    BoxScene scene(test::random_boxes(700, 31, 24.0f, 7.0f));
    for (size_t i = 0; setup.flags && i < scene.bounds.size(); ++i) {
        constexpr std::array kFlags{
            ItemFlags::translucent, ItemFlags::never_occlude, ItemFlags::never_cull,
            ItemFlags::never_cull | ItemFlags::translucent, ItemFlags::alpha_tested};
        scene.bounds[i].flags = i % 37 < kFlags.size() ? kFlags[i % 37] : ItemFlags::none;
    }
    for (ItemBounds& item : scene.bounds) {
        item.triangles = setup.triangles_claimed;
    }
    Hierarchy tree = find_hierarchy_kind(setup.hierarchy)->build(scene.bounds, 24);
    CpuDevice device(scene);
    ASSERT_TRUE(device.use_method(setup.method));
    CpuDevice reference_device(scene);
    DelayingDevice late(device, {.seed = 3, .max_polls = 5, .lose_every = 7});
    test::AllMethodsDevice used(setup.late_answers ? static_cast<QueryDevice&>(late) : device);
    FrustumCuller reference{tree};
    auto culler = make_culler(setup.algorithm, tree, setup.options);
    ASSERT_TRUE(culler) << culler.error().message;

    uint64_t drawn = 0;
    uint64_t in_frustum = 0;
    uint64_t blended = 0;
    for (uint64_t frame = 0; frame < 20; ++frame) {
        if (setup.moving) {
            for (size_t i = 0; i < scene.bounds.size(); ++i) {
                const glm::vec3 step{0.3f * static_cast<float>(i % 3) - 0.3f, 0.0f,
                                     0.2f * static_cast<float>(i % 5) - 0.4f};
                scene.bounds[i].box.min += step;
                scene.bounds[i].box.max += step;
            }
            scene.rebuild();
            tree.refit(scene.bounds);
        }
        const View view = with_convention(camera(frame, setup.size), setup.convention);
        reference.cull(view, reference_device);
        (*culler)->cull(view, used);
        const Picture expected = picture_of(reference_device);
        ASSERT_EQ(picture_of(device), expected) << "frame " << frame;
        blended += expected.translucent.size();
        drawn += (*culler)->drawn_items().size();
        in_frustum += reference.drawn_items().size();
    }
    // Expects that the scene is evidence: something is hidden, and something is not.
    EXPECT_TRUE(drawn < in_frustum * 19 / 20 || !setup.culls);
    EXPECT_GT(drawn, in_frustum / 20);
    EXPECT_EQ(blended > 1000, setup.flags);
}

} // namespace occlude::test::exactness
