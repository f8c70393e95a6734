// Records all calls to a device and its answers, so that a run on real hardware becomes a test that
// needs none (replay_device.h).
#pragma once

#include <occlude/device/forwarding_device.h>
#include <occlude/device/recording.h>

#include <map>
#include <string>

namespace occlude {

class RecordingDevice final : public ForwardingDevice {
public:
    /// Keeps a reference: `inner` must outlive this device. Tickets pass through unchanged.
    explicit RecordingDevice(QueryDevice& inner);

    const Recording& recording() const { return recording_; }

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
    uint32_t number(Ticket issued);
    uint32_t number_of(Ticket asked) const;
    Answer record_answer(RecordedCall call, Ticket ticket, Answer answer);
    bool record_depth(RecordedCall call, bool read, std::span<const float> depth);

    Recording recording_;
    std::string caps_bytes_;             ///< of the last frame
    std::map<Ticket, uint32_t> unspent_; ///< the number of the test
    uint32_t tests_issued_ = 0;
};

} // namespace occlude
