// Culls without a draw callback: against depth that the engine hands over, into a list.
//
// For engines that cannot be called in the middle of a frame. They draw the depth of their best
// occluders (large objects, the visible set of the last frame), hand it over, cull, and then draw
// culler.drawn_items() in any order and in any thread.
//
//   device.hand_over(size, depth);            // of this frame, with the view's own camera
//   culler.cull(view, device);
//   engine.draw(culler.drawn_items());
//
// Guarantees  exact with depth of this frame and camera, drawn from items that the engine draws:
//             every item is listed that the handed depth does not hide. Depth of an earlier frame
//             or of another camera may hide items that have become visible since.
// Cost        a test is a comparison on the CPU; nothing waits. draw() only extends the list:
//             the depth stays as it was handed over, so that an item in the list hides another one
//             only if it is in that depth, too.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/core/ticket_table.h>
#include <occlude/screen/pyramid_tests.h>

#include <span>
#include <vector>

namespace occlude {

class HandedDepthDevice final : public QueryDevice {
public:
    HandedDepthDevice();

    /// Sets the depth for all frames until the next call: window depth, 0 near to 1 far, the
    /// farthest sample of each pixel, row by row from the bottom. Copies it. Precondition: one
    /// value per pixel. In a frame of another size nothing is tested, and everything is visible.
    void hand_over(glm::ivec2 size_px, std::span<const float> depth);

    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View& view) override { view_ = view; }
    void draw(std::span<const ItemId>, DrawPass) override {}
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    void flush() override {}
    Answer poll(Ticket ticket) override { return wait(ticket); }
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    void end_frame() override {}

private:
    DeviceCaps caps_;
    View view_;
    glm::ivec2 size_px_{0};
    std::vector<float> depth_;
    PyramidTests pyramid_;
    std::vector<Answer> answers_; ///< of one batch
    TicketTable<Answer> tickets_;
};

} // namespace occlude
