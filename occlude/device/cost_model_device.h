// A device whose work takes the time that a model says, on its own clock. It shows how algorithms
// perform on hardware with other costs than this machine's. The answers are the same in every run.
//
//   host     the program's time. poll(), wait(), read_depth() and end_frame() take some of it; the
//            other verbs take none.
//   device   works through its commands in order and starts at once. wait() and read_depth()
//            advance the host's time to the moment when the device has finished the command and the
//            answer has come back. end_frame() waits for all commands.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/core/ticket_table.h>
#include <occlude/device/forwarding_device.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// All in microseconds.
struct DeviceCosts {
    double per_frame = 500.0; ///< per frame: clearing and pixels
    double per_triangle = 0.1;
    double per_item = 2.0;
    double per_draw = 20.0;  ///< a call of draw(), with its change of state
    double per_batch = 20.0; ///< a call of query(), with its change of state
    double per_test = 20.0;
    double per_box = 2.0;
    double per_depth_read = 50.0;
    double per_pixel_read = 0.0004;    ///< per value that comes back
    double per_pixel_reduced = 0.0001; ///< per pixel of the target, if tiles are read
    double latency = 5.0;              ///< from the end of the device's work until the host knows
                                       ///< the result
};

class CostModelDevice final : public ForwardingDevice {
public:
    /// Keeps references: `inner`, which answers, and the triangle counts must outlive this device.
    CostModelDevice(QueryDevice& inner, const DeviceCosts& costs,
                    std::span<const uint32_t> triangles_by_item)
        : ForwardingDevice(inner)
        , costs_(costs)
        , triangles_by_item_(triangles_by_item)
    {
        OCCLUDE_ASSERT(costs.per_frame >= 0.0 && costs.latency >= 0.0 &&
                           costs.per_triangle >= 0.0 && costs.per_test >= 0.0,
                       "CostModelDevice needs costs that are not negative");
    }

    /// The host's time, in seconds.
    double seconds() const { return 1e-6 * host_us_; }

    // caps() are those of `inner`: its hints are not taken from the model.
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

private:
    struct Test {
        Ticket inner;
        double known_at_us = 0.0;
    };

    void work(double us);
    double drawing_us(std::span<const ItemId> items) const;
    Ticket hold(Ticket inner);

    DeviceCosts costs_;
    std::span<const uint32_t> triangles_by_item_;
    TicketTable<Test> tests_;
    double host_us_ = 0.0;
    glm::ivec2 size_px_{0};
    double device_us_ = 0.0; ///< when the device will have finished its commands
};

} // namespace occlude
