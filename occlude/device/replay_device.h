// Repeats a run on real hardware without it, by answering from a recording.
#pragma once

#include <occlude/core/ticket_table.h>
#include <occlude/device/recording.h>

#include <string>

namespace occlude {

/// Answers from a recording while the calls are the recorded ones, in the same order. After the
/// first difference every answer is lost, and depth cannot be read.
class ReplayDevice final : public QueryDevice {
public:
    explicit ReplayDevice(Recording recording)
        : recording_(std::move(recording))
        , caps_(recording_.caps)
    {
    }

    /// The first difference as a sentence; empty if there is none.
    const std::string& mismatch() const { return mismatch_; }
    /// True if exactly the recorded calls were made.
    bool complete() const { return mismatch_.empty() && next_ == recording_.calls.size(); }

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
    const RecordedCall* match(const RecordedCall& asked);
    void fail(std::string why);
    Ticket issue(uint32_t test);
    Answer answer(RecordedCall asked, Ticket ticket);
    bool replay_depth(const RecordedCall& asked, std::span<float> out);

    Recording recording_;
    DeviceCaps caps_; ///< of this frame
    size_t next_ = 0;
    std::string mismatch_;
    TicketTable<uint32_t> tests_;
};

} // namespace occlude
