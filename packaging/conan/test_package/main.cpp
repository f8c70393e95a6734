// A program of somebody else's: two walls, one behind the other, and what the library makes of them.
#include <occlude/cull/registry.h>
#include <occlude/device/handed_depth_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <cstdio>

int main()
{
    const std::vector<occlude::ItemBounds> items{{{{-1, -1, -0.5f}, {1, 1, -0.4f}}, 100},
                                                 {{{-1, -1, 0.5f}, {1, 1, 0.6f}}, 100}};
    const occlude::Hierarchy tree =
        occlude::build_bvh(items, {.max_leaf_items = 1, .leaf_triangles = 0});
    auto culler = occlude::make_culler("stop_and_wait", tree);
    occlude::HandedDepthDevice device;
    const std::vector<float> depth(16 * 16, 0.5f); // behind the first wall, before the second
    device.hand_over({16, 16}, depth);
    (*culler)->cull(occlude::View::from_clip(glm::mat4{1.0f}, {16, 16}), device);
    std::printf("%zu of 2 walls are visible\n", (*culler)->drawn_items().size());
    return (*culler)->drawn_items().size() == 1 ? 0 : 1;
}
