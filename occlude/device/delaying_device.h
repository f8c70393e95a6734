// Delays the answers of a real device and loses some: late and lost answers on demand, the same in
// every run.
#pragma once

#include <occlude/core/ticket_table.h>
#include <occlude/device/forwarding_device.h>

namespace occlude {

/// How late answers are. Each test's delay is drawn from these ranges, both ends included.
struct DelayOptions {
    uint64_t seed = 1;
    uint32_t min_polls = 0; ///< polls of any ticket after the test was issued that still come too
                            ///< early
    uint32_t max_polls = 0;
    uint32_t min_frames = 0; ///< calls of end_frame() after the test was issued
    uint32_t max_frames = 0;
    uint32_t lose_every = 0; ///< the n-th, 2n-th, ... test is lost; 0: none
};

/// poll() answers pending until the delay is over, without asking the device. wait() gets the
/// answer at once. A lost test answers lost at the time when it would have been answered.
class DelayingDevice final : public ForwardingDevice {
public:
    /// Keeps a reference: `inner` must outlive this device.
    DelayingDevice(QueryDevice& inner, DelayOptions options)
        : ForwardingDevice(inner)
        , options_(options)
    {
    }

    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    void end_frame() override;

private:
    enum class Fate : uint8_t { answered, lost };

    struct Test {
        Ticket inner;
        uint64_t ready_at_poll = 0;
        uint64_t ready_at_frame = 0; ///< in frames ended
        Fate fate = Fate::answered;
    };

    Ticket hold(Ticket inner);
    Answer pass_on(Ticket ticket, const Test& test, Answer answer);

    DelayOptions options_;
    TicketTable<Test> tests_;
    uint64_t tests_issued_ = 0;
    uint64_t polls_ = 0;
    uint64_t frames_ended_ = 0;
};

} // namespace occlude
