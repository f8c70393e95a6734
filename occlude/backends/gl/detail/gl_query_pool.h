// The answers behind a GlDevice's tickets: a ring of occlusion query objects, some of which stand
// for an answer that comes in another way.
#pragma once

#include <occlude/backends/gl/detail/gl_flag_batch.h>
#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/query_device.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace occlude {

/// Query objects of GL_SAMPLES_PASSED. A query is begun again only after its result was read, or if
/// the result was available and nobody read it (kAbandonedAfter). Slots are reused in ring order.
class GlQueryPool {
public:
    /// A full pool takes back tickets that nobody read for this many frames, if their result is
    /// available: a culler that was reset may leave such tickets.
    static constexpr uint64_t kAbandonedAfter = 64;

    /// The faults since the last call.
    struct Faults {
        bool full = false;      ///< more than `capacity` tests would be unspent
        bool no_query = false;  ///< the driver gave no query object
        bool timed_out = false; ///< an answer did not come within the budget
    };

    /// At most `capacity` tickets are unspent at any time; objects are made as they are needed.
    /// `wait_budget_ms`: how long one frame may wait for answers that do not come.
    GlQueryPool(uint32_t capacity, double wait_budget_ms)
        : capacity_(capacity)
        , wait_budget_ms_(wait_budget_ms)
    {
    }

    /// Counts frames, and takes back abandoned tickets if the pool is full.
    void begin_frame();

    /// From now on OpenGL is not called, and every answer is lost.
    void give_up() { given_up_ = true; }
    /// From now on OpenGL is called again.
    void resume() { given_up_ = false; }

    Faults take_faults() { return std::exchange(faults_, {}); }

    /// Begins a query. Returns an invalid ticket and begins no query if the pool is full or the
    /// driver gives no query object.
    Ticket begin();

    /// Ends the query of the last begin().
    void end();

    /// A ticket whose answer is known without a query; invalid if the pool is full.
    Ticket answered(uint64_t samples);

    /// A ticket for a flag of a batch, which answers 1 sample if the flag is set, else 0. Invalid
    /// if the pool is full.
    Ticket promise(std::shared_ptr<GlFlagBatch> flags, size_t test);

    /// The answer, if it has arrived. Never blocks; spends the ticket unless the answer is pending.
    Answer poll(Ticket ticket);

    /// The answer; blocks until it arrives, or until the frame's budget is used up: then it is
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
    uint32_t next_ = 0; ///< the slot at which the ring continues
    uint64_t frame_ = 0;
    double wait_budget_ms_ = 0.0;
    double waited_ms_ = 0.0; ///< time that this frame has waited for answers that did not come
    bool given_up_ = false;
    Faults faults_;
};

} // namespace occlude
