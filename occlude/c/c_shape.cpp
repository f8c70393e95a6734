#include <occlude/c/detail/guard.h>
#include <occlude/c/detail/handles.h>

#include <occlude/scene/tight_boxes.h>

#include <glm/gtc/type_ptr.hpp>

#include <cmath>
#include <memory>

namespace occlude::c {

namespace {

occlude_status keep(Shape boxes, occlude_shape** shape)
{
    auto made = std::make_unique<occlude_shape>();
    for (const Aabb& box : boxes) {
        made->boxes_in_c.push_back(
            {{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}});
    }
    made->boxes = std::make_shared<const Shape>(std::move(boxes));
    *shape = made.release();
    return OCCLUDE_OK;
}

// "" for a matrix that can place a shape.
std::string matrix_problem(const float* matrix)
{
    if (matrix == nullptr) {
        return "world_from_shape is null";
    }
    for (int i = 0; i < 16; ++i) {
        if (!std::isfinite(matrix[i])) {
            return "world_from_shape[" + std::to_string(i) + "] is not finite";
        }
    }
    if (matrix[3] != 0.0f || matrix[7] != 0.0f || matrix[11] != 0.0f || matrix[15] != 1.0f) {
        return "world_from_shape is not affine: its last row is not 0, 0, 0, 1; matrices are "
               "column-major";
    }
    return {};
}

} // namespace

} // namespace occlude::c

using namespace occlude;

extern "C" {

occlude_status occlude_shape_from_triangles(const float* positions, size_t position_count,
                                            const uint32_t* indices, size_t index_count,
                                            uint32_t most_boxes, occlude_shape** shape)
{
    return c::guarded([&] {
        if (shape == nullptr || (positions == nullptr && position_count > 0) ||
            (indices == nullptr && index_count > 0)) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "positions, indices or shape is null");
        }
        if (index_count % 3 != 0) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "index_count is " +
                                                         std::to_string(index_count) +
                                                         ", which is not 3 per triangle");
        }
        for (size_t i = 0; i < index_count; ++i) {
            if (indices[i] >= position_count) {
                return c::fail(OCCLUDE_INVALID_ARGUMENT,
                               "indices[" + std::to_string(i) + "] is " +
                                   std::to_string(indices[i]) + ", but there are " +
                                   std::to_string(position_count) + " positions");
            }
        }
        std::vector<glm::vec3> points;
        points.reserve(position_count);
        for (size_t i = 0; i < position_count; ++i) {
            points.push_back(glm::make_vec3(positions + 3 * i));
        }
        return c::keep(tight_boxes(points, {indices, index_count}, most_boxes), shape);
    });
}

occlude_status occlude_shape_from_boxes(const occlude_box* boxes, size_t box_count,
                                        occlude_shape** shape)
{
    return c::guarded([&] {
        if (shape == nullptr || (boxes == nullptr && box_count > 0)) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "boxes or shape is null");
        }
        Shape copied;
        copied.reserve(box_count);
        for (size_t i = 0; i < box_count; ++i) {
            copied.push_back({glm::make_vec3(boxes[i].min), glm::make_vec3(boxes[i].max)});
            if (copied.back().is_empty()) {
                return c::fail(OCCLUDE_INVALID_ARGUMENT,
                               "boxes[" + std::to_string(i) + "] is empty: min > max");
            }
        }
        return c::keep(std::move(copied), shape);
    });
}

void occlude_shape_destroy(occlude_shape* shape)
{
    delete shape;
}

size_t occlude_shape_boxes(const occlude_shape* shape, const occlude_box** boxes)
{
    if (boxes != nullptr) {
        *boxes = shape != nullptr ? shape->boxes_in_c.data() : nullptr;
    }
    return shape != nullptr ? shape->boxes_in_c.size() : 0;
}

occlude_status occlude_hierarchy_place_shape(occlude_hierarchy* hierarchy, uint32_t item,
                                             const occlude_shape* shape,
                                             const float* world_from_shape)
{
    return c::guarded([&] {
        if (hierarchy == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "hierarchy is null");
        }
        if (item >= hierarchy->item_count) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "there is no item " + std::to_string(item) +
                                                         ": the hierarchy was made of " +
                                                         std::to_string(hierarchy->item_count) +
                                                         " items");
        }
        if (shape == nullptr) {
            hierarchy->shapes.remove(ItemId{item});
            return OCCLUDE_OK;
        }
        if (std::string problem = c::matrix_problem(world_from_shape); !problem.empty()) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, std::move(problem));
        }
        hierarchy->shapes.place(ItemId{item}, shape->boxes, glm::make_mat4(world_from_shape));
        return OCCLUDE_OK;
    });
}

} // extern "C"
