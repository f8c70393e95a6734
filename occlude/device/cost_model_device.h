// A device whose work takes the time that a model says, on a clock of its own: how would algorithms
// do on hardware with other costs than this machine's? The same answer in every run.
//
//   host     the program's time. Verbs take none of it; poll(), wait(), read_depth() and the end of
//   a
//            frame do.
//   device   works through what it was given in order, beginning at once. wait() and read_depth()
//            bring the host to the moment when the device has come so far, and the answer has come
//            back. end_frame() waits for all of it.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/core/ticket_table.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// All in microseconds.
struct DeviceCosts {
    double per_frame = 500.0; ///< whatever is drawn: clearing, pixels
    double per_triangle = 0.1;
    double per_item = 2.0;
    double per_draw = 20.0;  ///< a call of draw(), with its change of state
    double per_batch = 20.0; ///< a call of query(), with its change of state
    double per_test = 20.0;
    double per_box = 2.0;
    double per_depth_read = 50.0;
    double per_pixel_read = 0.0004;
    double latency = 5.0; ///< until the host knows what the device has found
};

class CostModelDevice final : public QueryDevice {
public:
    /// Keeps references: `inner`, which answers, and the triangle counts outlive this device.
    CostModelDevice(QueryDevice& inner, const DeviceCosts& costs,
                    std::span<const uint32_t> triangles_by_item)
        : inner_(inner)
        , costs_(costs)
        , triangles_by_item_(triangles_by_item)
    {
    }

    /// The host's time, in seconds.
    double seconds() const { return 1e-6 * host_us_; }

    /// The hints are those of `inner`: they know nothing of the model.
    const DeviceCaps& caps() const override { return inner_.caps(); }
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override { inner_.flush(); }
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    void end_frame() override;

private:
    struct Test {
        Ticket inner;
        double known_at_us = 0.0;
    };

    void work(double us);
    double drawing_us(std::span<const ItemId> items) const;
    Ticket hold(Ticket inner);

    QueryDevice& inner_;
    DeviceCosts costs_;
    std::span<const uint32_t> triangles_by_item_;
    TicketTable<Test> tests_;
    double host_us_ = 0.0;
    double device_us_ = 0.0; ///< when the device will have done what it has
};

} // namespace occlude
