#include "generate/hollow_generators.h"
#include "tools/scene_checks.h"
#include "walk/paths.h"

#include <array>

namespace occlude::tools {
namespace {

using namespace test;

TEST(Hollow, HasTheObjectsAndTrianglesAskedFor)
{
    const SceneModel pyramids = loaded("pyramids:count=90,triangles=300");
    EXPECT_EQ(pyramids.instances.size(), 91u); // and the plain
    EXPECT_EQ(drawn_triangles(pyramids), 90u * 256u + 12u);
    const SceneModel rings = loaded("rings:count=90,triangles=256");
    EXPECT_EQ(rings.instances.size(), 91u);
    EXPECT_EQ(drawn_triangles(rings), 90u * 256u + 12u);
}

TEST(Hollow, IsTheSameOnEveryMachineAndFollowsItsSeed)
{
    const uint64_t pyramids = hash_of(loaded("pyramids:count=90,seed=3"));
    const uint64_t rings = hash_of(loaded("rings:count=90,seed=3"));
    EXPECT_EQ(pyramids, 4479103862247404542u);
    EXPECT_EQ(rings, 4188227300041207758u);
    EXPECT_NE(pyramids, hash_of(loaded("pyramids:count=90,seed=4")));
    EXPECT_NE(rings, hash_of(loaded("rings:count=90,seed=4")));
}

TEST(Hollow, IsSoundAndItsPathsAreFree)
{
    for (const char* source : {"pyramids:count=60,triangles=100", "rings:count=60,triangles=2k"}) {
        const SceneModel model = loaded(source);
        expect_sound(model);
        expect_free_and_smooth(model, "pass", 1.0f);
    }
}

/// The share of the items in the frustum of the path's middle camera whose boxes are visible
/// against the depth of the finished frame. With a perfect test of the objects themselves it is 1 -
/// hidden_share.
double share_of_boxes_seen(const SceneModel& model, const std::string& path)
{
    constexpr glm::ivec2 kSize{320, 180};
    auto cameras = load_path(path, model, 3);
    choose_depth_range(*cameras, model);
    const CullScene scene = make_cull_scene(model);
    auto renderer = std::move(*make_cpu_renderer(model, scene.items, kSize));
    const View view = make_view(cameras->at(1), kSize);
    const std::vector<ItemId> items = items_in_frustum(view, scene.scene.item_bounds());
    size_t seen = 0;
    QueryDevice& device = renderer->device();
    device.begin_frame(view);
    device.draw(items, DrawPass::shade);
    for (const ItemId item : items) {
        QueryBox box;
        box.box = view.inflated_for_test(scene.scene.item_bounds()[item.value].box);
        const std::array<uint32_t, 1> ends{1};
        std::array<Ticket, 1> tickets;
        QueryBatch batch;
        batch.boxes = std::span{&box, 1};
        batch.test_ends = ends;
        device.query(batch, tickets);
        seen += view.touches_near(box.box) || device.wait(tickets[0]).samples > 0;
    }
    device.end_frame();
    return static_cast<double>(seen) / static_cast<double>(items.size());
}

TEST(Hollow, BoxesAreSeenWhereTheirContentsAreHidden)
{
    for (const char* source : {"pyramids:count=400,triangles=36", "rings:count=400,triangles=64"}) {
        const SceneModel model = loaded(source);
        const double hidden = hidden_share(model, "pass", 3);
        const double boxes = share_of_boxes_seen(model, "pass");
        EXPECT_GT(hidden, 0.3) << source;
        EXPECT_LT(hidden, 0.95) << source;
        EXPECT_GT(boxes, 1.1 * (1.0 - hidden)) << source;
    }
}

} // namespace
} // namespace occlude::tools
