#include <occlude/c/detail/guard.h>
#include <occlude/c/occluders.h>

#include <occlude/backends/cpu_fast/occluder_buffer.h>

#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <memory>
#include <span>
#include <utility>

struct occlude_occluder_mesh {
    occlude::OccluderMesh mesh;
};

struct occlude_occluder_buffer {
    explicit occlude_occluder_buffer(const occlude::OccluderBufferOptions& options)
        : buffer(options)
    {
    }
    occlude::OccluderBuffer buffer;
};

namespace occlude::c {

namespace {

static_assert(OCCLUDE_BOX_VISIBLE == static_cast<int>(Visibility::visible));
static_assert(OCCLUDE_BOX_HIDDEN == static_cast<int>(Visibility::hidden));
static_assert(OCCLUDE_BOX_OUTSIDE == static_cast<int>(Visibility::outside));
static_assert(OCCLUDE_FACES_BOTH == static_cast<int>(MeshFaces::both));
static_assert(OCCLUDE_FACES_COUNTERCLOCKWISE == static_cast<int>(MeshFaces::counterclockwise));
static_assert(OCCLUDE_FACES_CLOCKWISE == static_cast<int>(MeshFaces::clockwise));

constexpr size_t kBoxesAtOnce = 256;

PositionStream stream_of(const void* positions, size_t count, size_t stride_bytes)
{
    return {positions, count, stride_bytes == 0 ? sizeof(glm::vec3) : stride_bytes};
}

// The sentence about what is wrong with the data; empty if nothing is.
std::string error_in(const occlude_mesh_data& data)
{
    if (data.positions == nullptr && data.position_count > 0) {
        return "positions is null, but position_count is " + std::to_string(data.position_count);
    }
    if (data.indices == nullptr && data.index_count > 0) {
        return "indices is null, but index_count is " + std::to_string(data.index_count);
    }
    if (data.index_bytes != 2 && data.index_bytes != 4) {
        return "index_bytes is " + std::to_string(data.index_bytes) + "; it must be 2 or 4";
    }
    if (data.faces > OCCLUDE_FACES_CLOCKWISE) {
        return "faces is " + std::to_string(data.faces) + "; the largest value is 2";
    }
    return {};
}

OccluderMesh prepared(const occlude_mesh_data& data)
{
    const PositionStream positions =
        stream_of(data.positions, data.position_count, data.stride_bytes);
    const OccluderMeshOptions options{
        .welding = data.positions_change != 0 ? MeshWelding::by_index : MeshWelding::by_position,
        .faces = static_cast<MeshFaces>(data.faces)};
    if (data.index_bytes == 2) {
        return OccluderMesh::prepare(
            positions, std::span{static_cast<const uint16_t*>(data.indices), data.index_count},
            options);
    }
    return OccluderMesh::prepare(
        positions, std::span{static_cast<const uint32_t*>(data.indices), data.index_count},
        options);
}

} // namespace

} // namespace occlude::c

using namespace occlude;

extern "C" {

occlude_status occlude_occluder_mesh_create(const occlude_mesh_data* data,
                                            occlude_occluder_mesh** mesh)
{
    return c::guarded([&] {
        if (data == nullptr || mesh == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "data or mesh is null");
        }
        const occlude_mesh_data all = c::all_members(*data);
        if (std::string error = c::error_in(all); !error.empty()) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, std::move(error));
        }
        *mesh = std::make_unique<occlude_occluder_mesh>(occlude_occluder_mesh{c::prepared(all)})
                    .release();
        return OCCLUDE_OK;
    });
}

void occlude_occluder_mesh_destroy(occlude_occluder_mesh* mesh)
{
    delete mesh;
}

occlude_status occlude_occluder_mesh_set_positions(occlude_occluder_mesh* mesh,
                                                   const void* positions, size_t position_count,
                                                   size_t stride_bytes)
{
    return c::guarded([&] {
        if (mesh == nullptr || positions == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "mesh or positions is null");
        }
        if (!mesh->mesh.set_positions(c::stream_of(positions, position_count, stride_bytes))) {
            return c::fail(OCCLUDE_UNSUPPORTED,
                           "the mesh was made without positions_change, or there are too few "
                           "positions for its indices");
        }
        return OCCLUDE_OK;
    });
}

occlude_status occlude_occluder_buffer_create(const occlude_occluder_options* options,
                                              occlude_occluder_buffer** buffer)
{
    return c::guarded([&] {
        if (buffer == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "buffer is null");
        }
        OccluderBufferOptions all;
        if (options != nullptr) {
            const occlude_occluder_options given = c::all_members(*options);
            all.cell_px = given.cell_px == 0
                              ? all.cell_px
                              : static_cast<int>(std::min<uint32_t>(given.cell_px, 16));
            all.threads = std::max(static_cast<int>(std::min<uint32_t>(given.threads, 1024)), 1);
        }
        *buffer = std::make_unique<occlude_occluder_buffer>(all).release();
        return OCCLUDE_OK;
    });
}

void occlude_occluder_buffer_destroy(occlude_occluder_buffer* buffer)
{
    delete buffer;
}

occlude_status occlude_occluder_buffer_begin(occlude_occluder_buffer* buffer,
                                             const occlude_view* view)
{
    return c::guarded([&] {
        if (buffer == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "buffer is null");
        }
        const Result<View> camera = c::view_from(view);
        if (!camera) {
            return c::fail(camera.error());
        }
        buffer->buffer.begin(*camera);
        return OCCLUDE_OK;
    });
}

occlude_status occlude_occluder_buffer_add(occlude_occluder_buffer* buffer,
                                           const occlude_occluder_mesh* mesh,
                                           const float world_from_mesh[16])
{
    return c::guarded([&] {
        if (buffer == nullptr || mesh == nullptr || world_from_mesh == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "buffer, mesh or world_from_mesh is null");
        }
        buffer->buffer.add(mesh->mesh, glm::make_mat4(world_from_mesh));
        return OCCLUDE_OK;
    });
}

occlude_status occlude_occluder_buffer_rasterize(occlude_occluder_buffer* buffer)
{
    return c::guarded([&] {
        if (buffer == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "buffer is null");
        }
        buffer->buffer.rasterize();
        return OCCLUDE_OK;
    });
}

occlude_status occlude_occluder_buffer_test_boxes(const occlude_occluder_buffer* buffer,
                                                  const float* boxes, size_t box_count,
                                                  uint8_t* results)
{
    return c::guarded([&] {
        if (buffer == nullptr || (box_count > 0 && (boxes == nullptr || results == nullptr))) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "buffer, boxes or results is null");
        }
        std::array<Aabb, c::kBoxesAtOnce> some;
        std::array<Visibility, c::kBoxesAtOnce> found;
        for (size_t first = 0; first < box_count; first += c::kBoxesAtOnce) {
            const size_t count = std::min(c::kBoxesAtOnce, box_count - first);
            for (size_t i = 0; i < count; ++i) {
                const float* box = boxes + 6 * (first + i);
                some[i] = {glm::make_vec3(box), glm::make_vec3(box + 3)};
            }
            buffer->buffer.test(std::span{some}.first(count), std::span{found}.first(count));
            for (size_t i = 0; i < count; ++i) {
                results[first + i] = static_cast<uint8_t>(found[i]);
            }
        }
        return OCCLUDE_OK;
    });
}

occlude_status occlude_occluder_buffer_test_rectangle(const occlude_occluder_buffer* buffer,
                                                      int32_t x, int32_t y, int32_t width,
                                                      int32_t height, float nearest,
                                                      uint8_t* result)
{
    return c::guarded([&] {
        if (buffer == nullptr || result == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "buffer or result is null");
        }
        *result = static_cast<uint8_t>(buffer->buffer.test({x, y, width, height}, nearest));
        return OCCLUDE_OK;
    });
}

} // extern "C"
