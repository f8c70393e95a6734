// The base of every decorator: a device that passes each verb on to another one. A decorator
// overrides the verbs that it changes, and calls inner() in them.
#pragma once

#include <occlude/core/query_device.h>

namespace occlude {

class ForwardingDevice : public QueryDevice {
public:
    const DeviceCaps& caps() const override { return inner_.caps(); }
    void begin_frame(const View& view) override { inner_.begin_frame(view); }
    void draw(std::span<const ItemId> items, DrawPass pass) override { inner_.draw(items, pass); }
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override
    {
        inner_.query(batch, tickets);
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

protected:
    /// Keeps a reference: `inner` must outlive this device.
    explicit ForwardingDevice(QueryDevice& inner)
        : inner_(inner)
    {
    }

    QueryDevice& inner() const { return inner_; }

private:
    QueryDevice& inner_;
};

} // namespace occlude
