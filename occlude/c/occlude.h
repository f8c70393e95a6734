/* occlude in C: hierarchies, cullers, and devices as a table of functions. Bindings are made on
 * this.
 *
 * Ownership. What a `create` function gives must be given back to the matching `destroy` function.
 * A hierarchy must outlive its cullers. Memory that a function returns belongs to the object that
 * was asked, and stays valid until the function's comment says.
 *
 * Errors. A function that can fail returns an occlude_status. OCCLUDE_OK is 0. The sentence behind
 * another status is occlude_last_error(), of the calling thread. No function throws, prints or ends
 * the process. Null where an object is needed is OCCLUDE_INVALID_ARGUMENT.
 *
 * Threads. Different cullers may run in different threads on different devices, over one hierarchy
 * that nobody changes meanwhile. One culler, one device and one hierarchy under change belong to
 * one thread at a time.
 *
 * Versions. Each struct that the caller fills begins with struct_size = sizeof(the struct). A later
 * version only adds members at the end, so a program built against this header works with every
 * later libocclude of the same major number. Members beyond struct_size count as 0.
 *
 * Spaces. Boxes are in world space. Matrices are column-major, as in OpenGL: clip = matrix * world.
 * Pixels count from the lower left. Window depth is 0 (near) to 1 (far) in every convention.
 */
#ifndef OCCLUDE_C_OCCLUDE_H
#define OCCLUDE_C_OCCLUDE_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#if defined(OCCLUDE_C_BUILD)
#define OCCLUDE_C_API __declspec(dllexport)
#else
#define OCCLUDE_C_API __declspec(dllimport)
#endif
#else
#define OCCLUDE_C_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The interface of this header: grows when members or functions are added. */
#define OCCLUDE_C_ABI_VERSION 3u

/* ---- library ---- */

/* "0.1.0". */
OCCLUDE_C_API const char* occlude_version(void);

/* OCCLUDE_C_ABI_VERSION of the library that is loaded: at least the one of the header. */
OCCLUDE_C_API uint32_t occlude_abi_version(void);

typedef enum occlude_status {
    OCCLUDE_OK = 0,
    OCCLUDE_INVALID_ARGUMENT = 1, /* the caller asked for something that has no meaning */
    OCCLUDE_NOT_FOUND = 2,        /* there is no algorithm, kind or option of that name */
    OCCLUDE_BAD_DATA = 3,         /* it exists but is broken */
    OCCLUDE_UNSUPPORTED = 4,      /* this build or this object cannot do it */
    OCCLUDE_DEVICE_FAILED = 5,    /* a callback of the device failed */
    OCCLUDE_OUT_OF_MEMORY = 6
} occlude_status;

/* The sentence behind the last status of this thread that was not OCCLUDE_OK; "" if there was none.
 * Valid until the next call of this thread. */
OCCLUDE_C_API const char* occlude_last_error(void);

/* An option by name, as `occlude list algorithms` shows it: {"threshold", "20"}. */
typedef struct occlude_option {
    const char* name;
    const char* value;
} occlude_option;

/* ---- hierarchies ---- */

typedef struct occlude_hierarchy occlude_hierarchy;

/* How an item takes part in culling; combined with |. */
enum {
    OCCLUDE_ITEM_NEVER_CULL = 1,    /* always drawn, first of all; unless its box is empty */
    OCCLUDE_ITEM_NEVER_OCCLUDE = 2, /* drawn after all tests: hides nothing */
    OCCLUDE_ITEM_TRANSLUCENT = 4,   /* hides nothing, drawn last, back to front */
    OCCLUDE_ITEM_ALPHA_TESTED = 8   /* hides what it covers */
};

/* What one draw draws. Its id is its index in the array that is handed over. */
typedef struct occlude_item {
    float min[3]; /* world space; a box with min > max is empty, and never drawn */
    float max[3];
    uint32_t triangles;
    uint32_t flags;
} occlude_item;

/* Builds a tree of the kind "bvh", "bsp", "octree", "grid" or "two_level" over `items`. Nodes of at
 * most `leaf_triangles` triangles are tested as a whole; 1024 is a good value, 0 means each leaf by
 * itself. The items are copied. O(n log n). */
OCCLUDE_C_API occlude_status occlude_hierarchy_create(const char* kind, const occlude_item* items,
                                                      size_t item_count, uint32_t leaf_triangles,
                                                      const occlude_option* options,
                                                      size_t option_count,
                                                      occlude_hierarchy** hierarchy);
OCCLUDE_C_API void occlude_hierarchy_destroy(occlude_hierarchy* hierarchy);

/* Takes new bounds of all items, by id, and keeps the structure. item_count must be that of create.
 * O(items). */
OCCLUDE_C_API occlude_status occlude_hierarchy_refit(occlude_hierarchy* hierarchy,
                                                     const occlude_item* items, size_t item_count);

/* The same where only the items in `moved` (ids) have changed. `items` holds all items, by id. */
OCCLUDE_C_API occlude_status occlude_hierarchy_refit_moved(occlude_hierarchy* hierarchy,
                                                           const uint32_t* moved,
                                                           size_t moved_count,
                                                           const occlude_item* items,
                                                           size_t item_count);

OCCLUDE_C_API size_t occlude_hierarchy_node_count(const occlude_hierarchy* hierarchy);
OCCLUDE_C_API size_t occlude_hierarchy_item_count(const occlude_hierarchy* hierarchy);
OCCLUDE_C_API size_t occlude_hierarchy_memory_bytes(const occlude_hierarchy* hierarchy);

/* ---- shapes (since version 3) ---- */

/* A few boxes that together hold every triangle of a mesh, in the space of the mesh: for what
 * leaves most of its own box empty. "two_phase" and "adaptive" hide more with them. */
typedef struct occlude_shape occlude_shape;

typedef struct occlude_box {
    float min[3];
    float max[3];
} occlude_box;

/* At most `most_boxes` boxes around the triangles: 3 floats per position, 3 indices per triangle.
 * 16 boxes are a good number for some thousand triangles. Copies what it needs. */
OCCLUDE_C_API occlude_status occlude_shape_from_triangles(const float* positions,
                                                          size_t position_count,
                                                          const uint32_t* indices,
                                                          size_t index_count, uint32_t most_boxes,
                                                          occlude_shape** shape);
/* These boxes, copied. */
OCCLUDE_C_API occlude_status occlude_shape_from_boxes(const occlude_box* boxes, size_t box_count,
                                                      occlude_shape** shape);
/* Items that have the shape keep it. */
OCCLUDE_C_API void occlude_shape_destroy(occlude_shape* shape);

/* The boxes of a shape, the largest first, valid as long as it. Returns their number; `boxes` may
 * be null. */
OCCLUDE_C_API size_t occlude_shape_boxes(const occlude_shape* shape, const occlude_box** boxes);

/* Gives an item a shape, or moves the one that it has; null takes it away. `world_from_shape` is
 * column-major and affine. Call it with every refit that moves the item, or parts of it are missing
 * in the image. Not while a culler works. */
OCCLUDE_C_API occlude_status occlude_hierarchy_place_shape(occlude_hierarchy* hierarchy,
                                                           uint32_t item,
                                                           const occlude_shape* shape,
                                                           const float* world_from_shape);

/* ---- views ---- */

enum {
    OCCLUDE_DEPTH_MINUS_ONE_TO_ONE = 0, /* clip depth of OpenGL without clip control */
    OCCLUDE_DEPTH_ZERO_TO_ONE = 1
};
enum {
    OCCLUDE_NEAR_IS_SMALL = 0, /* tested with LESS */
    OCCLUDE_NEAR_IS_LARGE = 1  /* reverse Z: tested with GREATER */
};

/* One camera in one frame: the matrix that draws, and the size of its viewport in pixels. */
typedef struct occlude_view {
    size_t struct_size;
    float clip_from_world[16];
    int32_t width_px;
    int32_t height_px;
    uint32_t depth_range;
    uint32_t depth_order;
    /* since version 2 */
    int32_t viewport_x_px; /* the lower left pixel of the viewport in the target */
    int32_t viewport_y_px;
    uint64_t tag;                /* tells the host's views apart; handed to begin_frame */
    uint32_t ignores_near_plane; /* 1: nothing is clipped there (depth clamp, shadow pancaking) */
    uint32_t camera_relative;    /* 1: clip_from_world maps (position - origin) to clip space */
    double origin[3];            /* the eye, or a point near it; with camera_relative */
} occlude_view;

/* ---- devices ---- */

typedef struct occlude_ticket {
    uint32_t index;
    uint32_t generation; /* 0: no ticket, answers "lost" */
} occlude_ticket;

enum { OCCLUDE_ANSWER_PENDING = 0, OCCLUDE_ANSWER_READY = 1, OCCLUDE_ANSWER_LOST = 2 };
typedef struct occlude_answer {
    uint32_t state;   /* lost reads as visible */
    uint64_t samples; /* with ready: the samples that passed, or 1 for "some" */
} occlude_answer;

enum { OCCLUDE_PASS_SHADE = 0, OCCLUDE_PASS_DEPTH_ONLY = 1, OCCLUDE_PASS_SHADE_EQUAL = 2 };

enum {
    OCCLUDE_METHOD_AUTOMATIC = 0,
    OCCLUDE_METHOD_QUERIES = 1,
    OCCLUDE_METHOD_RASTER = 2,
    OCCLUDE_METHOD_PYRAMID = 3
};

/* A way in which the device tests boxes, and a guess of what it costs, in microseconds. */
typedef struct occlude_test_cost {
    uint32_t method;       /* OCCLUDE_METHOD_QUERIES, _RASTER or _PYRAMID */
    uint32_t exact_counts; /* 1: answers count samples; 0: a visible test counts 1 */
    float us_per_batch;
    float us_per_test;
    float us_per_box;
} occlude_test_cost;

/* A size of tiles in which the device reads depth, and a guess of what a read costs, in
 * microseconds: the sum of the three parts. */
typedef struct occlude_depth_read_cost {
    int32_t tile_px; /* 1: read_depth; a power of two above 1: read_depth_tiles */
    float us_per_read;
    float us_per_pixel; /* of the target */
    float us_per_value; /* that comes back */
} occlude_depth_read_cost;

/* A box to test, in the space of world_from_box, or in world space if that is null. */
typedef struct occlude_query_box {
    float min[3];
    float max[3];
    const float* world_from_box; /* 16 floats, or null */
    uint32_t node;               /* what is tested, for logs */
} occlude_query_box;

/* Several tests with one change of state. Test i covers boxes [test_ends[i-1], test_ends[i]): it
 * passes if any sample in the union of its boxes could be seen. */
typedef struct occlude_query_batch {
    const occlude_query_box* boxes;
    size_t box_count;
    const uint32_t* test_ends;
    size_t test_count;
    uint32_t method;
} occlude_query_batch;

/* Your renderer. The verbs take effect in call order; a test sees exactly the draws before it,
 * writes nothing, and must count at least one sample if anything inside its boxes could be seen.
 * What fails answers "lost". occlude/core/query_device.h has the whole contract, C1 to C12. A
 * callback must not throw or longjmp. Members that are marked optional may be null. */
typedef struct occlude_device {
    size_t struct_size;
    void* user; /* handed to every callback */

    /* capabilities */
    uint32_t same_frame_results;       /* 1: a result can be waited for in the frame that asked */
    uint32_t samples_at_pixel_centers; /* 1: one sample per pixel, in its middle */
    uint32_t max_outstanding;          /* tickets that may be unspent at one time; 0: 4096 */
    float us_per_triangle;             /* a guess of what drawing costs; 0: the library's guess */
    float us_per_item;
    uint32_t method_count;            /* 0: the library assumes exact queries */
    const occlude_test_cost* methods; /* the default first; read at each call of a culler */

    void (*begin_frame)(void* user, const occlude_view* view);
    void (*draw)(void* user, const uint32_t* items, size_t item_count, uint32_t pass);
    /* Writes batch->test_count tickets. Optional: without it nothing is tested. */
    void (*query)(void* user, const occlude_query_batch* batch, occlude_ticket* tickets);
    void (*flush)(void* user);                                 /* optional */
    occlude_answer (*poll)(void* user, occlude_ticket ticket); /* needed with query */
    occlude_answer (*wait)(void* user, occlude_ticket ticket); /* needed with query */
    void (*end_frame)(void* user);                             /* optional */
    /* Draws and counts the samples that passed. Optional. */
    occlude_ticket (*draw_and_query)(void* user, const uint32_t* items, size_t item_count,
                                     uint32_t pass);
    /* Writes width * height window depths, row by row from the bottom, the farthest sample of each
     * pixel. 0: it could not. Optional. */
    int (*read_depth)(void* user, int32_t x, int32_t y, int32_t width, int32_t height, float* out);
    /* since version 2 */
    const occlude_depth_read_cost* depth_reads; /* sizes ascending; read at each call of a culler */
    size_t depth_read_count;
    /* Writes the farthest depth of each tile of tile_px * tile_px pixels of the whole target, row
     * by row from the lower left: value_count of them. Tiles at the right and the upper edge are
     * cut off by the target. 0: it could not. Optional. */
    int (*read_depth_tiles)(void* user, int32_t tile_px, float* out, size_t value_count);
} occlude_device;

/* ---- cullers ---- */

typedef struct occlude_culler occlude_culler;

/* Seconds since some fixed moment; never goes back. */
typedef double (*occlude_clock)(void* user);

enum { OCCLUDE_EXACT = 0, OCCLUDE_LATENT = 1, OCCLUDE_APPROXIMATE = 2 };

/* What a frame was and what it cost. */
typedef struct occlude_report {
    size_t struct_size; /* set by the caller */
    uint64_t frame;     /* counts the frames since create or reset */
    uint32_t guarantee; /* OCCLUDE_EXACT: the image of drawing everything in the frustum */
    uint32_t latent_frames;
    uint64_t threshold_samples;
    uint64_t nodes_visited;
    uint64_t queries;
    uint64_t boxes;
    uint64_t multiqueries;
    uint64_t multiqueries_failed;
    uint64_t batches;
    uint64_t state_changes;
    uint64_t draw_calls;
    uint64_t items_drawn;
    uint64_t triangles_drawn;
    uint64_t waits;
    uint64_t lost_answers;
    uint64_t depth_reads;
    uint64_t pixels_read;
    uint64_t cells_asked;
} occlude_report;

/* A culler by name ("adaptive", "chc_plus_plus", ...), for one view of `hierarchy`. `clock` may be
 * null. "adaptive" measures by it; without one it measures by the steady clock of the system,
 * unless its option "measure" is "false": then it goes by the device's hints, and runs repeat. */
OCCLUDE_C_API occlude_status occlude_culler_create(const char* algorithm,
                                                   const occlude_hierarchy* hierarchy,
                                                   const occlude_option* options,
                                                   size_t option_count, occlude_clock clock,
                                                   void* clock_user, occlude_culler** culler);
OCCLUDE_C_API void occlude_culler_destroy(occlude_culler* culler);

/* Culls and draws one whole frame: begin_frame to end_frame. `report` may be null. */
OCCLUDE_C_API occlude_status occlude_culler_cull(occlude_culler* culler, const occlude_view* view,
                                                 const occlude_device* device,
                                                 occlude_report* report);

/* For "opt" and "ideal", which are told the answer before a frame: culls a frame untimed. `owners`
 * are the items that own a pixel; only "ideal" reads them. OCCLUDE_UNSUPPORTED for other
 * algorithms. */
OCCLUDE_C_API occlude_status occlude_culler_record(occlude_culler* culler, const occlude_view* view,
                                                   const occlude_device* device,
                                                   const uint32_t* owners, size_t owner_count);

/* Forgets everything seen: for a camera cut, a new level, another device. */
OCCLUDE_C_API void occlude_culler_reset(occlude_culler* culler);

/* As occlude_culler_reset, and spends the tickets that the culler still owes `device`, the one of
 * its last frames: for a culler that is destroyed before its device. Blocks until the tests are
 * answered; comes between frames. */
OCCLUDE_C_API occlude_status occlude_culler_release(occlude_culler* culler,
                                                    const occlude_device* device);

enum {
    OCCLUDE_SEVERITY_NOTE = 0,    /* the image is right; something costs time */
    OCCLUDE_SEVERITY_WARNING = 1, /* the image is right because the library gave up culling */
    OCCLUDE_SEVERITY_ERROR = 2    /* the image may be wrong */
};

/* Hears of a fault. `name` never changes ("culler.lost_answers"), `text` is a sentence; both are
 * valid during the call. It must not call the object that reports. */
typedef void (*occlude_message_handler)(void* user, uint32_t severity, const char* name,
                                        const char* text);

/* Who hears, once each, of faults that the culler notices in its device and its view; null: nobody.
 * Faults that were reported are reported again after this call. */
OCCLUDE_C_API occlude_status occlude_culler_set_message_handler(occlude_culler* culler,
                                                                occlude_message_handler handler,
                                                                void* user);

/* The items drawn by the last cull, in draw order, each once. Valid until the next cull. Returns
 * their number; `items` may be null. */
OCCLUDE_C_API size_t occlude_culler_drawn_items(const occlude_culler* culler,
                                                const uint32_t** items);

/* The plan of the last frame in words, such as "pyramid (pays): hides 12.30 ms of drawing at
 * 0.61 ms, draws 2.90 ms"; "" for algorithms that do not choose. Valid until the next cull. */
OCCLUDE_C_API const char* occlude_culler_plan(const occlude_culler* culler);

/* ---- what there is ---- */

typedef struct occlude_algorithm {
    const char* name;
    const char* paper;
    const char* summary;
    uint32_t exact;        /* with its default options */
    uint32_t needs_tests;  /* asks the device's query */
    uint32_t needs_depth;  /* asks the device's read_depth */
    uint32_t needs_record; /* call occlude_culler_record before each frame */
} occlude_algorithm;

OCCLUDE_C_API size_t occlude_algorithm_count(void);
/* Algorithm `index` in the order of tables; strings live as long as the library. */
OCCLUDE_C_API occlude_status occlude_algorithm_at(size_t index, occlude_algorithm* algorithm);

OCCLUDE_C_API size_t occlude_hierarchy_kind_count(void);
/* "bvh", ...; null beyond the end. The default is first. */
OCCLUDE_C_API const char* occlude_hierarchy_kind_at(size_t index);

#ifdef __cplusplus
}
#endif

#endif
