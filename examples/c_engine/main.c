/* A small engine in C: a town of boxes that a ray caster draws, culled through occlude/c/occlude.h.
 *
 * Every frame is drawn twice, with and without culling, and both images must be equal. Exit status
 * 0 if they are, 1 if a pixel differs, 2 if something could not be made.
 *
 * usage: c_engine [ALGORITHM]      chc_plus_plus by default
 */
#include <occlude/c/occlude.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 80, HEIGHT = 50, BLOCKS = 14, BOXES = BLOCKS * BLOCKS, FRAMES = 8, TESTS = 4096 };
static const float kNear = 0.1f, kFar = 200.0f;

/* ---- the engine: boxes, a camera, and an image of depths and ids ---- */

typedef struct engine {
    occlude_item boxes[BOXES];
    float eye[3], right[3], up[3], forward[3];
    float tan_half_fov;
    float distance[WIDTH * HEIGHT]; /* along the view direction; kFar: nothing */
    uint32_t id[WIDTH * HEIGHT];
    uint64_t samples[TESTS]; /* of the tests of this frame */
    uint32_t test_count;
    unsigned long boxes_drawn;
} engine;

static float dot(const float* a, const float* b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The direction of the ray through the middle of a pixel; its part along `forward` is 1. */
static void pixel_ray(const engine* e, int x, int y, float* ray)
{
    const float across =
        (2.0f * ((float)x + 0.5f) / WIDTH - 1.0f) * e->tan_half_fov * WIDTH / HEIGHT;
    const float above = (2.0f * ((float)y + 0.5f) / HEIGHT - 1.0f) * e->tan_half_fov;
    for (int i = 0; i < 3; ++i) {
        ray[i] = e->forward[i] + across * e->right[i] + above * e->up[i];
    }
}

/* Where the ray enters the box, from the near plane on; kFar or more if it misses. */
static float enter(const engine* e, const float* ray, const float* min, const float* max)
{
    float first = kNear, last = kFar;
    for (int i = 0; i < 3; ++i) {
        if (ray[i] == 0.0f) {
            if (e->eye[i] < min[i] || e->eye[i] > max[i]) {
                return kFar;
            }
            continue;
        }
        const float a = (min[i] - e->eye[i]) / ray[i], b = (max[i] - e->eye[i]) / ray[i];
        first = fmaxf(first, fminf(a, b));
        last = fminf(last, fmaxf(a, b));
    }
    return first <= last ? first : kFar;
}

static void clear_image(engine* e)
{
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
        e->distance[p] = kFar;
        e->id[p] = UINT32_MAX;
    }
    e->test_count = 0;
}

static void draw_box(engine* e, uint32_t box)
{
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            float ray[3];
            pixel_ray(e, x, y, ray);
            const float at = enter(e, ray, e->boxes[box].min, e->boxes[box].max);
            const int p = y * WIDTH + x;
            /* Of equal distances the smaller id wins, so that the order of draws does not show. */
            if (at < e->distance[p] || (at == e->distance[p] && at < kFar && box < e->id[p])) {
                e->distance[p] = at;
                e->id[p] = box;
            }
        }
    }
    ++e->boxes_drawn;
}

static uint64_t count_samples(const engine* e, const float* min, const float* max)
{
    uint64_t samples = 0;
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            float ray[3];
            pixel_ray(e, x, y, ray);
            const float at = enter(e, ray, min, max);
            samples += at < kFar && at <= e->distance[y * WIDTH + x];
        }
    }
    return samples;
}

/* ---- the device: what occlude asks of the engine ---- */

static void begin_frame(void* user, const occlude_view* view)
{
    (void)view; /* the engine knows its camera */
    clear_image(user);
}

static void draw(void* user, const uint32_t* items, size_t count, uint32_t pass)
{
    if (pass != OCCLUDE_PASS_SHADE_EQUAL) { /* depth and ids come together here */
        for (size_t i = 0; i < count; ++i) {
            draw_box(user, items[i]);
        }
    }
}

static void query(void* user, const occlude_query_batch* batch, occlude_ticket* tickets)
{
    engine* e = user;
    uint32_t first = 0;
    for (size_t test = 0; test < batch->test_count; ++test) {
        uint64_t samples = 0;
        for (uint32_t b = first; b < batch->test_ends[test]; ++b) {
            samples += count_samples(e, batch->boxes[b].min, batch->boxes[b].max);
        }
        first = batch->test_ends[test];
        tickets[test].index = e->test_count;
        tickets[test].generation = e->test_count < TESTS; /* 0: no room, so the answer is "lost" */
        if (e->test_count < TESTS) {
            e->samples[e->test_count++] = samples;
        }
    }
}

static occlude_answer answer(void* user, occlude_ticket ticket)
{
    const engine* e = user;
    occlude_answer result = {OCCLUDE_ANSWER_LOST, 0};
    if (ticket.generation != 0 && ticket.index < e->test_count) {
        result.state = OCCLUDE_ANSWER_READY;
        result.samples = e->samples[ticket.index];
    }
    return result;
}

/* ---- the program ---- */

static void build_town(engine* e)
{
    uint32_t seed = 1;
    for (int i = 0; i < BOXES; ++i) {
        seed = seed * 1664525u + 1013904223u;
        const float x = (float)(i % BLOCKS) * 6.0f - 40.0f, z = (float)(i / BLOCKS) * -6.0f;
        const float tall = 2.0f + (float)(seed >> 24) / 24.0f;
        const occlude_item box = {{x, 0.0f, z - 4.0f}, {x + 4.0f, tall, z}, 12, 0};
        e->boxes[i] = box;
    }
}

/* A walk along a street, looking a little to the side. */
static void place_camera(engine* e, int frame)
{
    const float angle = 0.4f * sinf((float)frame * 0.3f);
    const float eye[3] = {-5.0f, 1.7f, 8.0f - (float)frame * 1.5f};
    const float forward[3] = {sinf(angle), 0.0f, -cosf(angle)};
    const float right[3] = {cosf(angle), 0.0f, sinf(angle)};
    const float up[3] = {0.0f, 1.0f, 0.0f};
    memcpy(e->eye, eye, sizeof eye);
    memcpy(e->forward, forward, sizeof forward);
    memcpy(e->right, right, sizeof right);
    memcpy(e->up, up, sizeof up);
    e->tan_half_fov = 0.6f;
}

/* The matrix of the same camera, with clip depth from -1 to 1. */
static occlude_view view_of(const engine* e)
{
    occlude_view view;
    memset(&view, 0, sizeof view);
    view.struct_size = sizeof view;
    view.width_px = WIDTH;
    view.height_px = HEIGHT;
    const float across = (float)HEIGHT / WIDTH / e->tan_half_fov, above = 1.0f / e->tan_half_fov;
    const float depth = (kFar + kNear) / (kFar - kNear),
                shift = -2.0f * kFar * kNear / (kFar - kNear);
    for (int i = 0; i < 3; ++i) {
        view.clip_from_world[4 * i + 0] = across * e->right[i];
        view.clip_from_world[4 * i + 1] = above * e->up[i];
        view.clip_from_world[4 * i + 2] = depth * e->forward[i];
        view.clip_from_world[4 * i + 3] = e->forward[i];
    }
    view.clip_from_world[12] = -across * dot(e->right, e->eye);
    view.clip_from_world[13] = -above * dot(e->up, e->eye);
    view.clip_from_world[14] = -depth * dot(e->forward, e->eye) + shift;
    view.clip_from_world[15] = -dot(e->forward, e->eye);
    return view;
}

static int give_up(const char* what)
{
    fprintf(stderr, "c_engine: %s: %s\n", what, occlude_last_error());
    return 2;
}

static unsigned long differing_pixels(engine* e, const uint32_t* culled)
{
    unsigned long different = 0;
    clear_image(e);
    for (uint32_t box = 0; box < BOXES; ++box) {
        draw_box(e, box);
    }
    for (int p = 0; p < WIDTH * HEIGHT; ++p) {
        different += culled[p] != e->id[p];
    }
    return different;
}

int main(int argc, char** argv)
{
    const char* algorithm = argc > 1 ? argv[1] : "chc_plus_plus";
    static engine e;
    static uint32_t culled[WIDTH * HEIGHT];
    build_town(&e);

    occlude_hierarchy* hierarchy = NULL;
    occlude_culler* culler = NULL;
    if (occlude_hierarchy_create("bvh", e.boxes, BOXES, 12, NULL, 0, &hierarchy) != OCCLUDE_OK) {
        return give_up("no hierarchy");
    }
    if (occlude_culler_create(algorithm, hierarchy, NULL, 0, NULL, NULL, &culler) != OCCLUDE_OK) {
        return give_up("no culler");
    }
    occlude_device device;
    memset(&device, 0, sizeof device);
    device.struct_size = sizeof device;
    device.user = &e;
    device.same_frame_results = 1;
    device.samples_at_pixel_centers = 1;
    device.max_outstanding = TESTS;
    device.begin_frame = begin_frame;
    device.draw = draw;
    device.query = query;
    device.poll = answer;
    device.wait = answer;

    unsigned long drawn = 0, different = 0;
    for (int frame = 0; frame < FRAMES; ++frame) {
        place_camera(&e, frame);
        const occlude_view view = view_of(&e);
        occlude_report report;
        memset(&report, 0, sizeof report);
        report.struct_size = sizeof report;
        if (occlude_culler_cull(culler, &view, &device, &report) != OCCLUDE_OK) {
            return give_up("no frame");
        }
        drawn += (unsigned long)report.items_drawn;
        memcpy(culled, e.id, sizeof culled);
        different += differing_pixels(&e, culled);
    }
    printf("%s drew %lu of %d boxes in %d frames; %lu pixels differ\n", algorithm, drawn,
           BOXES * FRAMES, FRAMES, different);
    occlude_culler_destroy(culler);
    occlude_hierarchy_destroy(hierarchy);
    return different == 0 ? 0 : 1;
}
