/* Software occlusion culling by itself, in C: rasterise meshes that hide things on the CPU, and ask
 * of boxes whether something of them can be seen. No graphics card, hierarchy or device is needed.
 * occlude/c/occlude.h says what holds for all of these functions; docs/occluders.md says what may
 * be an occluder.
 *
 *     occlude_occluder_buffer_begin(buffer, &view);
 *     occlude_occluder_buffer_add(buffer, house, world_from_house);
 *     occlude_occluder_buffer_rasterize(buffer);
 *     occlude_occluder_buffer_test_boxes(buffer, boxes, box_count, results);
 */
#ifndef OCCLUDE_C_OCCLUDERS_H
#define OCCLUDE_C_OCCLUDERS_H

#include <occlude/c/occlude.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- meshes ---- */

typedef struct occlude_occluder_mesh occlude_occluder_mesh;

/* Which sides of its triangles the engine draws. */
enum {
    OCCLUDE_FACES_BOTH = 0,             /* both, or not known */
    OCCLUDE_FACES_COUNTERCLOCKWISE = 1, /* those whose corners run counter-clockwise, as in glTF */
    OCCLUDE_FACES_CLOCKWISE = 2
};

/* Triangles, as the engine draws them. */
typedef struct occlude_mesh_data {
    size_t struct_size;
    const void* positions; /* three floats each, of any alignment */
    size_t position_count;
    size_t stride_bytes; /* from one position to the next; 0: 12 */
    const void* indices; /* three per triangle */
    size_t index_count;
    uint32_t index_bytes;      /* 2 or 4 */
    uint32_t faces;            /* OCCLUDE_FACES_* */
    uint32_t positions_change; /* 1: set_positions will be called, so that vertices at the same
                                  position are not taken for one */
} occlude_mesh_data;

/* Prepares a mesh; the data may go afterwards. Triangles with an index that has no position, with a
 * position that is not finite or with two equal corners are left out. About 1 us per triangle. */
OCCLUDE_C_API occlude_status occlude_occluder_mesh_create(const occlude_mesh_data* data,
                                                          occlude_occluder_mesh** mesh);
OCCLUDE_C_API void occlude_occluder_mesh_destroy(occlude_occluder_mesh* mesh);

/* New positions of the same vertices. OCCLUDE_UNSUPPORTED, and nothing changes, if the mesh was not
 * made with positions_change, or if there are too few of them. */
OCCLUDE_C_API occlude_status occlude_occluder_mesh_set_positions(occlude_occluder_mesh* mesh,
                                                                 const void* positions,
                                                                 size_t position_count,
                                                                 size_t stride_bytes);

/* ---- the buffer ---- */

typedef struct occlude_occluder_buffer occlude_occluder_buffer;

typedef struct occlude_occluder_options {
    size_t struct_size;
    uint32_t cell_px; /* side of a cell in pixels of the view, 1 to 16; 0: 2 */
    uint32_t threads; /* that rasterise; 0: the caller's alone */
} occlude_occluder_options;

enum {
    OCCLUDE_BOX_VISIBLE = 0, /* something of it may be seen; also whatever is not known */
    OCCLUDE_BOX_HIDDEN = 1,  /* it is behind the occluders */
    OCCLUDE_BOX_OUTSIDE = 2  /* it is outside of the view */
};

/* `options` may be null. */
OCCLUDE_C_API occlude_status occlude_occluder_buffer_create(const occlude_occluder_options* options,
                                                            occlude_occluder_buffer** buffer);
OCCLUDE_C_API void occlude_occluder_buffer_destroy(occlude_occluder_buffer* buffer);

/* Starts a frame: nothing hides anything. The view is the one that the renderer draws with. */
OCCLUDE_C_API occlude_status occlude_occluder_buffer_begin(occlude_occluder_buffer* buffer,
                                                           const occlude_view* view);

/* Adds an instance of a mesh, which must stay until rasterize. Only what the renderer draws in this
 * frame, opaque and with depth, may be added; it may be drawn later. */
OCCLUDE_C_API occlude_status occlude_occluder_buffer_add(occlude_occluder_buffer* buffer,
                                                         const occlude_occluder_mesh* mesh,
                                                         const float world_from_mesh[16]);

/* From now on tests see what was added. */
OCCLUDE_C_API occlude_status occlude_occluder_buffer_rasterize(occlude_occluder_buffer* buffer);

/* Tests boxes in world space, six floats each: the least x, y and z, then the largest. Writes one
 * OCCLUDE_BOX_* per box. Several threads may test at one time. */
OCCLUDE_C_API occlude_status occlude_occluder_buffer_test_boxes(
    const occlude_occluder_buffer* buffer, const float* boxes, size_t box_count, uint8_t* results);

/* Tests pixels of the view, of which something shows at window depth `nearest` or beyond. */
OCCLUDE_C_API occlude_status occlude_occluder_buffer_test_rectangle(
    const occlude_occluder_buffer* buffer, int32_t x, int32_t y, int32_t width, int32_t height,
    float nearest, uint8_t* result);

#ifdef __cplusplus
}
#endif

#endif
