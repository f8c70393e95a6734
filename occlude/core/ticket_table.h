// A table from tickets to their owners: slots are reused, and generations tell the owners apart.
#pragma once

#include <occlude/core/ids.h>

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace occlude {

/// Values by ticket. A ticket that was released, or that another table gave out, finds nothing,
/// even when its slot has a new owner. O(1) per call.
template <class T>
class TicketTable {
public:
    Ticket add(T value)
    {
        if (free_.empty()) {
            free_.push_back(static_cast<uint32_t>(slots_.size()));
            slots_.emplace_back();
        }
        const uint32_t index = free_.back();
        free_.pop_back();
        Slot& slot = slots_[index];
        slot.value = std::move(value);
        ++count_;
        return Ticket{index, slot.generation};
    }

    /// The value, or null if the ticket is unknown. Valid until the next add().
    T* find(Ticket ticket)
    {
        const bool known = ticket.valid() && ticket.index < slots_.size() &&
                           slots_[ticket.index].generation == ticket.generation;
        return known && slots_[ticket.index].value ? &*slots_[ticket.index].value : nullptr;
    }

    /// Forgets the ticket; its slot is free for the next one. Does nothing if it is unknown.
    void release(Ticket ticket)
    {
        if (!find(ticket)) {
            return;
        }
        Slot& slot = slots_[ticket.index];
        slot.value.reset();
        // 0 is never given out, not even after 2^32 owners
        slot.generation = slot.generation == 0xffffffffu ? 1 : slot.generation + 1;
        free_.push_back(ticket.index);
        --count_;
    }

    /// Releases the ticket and returns its value; nothing if the ticket is unknown.
    std::optional<T> take(Ticket ticket)
    {
        const T* found = find(ticket);
        std::optional<T> value = found != nullptr ? std::optional<T>{*found} : std::nullopt;
        release(ticket);
        return value;
    }

    /// How many tickets were given out and not released.
    uint32_t size() const { return count_; }

private:
    struct Slot {
        uint32_t generation = 1;
        std::optional<T> value;
    };

    std::vector<Slot> slots_;
    std::vector<uint32_t> free_;
    uint32_t count_ = 0;
};

} // namespace occlude
