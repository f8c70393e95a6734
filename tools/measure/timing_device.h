// A decorator that measures the time of the device, so that the rest of a frame can be attributed
// to the culler.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/device/forwarding_device.h>

namespace occlude::tools {

class TimingDevice final : public ForwardingDevice {
public:
    /// `inner` must outlive the decorator.
    TimingDevice(QueryDevice& inner, SecondsClock clock)
        : ForwardingDevice(inner)
        , clock_(std::move(clock))
    {
    }

    /// Seconds spent in any verb, waits included, since the last restart.
    double verb_seconds() const { return verb_seconds_; }
    /// Seconds spent in wait().
    double wait_seconds() const { return wait_seconds_; }
    /// Seconds spent in read_depth() and read_depth_tiles().
    double read_seconds() const { return read_seconds_; }
    /// Calls of poll(). The decisions of a culler that polls may depend on when answers arrive.
    uint64_t polls() const { return polls_; }
    void restart();

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
    SecondsClock clock_;
    double verb_seconds_ = 0.0;
    double wait_seconds_ = 0.0;
    double read_seconds_ = 0.0;
    uint64_t polls_ = 0;
};

} // namespace occlude::tools
