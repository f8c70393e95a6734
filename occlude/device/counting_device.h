// Counts from the outside what an algorithm makes a device do, to check the algorithm's own report.
//
// The counters have these meanings:
//   state_changes  A frame starts in the drawing state. query() while drawing is one change, draw()
//                  or draw_and_query() while querying is one. Nothing else changes the state, and
//                  the end of a frame does not count.
//   queries        tests in query(), and one for each draw_and_query()
//   multiqueries   tests whose boxes have more than one subject; failed: answered as visible
//   items_drawn,   draws of the shade and depth_only passes; shade_equal repeats items that are
//   triangles_drawn   counted already. draw_calls counts all passes.
//   lost_answers   polls and waits that answered lost
//   depth_reads    calls of read_depth() and read_depth_tiles() that could read
//   pixels_read    the values that came back
//   nodes_visited, stay 0: a device sees neither nodes nor cells
//   cells_asked
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/device/forwarding_device.h>

#include <set>

namespace occlude {

class CountingDevice final : public ForwardingDevice {
public:
    struct Options {
        std::span<const uint32_t> triangles_by_item = {}; ///< empty: triangles are not counted
        uint64_t visible_above = 0; ///< samples; tells which multiqueries failed
    };

    /// Keeps references: `inner` and the triangle counts must outlive this device.
    explicit CountingDevice(QueryDevice& inner)
        : CountingDevice(inner, Options{})
    {
    }
    CountingDevice(QueryDevice& inner, Options options)
        : ForwardingDevice(inner)
        , options_(options)
    {
    }

    /// Since the last begin_frame(), including polls and waits after end_frame().
    const FrameCounters& frame() const { return frame_; }
    /// The sum over all frames.
    FrameCounters total() const;

    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;

private:
    enum class State : uint8_t { drawing, querying };

    void enter(State state);
    void count_draw(std::span<const ItemId> items, DrawPass pass);
    bool count_depth_read(bool read, size_t values);
    Answer count_answer(Ticket ticket, Answer answer);

    Options options_;
    FrameCounters frame_;
    FrameCounters earlier_; ///< all frames before the current one
    State state_ = State::drawing;
    std::set<Ticket> multiqueries_; ///< unspent
};

} // namespace occlude
