#include <occlude/backends/gl/detail/gl_query_pool.h>

#include <chrono>
#include <thread>
#include <utility>

namespace occlude {

namespace {

// After this time a wait yields to other threads.
constexpr double kPatienceMs = 2.0;

bool available(const GlQuery& query)
{
    GLuint there = GL_FALSE;
    glGetQueryObjectuiv(query.name(), GL_QUERY_RESULT_AVAILABLE, &there);
    return there != GL_FALSE;
}

} // namespace

void GlQueryPool::begin_frame()
{
    ++frame_;
    waited_ms_ = 0.0;
    if (outstanding_ < capacity_) {
        return;
    }
    for (Slot& slot : slots_) {
        if (slot.state != SlotState::free && frame_ - slot.frame > kAbandonedAfter &&
            answer_is_there(slot)) {
            spend(slot);
        }
    }
}

bool GlQueryPool::answer_is_there(const Slot& slot) const
{
    if (given_up_) {
        return true; // lost
    }
    switch (slot.state) {
    case SlotState::issued:
        return available(slot.query);
    case SlotState::promised:
        return slot.flags->available();
    default:
        return true;
    }
}

GlQueryPool::Slot* GlQueryPool::find(Ticket ticket)
{
    if (!ticket.valid() || ticket.index >= slots_.size()) {
        return nullptr;
    }
    Slot& slot = slots_[ticket.index];
    const bool own = slot.generation == ticket.generation && slot.state != SlotState::free;
    return own ? &slot : nullptr;
}

Ticket GlQueryPool::ticket_of(const Slot& slot) const
{
    return Ticket{static_cast<uint32_t>(&slot - slots_.data()), slot.generation};
}

// A slot with a new generation, or null if all are outstanding.
GlQueryPool::Slot* GlQueryPool::take()
{
    Slot* slot = nullptr;
    if (outstanding_ < slots_.size()) {
        while (slots_[next_].state != SlotState::free) {
            next_ = (next_ + 1) % static_cast<uint32_t>(slots_.size());
        }
        slot = &slots_[next_];
    } else if (slots_.size() < capacity_) {
        next_ = static_cast<uint32_t>(slots_.size());
        slot = &slots_.emplace_back();
        slot->query = GlQuery::make();
    } else {
        faults_.full = true;
        return nullptr;
    }
    next_ = (next_ + 1) % static_cast<uint32_t>(slots_.size());
    ++outstanding_;
    slot->frame = frame_;
    slot->generation = slot->generation + 1 == 0 ? 1 : slot->generation + 1;
    return slot;
}

Ticket GlQueryPool::begin()
{
    Slot* slot = take();
    if (slot == nullptr) {
        return Ticket{};
    }
    slot->state = SlotState::issued;
    if (slot->query.name() == 0) {
        slot->query = GlQuery::make(); // the driver may have memory again
    }
    if (slot->query.name() == 0) {
        faults_.no_query = true;
        slot->state = SlotState::free;
        --outstanding_;
        return Ticket{};
    }
    glBeginQuery(GL_SAMPLES_PASSED, slot->query.name());
    return ticket_of(*slot);
}

void GlQueryPool::end()
{
    glEndQuery(GL_SAMPLES_PASSED);
}

Ticket GlQueryPool::answered(uint64_t samples)
{
    Slot* slot = take();
    if (slot == nullptr) {
        return Ticket{};
    }
    slot->state = SlotState::answered;
    slot->samples = samples;
    return ticket_of(*slot);
}

Ticket GlQueryPool::promise(std::shared_ptr<GlFlagBatch> flags, size_t test)
{
    Slot* slot = take();
    if (slot == nullptr) {
        return Ticket{};
    }
    slot->state = SlotState::promised;
    slot->flags = std::move(flags);
    slot->test = test;
    return ticket_of(*slot);
}

// Reads the result, which blocks if it has not arrived.
Answer GlQueryPool::spend(Slot& slot)
{
    uint64_t samples = slot.samples;
    if (given_up_) {
        samples = Answer::kUnknownSamples;
        slot.flags.reset();
    } else if (slot.state == SlotState::issued) {
        samples = Answer::kUnknownSamples; // stays so if the driver fails
        glGetQueryObjectui64v(slot.query.name(), GL_QUERY_RESULT, &samples);
    } else if (slot.state == SlotState::promised) {
        samples = slot.flags->seen(slot.test) ? 1 : 0;
        slot.flags.reset();
    }
    slot.state = SlotState::free;
    --outstanding_;
    return samples == Answer::kUnknownSamples ? Answer::lost() : Answer::ready(samples);
}

Answer GlQueryPool::poll(Ticket ticket)
{
    Slot* slot = find(ticket);
    if (slot == nullptr) {
        return Answer::lost();
    }
    if (!answer_is_there(*slot)) {
        return Answer::pending();
    }
    return spend(*slot);
}

// Waits for an answer as long as the frame's budget lasts. Polls instead of asking for the result,
// which would block for ever if the answer never comes.
bool GlQueryPool::answer_comes(const Slot& slot)
{
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    for (uint64_t looks = 0; !answer_is_there(slot); ++looks) {
        const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
        if (waited_ms_ + ms > wait_budget_ms_) {
            waited_ms_ = wait_budget_ms_; // this frame has no budget left
            faults_.timed_out = true;
            return false;
        }
        if (ms < kPatienceMs) {
            std::this_thread::yield();
        } else {
            std::this_thread::sleep_for(std::chrono::microseconds{50});
        }
    }
    return true;
}

// A query whose answer did not come still belongs to the driver: its slot gets a new one.
void GlQueryPool::abandon(Slot& slot)
{
    if (slot.state == SlotState::issued) {
        slot.query = GlQuery::make();
    }
    slot.flags.reset();
    slot.state = SlotState::free;
    --outstanding_;
}

Answer GlQueryPool::wait(Ticket ticket)
{
    Slot* slot = find(ticket);
    if (slot == nullptr) {
        return Answer::lost();
    }
    if (wait_budget_ms_ > 0.0 && !answer_comes(*slot)) {
        abandon(*slot);
        return Answer::lost();
    }
    return spend(*slot);
}

} // namespace occlude
