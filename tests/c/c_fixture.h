// A device, a hierarchy and a culler through the C interface.
#pragma once

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/c/occlude.h>

#include "support/box_scene.h"
#include "support/walks.h"

#include <glm/gtc/type_ptr.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace occlude {

/// The CPU device behind C callbacks.
class DeviceInC {
public:
    explicit DeviceInC(const CpuScene& scene)
        : device_(scene)
    {
        functions.struct_size = sizeof functions;
        functions.user = this;
        functions.same_frame_results = 1;
        for (const TestCost& cost : device_.caps().methods) {
            methods_.push_back({static_cast<uint32_t>(cost.method), cost.exact_counts,
                                cost.us_per_batch, cost.us_per_test, cost.us_per_box});
        }
        functions.methods = methods_.data();
        functions.method_count = static_cast<uint32_t>(methods_.size());
        functions.us_per_triangle = device_.caps().us_per_triangle;
        functions.us_per_item = device_.caps().us_per_item;
        functions.samples_at_pixel_centers = device_.caps().samples_at_pixel_centers;
        functions.max_outstanding = device_.caps().max_outstanding;
        functions.begin_frame = [](void* user, const occlude_view* view) {
            DeviceInC& self = of(user);
            self.seen = *view;
            self.view_ = View::from_clip(glm::make_mat4(view->clip_from_world),
                                         {view->width_px, view->height_px});
            self.device_.begin_frame(self.view_);
        };
        functions.draw = [](void* user, const uint32_t* items, size_t count, uint32_t pass) {
            of(user).device_.draw(ids(items, count), static_cast<DrawPass>(pass));
        };
        functions.query = &query;
        functions.flush = [](void* user) { of(user).device_.flush(); };
        functions.poll = [](void* user, occlude_ticket ticket) {
            return in_c(of(user).device_.poll({ticket.index, ticket.generation}));
        };
        functions.wait = [](void* user, occlude_ticket ticket) {
            return in_c(of(user).device_.wait({ticket.index, ticket.generation}));
        };
        functions.draw_and_query = [](void* user, const uint32_t* items, size_t count,
                                      uint32_t pass) {
            const Ticket ticket =
                of(user).device_.draw_and_query(ids(items, count), static_cast<DrawPass>(pass));
            return occlude_ticket{ticket.index, ticket.generation};
        };
        functions.end_frame = [](void* user) { of(user).device_.end_frame(); };
        functions.read_depth = [](void* user, int32_t x, int32_t y, int32_t width, int32_t height,
                                  float* out) {
            const PixelRect rect{x, y, width, height};
            const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
            return of(user).device_.read_depth(rect, {out, count}) ? 1 : 0;
        };
        for (const DepthReadCost& cost : device_.caps().depth_reads) {
            depth_reads_.push_back(
                {cost.tile_px, cost.us_per_read, cost.us_per_pixel, cost.us_per_value});
        }
        functions.depth_reads = depth_reads_.data();
        functions.depth_read_count = depth_reads_.size();
        functions.read_depth_tiles = [](void* user, int32_t tile_px, float* out, size_t count) {
            ++of(user).tile_reads;
            return of(user).device_.read_depth_tiles(tile_px, {out, count}) ? 1 : 0;
        };
    }

    occlude_device functions{};
    occlude_view seen{}; ///< by begin_frame
    int tile_reads = 0;

private:
    static DeviceInC& of(void* user) { return *static_cast<DeviceInC*>(user); }

    static std::vector<ItemId> ids(const uint32_t* items, size_t count)
    {
        std::vector<ItemId> result;
        for (size_t i = 0; i < count; ++i) {
            result.push_back(ItemId{items[i]});
        }
        return result;
    }

    static occlude_answer in_c(const Answer& answer)
    {
        return {static_cast<uint32_t>(answer.state), answer.samples};
    }

    static void query(void* user, const occlude_query_batch* batch, occlude_ticket* tickets)
    {
        std::vector<glm::mat4> matrices(batch->box_count);
        std::vector<QueryBox> boxes;
        for (size_t i = 0; i < batch->box_count; ++i) {
            const occlude_query_box& box = batch->boxes[i];
            if (box.world_from_box != nullptr) {
                matrices[i] = glm::make_mat4(box.world_from_box);
            }
            boxes.push_back({{glm::make_vec3(box.min), glm::make_vec3(box.max)},
                             box.world_from_box != nullptr ? &matrices[i] : nullptr,
                             NodeId{box.node}});
        }
        std::vector<Ticket> given(batch->test_count);
        of(user).device_.query(
            {boxes, {batch->test_ends, batch->test_count}, static_cast<TestMethod>(batch->method)},
            given);
        for (size_t i = 0; i < given.size(); ++i) {
            tickets[i] = {given[i].index, given[i].generation};
        }
    }

    CpuDevice device_;
    View view_;
    std::vector<occlude_test_cost> methods_;
    std::vector<occlude_depth_read_cost> depth_reads_;
};

inline occlude_view in_c(const View& view)
{
    occlude_view result{};
    result.struct_size = sizeof result;
    std::copy_n(glm::value_ptr(view.clip_from_world()), 16, result.clip_from_world);
    result.width_px = view.size_px().x;
    result.height_px = view.size_px().y;
    return result;
}

inline std::vector<occlude_item> in_c(std::span<const ItemBounds> bounds)
{
    std::vector<occlude_item> items;
    for (const ItemBounds& item : bounds) {
        items.push_back({{item.box.min.x, item.box.min.y, item.box.min.z},
                         {item.box.max.x, item.box.max.y, item.box.max.z},
                         item.triangles,
                         static_cast<uint32_t>(item.flags)});
    }
    return items;
}

/// Creates a hierarchy through C, and destroys it at the end.
struct HierarchyInC {
    explicit HierarchyInC(std::span<const occlude_item> items, const char* kind = "bvh",
                          uint32_t leaf_triangles = 24)
    {
        EXPECT_EQ(occlude_hierarchy_create(kind, items.data(), items.size(), leaf_triangles,
                                           nullptr, 0, &tree),
                  OCCLUDE_OK)
            << occlude_last_error();
    }
    ~HierarchyInC() { occlude_hierarchy_destroy(tree); }

    occlude_hierarchy* tree = nullptr;
};

struct CullerInC {
    CullerInC(const std::string& name, const HierarchyInC& hierarchy,
              const std::vector<occlude_option>& options = {})
    {
        EXPECT_EQ(occlude_culler_create(name.c_str(), hierarchy.tree, options.data(),
                                        options.size(), nullptr, nullptr, &culler),
                  OCCLUDE_OK)
            << occlude_last_error();
    }
    ~CullerInC() { occlude_culler_destroy(culler); }

    std::vector<uint32_t> drawn() const
    {
        const uint32_t* items = nullptr;
        const size_t count = occlude_culler_drawn_items(culler, &items);
        return {items, items + count};
    }

    occlude_culler* culler = nullptr;
};

} // namespace occlude
