// A device that fails by chance, and the same way in every run: answers come late, out of order,
// never, or are lost; answers expire; depth cannot be read; there are too few tickets. It keeps the
// contract: unknown answers read as visible, so that an exact algorithm stays exact over it.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/core/ticket_table.h>

#include <cstdint>

namespace occlude {

/// Chances are per thousand, drawn from `seed` and the number of the test or call.
struct Faults {
    uint64_t seed = 1;
    uint32_t lost = 0;                 ///< tests whose answer is lost
    uint32_t never_ready = 0;          ///< tests that poll() calls pending for ever; wait() works
    uint32_t depth_fails = 0;          ///< read-backs that fail, by pixels or by tiles
    uint32_t max_polls = 0;            ///< polls of a test that come too early: 0 to this many
    uint32_t max_frames = 0;           ///< calls of end_frame() before poll() answers: 0 to this
                                       ///< many
    uint32_t expires_after_frames = 0; ///< frames after which an unspent ticket is lost; 0: none
    uint32_t max_outstanding = 0;      ///< available tickets; 0: as many as the device has
    bool same_frame_results = true;    ///< false: wait() in the frame of the test answers lost
};

class FaultyDevice final : public QueryDevice {
public:
    /// Keeps a reference: `inner` must outlive this device.
    FaultyDevice(QueryDevice& inner, const Faults& faults);

    /// How many faults of all kinds have happened.
    uint64_t faults_injected() const { return injected_; }

    const DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override { inner_.draw(items, pass); }
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override { inner_.flush(); }
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

private:
    enum class Fate : uint8_t { answered, never_ready, lost };

    struct Test {
        Ticket inner;
        uint64_t asked_in_frame = 0;
        uint32_t early_polls = 0;
        uint32_t early_frames = 0;
        Fate fate = Fate::answered;
    };

    bool chance(uint32_t per_thousand, uint64_t what, uint64_t number) const;
    Ticket hold(Ticket inner);
    Answer collect(Ticket ticket, const Test& test);
    bool expired(const Test& test) const;
    bool depth_read_fails();

    QueryDevice& inner_;
    Faults faults_;
    DeviceCaps caps_;
    TicketTable<Test> tests_;
    uint64_t tests_issued_ = 0;
    uint64_t depth_reads_ = 0;
    uint64_t frames_ended_ = 0;
    uint64_t injected_ = 0;
};

} // namespace occlude
