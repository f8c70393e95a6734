// Answers tests on the CPU, at once, while another device draws: for renderers whose answers come
// late or whose depth is expensive to read.
//
// Every draw goes to the renderer, and its items become occluders of an OccluderBuffer. A test
// rasterises what waits and compares the boxes' rectangles with it. Nothing waits for the renderer,
// and the first frame after a camera cut is culled like any other.
//
// Draws     Go to the renderer unchanged. Items of shade and depth_only passes hide; whether items
//           that need not be drawn are left out changes how much is found hidden, never the image.
// Tests     By the method `pyramid`, answered at once. They see the draws before them (C2), as far
//           as the budget reaches.
// Depth     read_depth gives the depth of the occluders: nothing behind it can be seen, wherever in
//           its pixel the renderer takes samples. It is farther than the renderer's own depth at
//           outlines, and where items are not occluders.
// Guarantee Exact with any renderer that draws the items where their meshes say, multisampled or
//           not (docs/occluders.md).
#pragma once

#include <occlude/backends/cpu_fast/cpu_fast_scene.h>
#include <occlude/backends/cpu_fast/occluder_buffer.h>
#include <occlude/core/query_device.h>
#include <occlude/core/result.h>
#include <occlude/core/ticket_table.h>
#include <occlude/screen/projection.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace occlude {

namespace cpu_fast {
class OccluderChoice;
}

struct CpuFastDeviceOptions {
    OccluderBufferOptions buffer = {};
    /// Microseconds per frame for choosing and rasterising occluders; 0: no limit. The device
    /// measures what triangles cost and stops in time. Items that do not fit are drawn, and hide
    /// nothing. Which items fit depends on the clock, so that counters differ between runs.
    float budget_us = 0.0f;
    /// The clock of the budget, in microseconds; null: the system's steady one.
    double (*clock_us)() = nullptr;
    /// Triangles of occluders per frame at most; 0: no limit. As a budget, but the same in every
    /// run.
    uint64_t max_triangles = 0;
    /// Items whose rectangle on the screen has fewer pixels per triangle hide nothing: they would
    /// cost more than they hide.
    float min_px_per_triangle = 1.0f;
    /// Tickets that may be unspent at a time; a test beyond that is lost (C11).
    uint32_t max_outstanding = 4096;
};

class CpuFastDevice final : public QueryDevice {
public:
    /// `renderer` draws; null if nobody does and the host shades Culler::drawn_items() afterwards.
    /// Both it and the scene must outlive the device.
    CpuFastDevice(QueryDevice* renderer, const CpuFastScene& scene,
                  const CpuFastDeviceOptions& options = {});
    ~CpuFastDevice() override;

    const DeviceCaps& caps() const override { return caps_; }
    /// Fails for every method but pyramid and automatic.
    Result<bool> use_method(TestMethod method);
    /// From the next frame on.
    void set_max_triangles(uint64_t triangles) { options_.max_triangles = triangles; }

    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    void flush() override;
    Answer poll(Ticket ticket) override { return wait(ticket); }
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    /// Tiles of cell_px pixels, where that is a power of two: they are the cells themselves.
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

    /// Microseconds of this frame that went into occluders; 0 without a budget.
    float spent_us() const;
    /// The occluders of the frame so far; those that wait for a test are not in it.
    const OccluderBuffer& occluders() const { return buffer_; }

private:
    void rasterize_waiting();
    Answer answer(std::span<const QueryBox> boxes, size_t first_bounds) const;

    QueryDevice* renderer_;
    const CpuFastScene& scene_;
    CpuFastDeviceOptions options_;
    DeviceCaps caps_;
    OccluderBuffer buffer_;
    bool in_frame_ = false;
    std::unique_ptr<cpu_fast::OccluderChoice> choice_;
    std::vector<ScreenBounds> bounds_;
    TicketTable<Answer> tickets_;
};

} // namespace occlude
