#include <occlude/c/detail/callback_device.h>
#include <occlude/c/detail/guard.h>
#include <occlude/c/detail/handles.h>

#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>

#include <algorithm>
#include <cstring>

namespace occlude::c {

namespace {

void write_report(const FrameReport& from, occlude_report& to)
{
    occlude_report all{};
    all.struct_size = to.struct_size;
    all.frame = from.frame;
    all.guarantee = static_cast<uint32_t>(from.guarantee.kind);
    all.latent_frames = from.guarantee.frames;
    all.threshold_samples = from.guarantee.threshold;
    const FrameCounters& counters = from.counters;
    all.nodes_visited = counters.nodes_visited;
    all.queries = counters.queries;
    all.boxes = counters.boxes;
    all.multiqueries = counters.multiqueries;
    all.multiqueries_failed = counters.multiqueries_failed;
    all.batches = counters.batches;
    all.state_changes = counters.state_changes;
    all.draw_calls = counters.draw_calls;
    all.items_drawn = counters.items_drawn;
    all.triangles_drawn = counters.triangles_drawn;
    all.waits = counters.waits;
    all.lost_answers = counters.lost_answers;
    all.depth_reads = counters.depth_reads;
    all.pixels_read = counters.pixels_read;
    all.cells_asked = counters.cells_asked;
    // A caller built against an older header has fewer members.
    std::memcpy(&to, &all, std::min(to.struct_size, sizeof all));
}

static_assert(OCCLUDE_SEVERITY_ERROR == static_cast<int>(Severity::error));
static_assert(OCCLUDE_LATENT == static_cast<int>(Guarantee::Kind::latent));
static_assert(OCCLUDE_APPROXIMATE == static_cast<int>(Guarantee::Kind::approximate));

/// Checks the arguments of cull and record, and calls body(view, device).
template <class Body>
occlude_status with_device(const occlude_culler* culler, const occlude_view* view,
                           const occlude_device* device, Body&& body)
{
    return guarded([&] {
        if (culler == nullptr) {
            return fail(OCCLUDE_INVALID_ARGUMENT, "culler is null");
        }
        const Result<View> camera = view_from(view);
        if (!camera) {
            return fail(camera.error());
        }
        if (std::string problem = CallbackDevice::check(device); !problem.empty()) {
            return fail(OCCLUDE_INVALID_ARGUMENT, std::move(problem));
        }
        CallbackDevice callbacks{*device, view};
        return body(*camera, callbacks);
    });
}

} // namespace

} // namespace occlude::c

using namespace occlude;

extern "C" {

occlude_status occlude_culler_create(const char* algorithm, const occlude_hierarchy* hierarchy,
                                     const occlude_option* options, size_t option_count,
                                     occlude_clock clock, void* clock_user, occlude_culler** culler)
{
    return c::guarded([&] {
        if (algorithm == nullptr || hierarchy == nullptr || culler == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "algorithm, hierarchy or culler is null");
        }
        const auto values = c::options_from(options, option_count);
        if (!values) {
            return c::fail(values.error());
        }
        SecondsClock seconds = steady_seconds_clock();
        if (clock != nullptr) {
            seconds = [clock, clock_user] { return clock(clock_user); };
        }
        auto made = make_culler(algorithm, hierarchy->tree, *values, std::move(seconds));
        if (!made) {
            return c::fail(made.error());
        }
        auto owned = std::make_unique<occlude_culler>();
        owned->culler = std::move(*made);
        *culler = owned.release();
        return OCCLUDE_OK;
    });
}

void occlude_culler_destroy(occlude_culler* culler)
{
    delete culler;
}

occlude_status occlude_culler_cull(occlude_culler* culler, const occlude_view* view,
                                   const occlude_device* device, occlude_report* report)
{
    return c::with_device(culler, view, device, [&](const View& camera, QueryDevice& callbacks) {
        const FrameReport frame = culler->culler->cull(camera, callbacks);
        culler->plan = to_string(frame.plan);
        if (report != nullptr) {
            c::write_report(frame, *report);
        }
        return OCCLUDE_OK;
    });
}

occlude_status occlude_culler_record(occlude_culler* culler, const occlude_view* view,
                                     const occlude_device* device, const uint32_t* owners,
                                     size_t owner_count)
{
    return c::with_device(culler, view, device, [&](const View& camera, QueryDevice& callbacks) {
        auto* oracle = dynamic_cast<OracleCuller*>(culler->culler.get());
        if (oracle == nullptr) {
            return c::fail(OCCLUDE_UNSUPPORTED, "only `opt` and `ideal` record");
        }
        if (owner_count > 0 && owners == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT,
                           "owners is null, but owner_count is " + std::to_string(owner_count));
        }
        std::vector<ItemId> ids;
        ids.reserve(owner_count);
        for (size_t i = 0; i < owner_count; ++i) {
            ids.push_back(ItemId{owners[i]});
        }
        oracle->record(camera, callbacks, ids);
        return OCCLUDE_OK;
    });
}

void occlude_culler_reset(occlude_culler* culler)
{
    if (culler != nullptr) {
        static_cast<void>(c::guarded([&] {
            culler->culler->reset();
            return OCCLUDE_OK;
        }));
    }
}

occlude_status occlude_culler_release(occlude_culler* culler, const occlude_device* device)
{
    return c::guarded([&] {
        if (culler == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "culler is null");
        }
        if (std::string problem = c::CallbackDevice::check(device); !problem.empty()) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, std::move(problem));
        }
        c::CallbackDevice callbacks{*device, nullptr};
        culler->culler->release(callbacks);
        return OCCLUDE_OK;
    });
}

occlude_status occlude_culler_set_message_handler(occlude_culler* culler,
                                                  occlude_message_handler handler, void* user)
{
    return c::guarded([&] {
        if (culler == nullptr) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT, "culler is null");
        }
        MessageHandler pass_on;
        if (handler != nullptr) {
            pass_on = [handler, user](const Message& message) {
                handler(user, static_cast<uint32_t>(message.severity),
                        std::string{message.name}.c_str(), std::string{message.text}.c_str());
            };
        }
        culler->culler->set_message_handler(std::move(pass_on));
        return OCCLUDE_OK;
    });
}

size_t occlude_culler_drawn_items(const occlude_culler* culler, const uint32_t** items)
{
    if (culler == nullptr) {
        return 0;
    }
    const std::span<const ItemId> drawn = culler->culler->drawn_items();
    if (items != nullptr) {
        *items = drawn.empty() ? nullptr : &drawn.front().value;
    }
    return drawn.size();
}

const char* occlude_culler_plan(const occlude_culler* culler)
{
    return culler != nullptr ? culler->plan.c_str() : "";
}

} // extern "C"
