// The engine that the snippets of docs/integration.md assume.
#include <occlude/backends/gl/gl_device.h>
#include <occlude/cull/adaptive.h>
#include <occlude/cull/chc_plus_plus.h>
#include <occlude/cull/stop_and_wait.h>
#include <occlude/device/handed_depth_device.h>
#include <occlude/device/validating_device.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/integration/audit.h>
#include <occlude/integration/verify_frame.h>
#include <occlude/scene/scene.h>
#include <occlude/scene/tight_boxes.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct Draw {
    occlude::Aabb world_box() const;
    uint32_t triangle_count() const;
};

struct MyEngine {
    std::span<const Draw> draws() const;
    void submit(std::span<const occlude::ItemId> items);
    void bind_target_and_clear();
    void set_draw_state();
};

void log(std::string_view what, std::string_view text);
