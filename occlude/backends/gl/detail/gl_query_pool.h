// What is behind a GlDevice's tickets: a ring of occlusion query objects, some of which stand for
// an answer that comes, or came, in another way.
#pragma once

#include <occlude/backends/gl/detail/gl_flag_batch.h>
#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/query_device.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace occlude::gl {

/// Query objects of GL_SAMPLES_PASSED. One is never begun again before its result was read, or was
/// there and nobody came for it (kAbandonedAfter). Slots are reused in ring order.
class GlQueryPool {
public:
    /// A full pool takes back tickets that nobody read for this many frames, if their result is
    /// there: a culler that was reset may leave some behind.
    static constexpr uint64_t kAbandonedAfter = 64;

    /// At most `capacity` tickets are unspent at any time; objects are made as they are needed.
    explicit GlQueryPool(uint32_t capacity)
        : capacity_(capacity)
    {
    }

    /// Counts frames, and takes back abandoned tickets if the pool is full.
    void begin_frame();

    /// Begins a query. An invalid ticket, and no query is begun, if the pool is full.
    Ticket begin();

    /// Ends the query of the last begin().
    void end();

    /// A ticket whose answer is known without a query; invalid if the pool is full.
    Ticket answered(uint64_t samples);

    /// A ticket for a flag of a batch: 1 sample if it is set, else 0. Invalid if the pool is full.
    Ticket promise(std::shared_ptr<GlFlagBatch> flags, size_t test);

    /// The answer if it is there, without blocking; spends the ticket unless pending.
    Answer poll(Ticket ticket);

    /// The answer; blocks until it is there. Spends the ticket.
    Answer wait(Ticket ticket);

    uint32_t outstanding() const { return outstanding_; }

private:
    enum class SlotState : uint8_t { free, issued, promised, answered };
    struct Slot {
        GlQuery query;
        uint64_t frame = 0;                 ///< when it was begun
        uint64_t samples = 0;               ///< if answered
        std::shared_ptr<GlFlagBatch> flags; ///< if promised
        size_t test = 0;                    ///< likewise
        uint32_t generation = 0;
        SlotState state = SlotState::free;
    };

    Slot* find(Ticket ticket);
    static bool answer_is_there(const Slot& slot);
    Slot* take();
    Ticket ticket_of(const Slot& slot) const;
    Answer spend(Slot& slot);

    std::vector<Slot> slots_;
    uint32_t capacity_ = 0;
    uint32_t outstanding_ = 0;
    uint32_t next_ = 0; ///< where the ring continues
    uint64_t frame_ = 0;
};

} // namespace occlude::gl
