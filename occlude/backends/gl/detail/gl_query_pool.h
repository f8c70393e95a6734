// What is behind a GlDevice's tickets: a ring of occlusion query objects, some of which stand for
// an answer that comes, or came, in another way.
#pragma once

#include <occlude/backends/gl/detail/gl_flag_batch.h>
#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/query_device.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace occlude {

/// Query objects of GL_SAMPLES_PASSED. One is never begun again before its result was read, or was
/// there and nobody came for it (kAbandonedAfter). Slots are reused in ring order.
class GlQueryPool {
public:
    /// A full pool takes back tickets that nobody read for this many frames, if their result is
    /// there: a culler that was reset may leave some behind.
    static constexpr uint64_t kAbandonedAfter = 64;

    /// What went wrong since it was last asked.
    struct Faults {
        bool full = false;      ///< more than `capacity` tests would be unspent
        bool no_query = false;  ///< the driver gave no query object
        bool timed_out = false; ///< an answer did not come within the budget
    };

    /// At most `capacity` tickets are unspent at any time; objects are made as they are needed.
    /// `wait_budget_ms`: how long the waits of one frame may take for answers that do not come.
    GlQueryPool(uint32_t capacity, double wait_budget_ms)
        : capacity_(capacity)
        , wait_budget_ms_(wait_budget_ms)
    {
    }

    /// Counts frames, and takes back abandoned tickets if the pool is full.
    void begin_frame();

    /// From now on nothing is asked of OpenGL, and everything is lost ...
    void give_up() { given_up_ = true; }
    /// ... and from now on it is asked again.
    void resume() { given_up_ = false; }

    Faults take_faults() { return std::exchange(faults_, {}); }

    /// Begins a query. An invalid ticket, and no query is begun, if the pool is full or the driver
    /// gives no query object.
    Ticket begin();

    /// Ends the query of the last begin().
    void end();

    /// A ticket whose answer is known without a query; invalid if the pool is full.
    Ticket answered(uint64_t samples);

    /// A ticket for a flag of a batch: 1 sample if it is set, else 0. Invalid if the pool is full.
    Ticket promise(std::shared_ptr<GlFlagBatch> flags, size_t test);

    /// The answer if it is there, without blocking; spends the ticket unless pending.
    Answer poll(Ticket ticket);

    /// The answer; blocks until it is there, or the budget of the frame is used up: then it is
    /// lost. Spends the ticket.
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
    bool answer_comes(const Slot& slot);
    bool answer_is_there(const Slot& slot) const;
    Slot* take();
    Ticket ticket_of(const Slot& slot) const;
    void abandon(Slot& slot);
    Answer spend(Slot& slot);

    std::vector<Slot> slots_;
    uint32_t capacity_ = 0;
    uint32_t outstanding_ = 0;
    uint32_t next_ = 0; ///< where the ring continues
    uint64_t frame_ = 0;
    double wait_budget_ms_ = 0.0;
    double waited_ms_ = 0.0; ///< in this frame, for answers that did not come
    bool given_up_ = false;
    Faults faults_;
};

} // namespace occlude
