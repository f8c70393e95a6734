// A device whose verbs are the functions of an occlude_device.
#pragma once

#include <occlude/c/occlude.h>
#include <occlude/core/query_device.h>
#include <occlude/core/result.h>

#include <span>
#include <vector>

namespace occlude::c {

class CallbackDevice final : public QueryDevice {
public:
    /// Precondition: check() accepted `functions`. `view` must outlive the device; it is null if no
    /// frame is begun.
    CallbackDevice(const occlude_device& functions, const occlude_view* view);

    /// The error in `device`; an empty string if there is none.
    static std::string check(const occlude_device* device);

    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

private:
    void set_test_caps();
    void set_depth_caps();

    occlude_device functions_;
    const occlude_view* view_;
    DeviceCaps caps_;
    std::vector<occlude_query_box> boxes_;
    std::vector<occlude_ticket> tickets_;
};

} // namespace occlude::c
