// What must hold after every frame of every algorithm that reads depth instead of issuing tests:
// the counterpart of invariants_test.cpp. The device's depth is made up but consistent: within a
// frame it only comes nearer. (exactness_test.cpp checks the image.)
#include <occlude/cull/registry.h>
#include <occlude/screen/depth_tiles.h>
#include <occlude/screen/projection.h>
#include <occlude/screen/screen_box.h>

#include "support/walks.h"

#include <occlude/device/counting_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

namespace occlude {
namespace {

struct Case {
    std::string algorithm;
    std::vector<OptionValue> options;
    std::string hierarchy = "bvh";
};

std::string name_of(const ::testing::TestParamInfo<Case>& info)
{
    return test::case_name(info.param.hierarchy + "_" + info.param.algorithm, info.param.options);
}

const std::vector<Case>& cases()
{
    static const std::vector<Case> all{
        {"lazy_grid", {}},
        {"lazy_grid", {{"update", "busy"}}},
        {"lazy_grid", {{"variant", "occlusion_buffer"}}},
        {"lazy_grid", {{"traversal", "two_lists"}}},
        {"lazy_grid", {{"join", "rows"}}},
        {"lazy_grid", {{"join", "target"}, {"update", "busy"}}},
        {"lazy_grid", {{"cell_size", "1"}}},
        {"lazy_grid", {{"cell_size", "32768"}}},
        {"lazy_grid", {{"tests_at_once", "1"}}},
        {"lazy_grid", {{"tests_at_once", "2"}}},
        {"lazy_grid", {{"bounds", "faces"}}},
        {"lazy_grid", {{"bounds", "faces"}, {"join", "rows"}}},
        {"lazy_grid", {{"free_below_covered", "0.5"}}},
        {"lazy_grid", {{"whole_cell_share", "0.5"}}},
        {"lazy_grid", {{"internal_above_pixels", "500"}}},
        {"lazy_grid", {{"tile", "8"}}},
        {"lazy_grid", {{"tile", "8"}, {"bounds", "faces"}, {"cell_size", "20"}}},
        {"two_phase", {}},
        {"two_phase", {{"refine", "false"}}},
        {"two_phase", {{"virtual_leaves", "true"}}},
        {"two_phase", {{"reread_triangles", "500"}}},
        {"two_phase", {{"reread_triangles", "0"}, {"final_depth", "true"}}},
        {"two_phase", {{"tile", "8"}}},
        {"adaptive", {{"method", "pyramid"}}},
    };
    return all;
}

// ... and those over a cut, whose entries are nodes and single items, on the other hierarchies.
std::vector<Case> all_cases()
{
    std::vector<Case> all = cases();
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        if (kind.name != "bvh") {
            all.push_back({"two_phase", {}, std::string{kind.name}});
            all.push_back({"adaptive", {{"method", "pyramid"}}, std::string{kind.name}});
        }
    }
    return all;
}

// True for algorithms that test the faces of boxes, and not only their rectangles.
bool tests_faces(const Case& c)
{
    return c.algorithm != "lazy_grid" ||
           std::ranges::count(c.options, OptionValue{"bounds", "faces"}) > 0;
}

View camera(uint64_t frame)
{
    const float t = static_cast<float>(frame);
    if (frame % 16 == 7) {
        return test::look({-60.0f, 5.0f, 10.0f}, {60.0f, 0.0f, 0.0f}, {67, 45}); // a jump
    }
    return test::look({0.0f, 0.0f, 60.0f - t}, {0.1f * t, 0.0f, -60.0f}, {67, 45});
}

class DepthInvariants : public ::testing::TestWithParam<Case> {
protected:
    std::unique_ptr<Culler> make(const Hierarchy& tree) const
    {
        return std::move(make_culler(GetParam().algorithm, tree, GetParam().options).value());
    }
    std::unique_ptr<Culler> make() const { return make(tree_); }

    // Each drawn item covers the rectangle of its box at the farthest depth of the box, but for a
    // free stripe.
    DeviceScript script(const ScriptedDevice& device)
    {
        DeviceScript script;
        script.caps.read_depth = true;
        script.depth = [&](const PixelRect& rect, std::span<float> out) {
            std::fill(out.begin(), out.end(), 1.0f);
            for (const ItemId item : device.items_drawn_this_frame()) {
                const ScreenBounds bounds = project(view_, boxes_[item.value].box);
                for (int y = 0; bounds.valid && y < bounds.rect.height; ++y) {
                    for (int x = 0; x < bounds.rect.width; ++x) {
                        const int px = bounds.rect.x + x - rect.x;
                        const int py = bounds.rect.y + y - rect.y;
                        const bool free = bounds.rect.x + x < 5;
                        if (!free && px >= 0 && py >= 0 && px < rect.width && py < rect.height) {
                            float& d = out[static_cast<size_t>(py * rect.width + px)];
                            d = std::min(d, bounds.far_depth);
                        }
                    }
                }
            }
            return true;
        };
        script.caps.depth_reads = {{.tile_px = 1}, {.tile_px = 8}};
        script.depth_tiles = [this, depth = script.depth](int tile_px, std::span<float> out) {
            const glm::ivec2 size = view_.size_px();
            std::vector<float> pixels(static_cast<size_t>(size.x) * static_cast<size_t>(size.y));
            depth({0, 0, size.x, size.y}, pixels);
            farthest_of_tiles(pixels, size, tile_px, out);
            return true;
        };
        return script;
    }

    const std::vector<ItemBounds> boxes_ = test::random_boxes(300, 41, 50.0f, 12.0f);
    const HierarchyKind& kind_ = *find_hierarchy_kind(GetParam().hierarchy);
    const Hierarchy tree_ = kind_.build(boxes_, 300);
    View view_;
};

TEST_P(DepthInvariants, TheContractHoldsAndTheReportAgreesWithACountFromOutside)
{
    ScriptedDevice scripted;
    scripted.script() = script(scripted);
    std::vector<std::string> violations;
    ValidatingDevice valid(scripted,
                           {.on_violation = [&](std::string_view rule, std::string_view text) {
                               violations.push_back(std::string{rule} + " " + std::string{text});
                           }});
    std::vector<uint32_t> triangles;
    for (const ItemBounds& item : boxes_) {
        triangles.push_back(item.triangles);
    }
    CountingDevice device(valid, {.triangles_by_item = triangles});
    const auto culler = make();
    for (uint64_t frame = 0; frame < 20; ++frame) {
        view_ = camera(frame);
        FrameCounters told = culler->cull(view_, device).counters;
        told.nodes_visited = 0; // only the algorithm knows these two
        told.cells_asked = 0;
        EXPECT_EQ(told, device.frame());
    }
    EXPECT_EQ(violations, std::vector<std::string>{});
}

TEST_P(DepthInvariants, EveryItemIsDrawnOrBehindPixelsOrOutsideAndTheLogSaysWhich)
{
    ScriptedDevice device;
    device.script() = script(device);
    const auto culler = make();
    const bool by_faces = tests_faces(GetParam());
    size_t drawn = 0;
    size_t hidden = 0;
    for (uint64_t frame = 0; frame < 20; ++frame) {
        view_ = camera(frame);
        culler->cull(view_, device);
        const std::set<ItemId> in_image(culler->drawn_items().begin(), culler->drawn_items().end());
        EXPECT_EQ(in_image.size(), culler->drawn_items().size()); // each once
        const std::vector<Decision> decisions = culler->decisions().by_item(tree_);
        std::vector<float> depth(67 * 45);
        device.script().depth({0, 0, 67, 45}, depth);
        for (const ItemId item : tree_.items()) {
            const Aabb& box = boxes_[item.value].box;
            if (view_.frustum().classify(box) == Containment::outside) {
                continue;
            }
            ASSERT_EQ(in_image.contains(item), is_drawn(decisions[item.value]));
            if (in_image.contains(item)) {
                ++drawn;
                continue;
            }
            ++hidden;
            const ScreenBounds bounds = project(view_, box);
            ASSERT_TRUE(bounds.valid);
            const ScreenBox faces{ScreenSpace{view_}, box};
            for (int y = bounds.rect.y; y < bounds.rect.y + bounds.rect.height; ++y) {
                for (int x = bounds.rect.x; x < bounds.rect.x + bounds.rect.width; ++x) {
                    const double nearest =
                        by_faces ? faces.nearest_over({x, y}, {x, y}) : bounds.near_depth;
                    ASSERT_LT(depth[static_cast<size_t>(y * 67 + x)], nearest)
                        << "item " << item.value << " at " << x << ", " << y;
                }
            }
        }
    }
    // Both outcomes are frequent, so that the scene is evidence.
    EXPECT_GT(drawn, (drawn + hidden) / 10);
    EXPECT_GT(hidden, (drawn + hidden) / 10);
}

TEST_P(DepthInvariants, ADeviceWithoutDepthDrawsEverything)
{
    ScriptedDevice device;
    const auto culler = make();
    for (uint64_t frame = 0; frame < 3; ++frame) {
        const View view = camera(frame);
        culler->cull(view, device);
        const std::set<ItemId> in_image(culler->drawn_items().begin(), culler->drawn_items().end());
        for (const ItemId item : tree_.items()) {
            const Aabb& box = boxes_[item.value].box;
            const ScreenBounds bounds = project(view, box);
            const bool can_be_seen = view.frustum().classify(box) != Containment::outside &&
                                     (!bounds.valid || bounds.rect.width > 0);
            ASSERT_TRUE(in_image.contains(item) || !can_be_seen) << "item " << item.value;
        }
    }
}

TEST_P(DepthInvariants, ADegenerateViewCullsNothing)
{
    ScriptedDevice device;
    device.script() = script(device);
    for (const glm::ivec2 size : {glm::ivec2{64, 64}, glm::ivec2{0, 64}}) {
        const auto culler = make();
        culler->cull(View::from_clip(glm::mat4{0.0f}, size), device);
        EXPECT_EQ(culler->drawn_items().size(), tree_.items().size());
    }
}

TEST_P(DepthInvariants, OddHierarchiesAreHarmless)
{
    std::vector<ItemBounds> odd = test::random_boxes(40, 5);
    odd[3].box.min.x = std::numeric_limits<float>::quiet_NaN();
    odd[4].box = Aabb::everything();
    odd[5].box = Aabb::empty();
    odd[6].box.max = odd[6].box.min; // a point
    for (const std::vector<ItemBounds>& items :
         {odd, std::vector<ItemBounds>{odd[4]}, std::vector<ItemBounds>{odd[5]},
          std::vector<ItemBounds>{}}) {
        const Hierarchy tree = kind_.build(items, 300);
        DeviceScript all_near;
        all_near.caps.read_depth = true;
        all_near.depth = [](const PixelRect&, std::span<float> out) {
            std::fill(out.begin(), out.end(), 0.0f);
            return true;
        };
        ScriptedDevice device(all_near);
        const auto culler = make(tree);
        for (uint64_t frame = 0; frame < 3; ++frame) {
            culler->cull(camera(frame), device);
        }
        const std::set<ItemId> drawn(culler->drawn_items().begin(), culler->drawn_items().end());
        if (items.size() == odd.size()) {
            EXPECT_TRUE(drawn.contains(ItemId{3u})); // unknown and unbounded boxes are always drawn
            EXPECT_TRUE(drawn.contains(ItemId{4u}));
            EXPECT_FALSE(drawn.contains(ItemId{5u}));
        }
    }
}

TEST_P(DepthInvariants, EqualFramesAreCulledEqually)
{
    ScriptedDevice device;
    device.script() = script(device);
    const auto culler = make();
    view_ = camera(3);
    culler->cull(view_, device);
    for (uint64_t frame = 4; frame < 9; ++frame) {
        view_ = camera(frame);
        culler->cull(view_, device);
    }
    culler->reset();
    view_ = camera(3);
    culler->cull(view_, device);
    EXPECT_EQ(device.frame_text(0), device.frame_text(6));
}

// A new algorithm without a line above would be free to break them.
TEST(DepthInvariantsCases, HoldEveryExactAlgorithmThatReadsDepth)
{
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.needs.depth_read && info.exact && !info.needs.visible_set) {
            EXPECT_TRUE(std::ranges::any_of(cases(), [&](const Case& c) {
                return c.algorithm == info.name;
            })) << info.name;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Cull, DepthInvariants, ::testing::ValuesIn(all_cases()), name_of);

} // namespace
} // namespace occlude
