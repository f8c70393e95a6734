// Adds flags rasterised on the device (TestMethod::raster) to the methods of the wrapped device.
// They are answered by queries and say "some" or "none", as flags do. With it the CPU device can
// stand in for a device with all three methods.
#pragma once

#include <occlude/core/query_device.h>

#include <algorithm>

namespace occlude::test {

class AllMethodsDevice final : public QueryDevice {
public:
    /// Keeps a reference: `inner` outlives this device.
    explicit AllMethodsDevice(QueryDevice& inner)
        : inner_(inner)
        , caps_(inner.caps())
    {
        TestCost flags = *caps_.find_method(TestMethod::queries);
        flags.method = TestMethod::raster;
        flags.exact_counts = false;
        caps_.methods.push_back(flags);
    }

    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View& view) override { inner_.begin_frame(view); }
    void draw(std::span<const ItemId> items, DrawPass pass) override { inner_.draw(items, pass); }
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        QueryBatch asked = batch;
        asked.method = batch.method == TestMethod::raster ? TestMethod::queries : batch.method;
        raster_batches_ += batch.method == TestMethod::raster ? 1 : 0;
        inner_.query(asked, tickets);
    }
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override
    {
        return inner_.draw_and_query(items, pass);
    }
    void flush() override { inner_.flush(); }
    Answer poll(Ticket ticket) override { return inner_.poll(ticket); }
    Answer wait(Ticket ticket) override { return inner_.wait(ticket); }
    bool read_depth(const PixelRect& rect, std::span<float> out) override
    {
        return inner_.read_depth(rect, out);
    }
    bool read_depth_tiles(int tile_px, std::span<float> out) override
    {
        return inner_.read_depth_tiles(tile_px, out);
    }
    void end_frame() override { inner_.end_frame(); }

    uint64_t raster_batches() const { return raster_batches_; }

private:
    QueryDevice& inner_;
    DeviceCaps caps_;
    uint64_t raster_batches_ = 0;
};

} // namespace occlude::test
