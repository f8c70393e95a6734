#include <occlude/device/delaying_device.h>

#include <occlude/core/assert.h>
#include <occlude/core/rng.h>

namespace occlude {

namespace {

uint64_t between(uint32_t low, uint32_t high, uint64_t hash)
{
    OCCLUDE_ASSERT(low <= high, "the smallest delay is above the largest");
    return high <= low ? low : low + uint64_t{uniform_below(hash, high - low + 1)};
}

} // namespace

Ticket DelayingDevice::hold(Ticket inner)
{
    const uint64_t index = tests_issued_++;
    if (!inner.valid()) {
        return inner; // lost already
    }
    Test test;
    test.inner = inner;
    test.ready_at_poll =
        polls_ + between(options_.min_polls, options_.max_polls, hash64(options_.seed, index, 0));
    test.ready_at_frame = frames_ended_ + between(options_.min_frames, options_.max_frames,
                                                  hash64(options_.seed, index, 1));
    const bool lost = options_.lose_every > 0 && (index + 1) % options_.lose_every == 0;
    test.fate = lost ? Fate::lost : Fate::answered;
    return tests_.add(test);
}

Answer DelayingDevice::pass_on(Ticket ticket, const Test& test, Answer answer)
{
    if (answer.state == AnswerState::pending) {
        return answer;
    }
    const Fate fate = test.fate;
    tests_.release(ticket);
    return fate == Fate::lost ? Answer::lost() : answer;
}

void DelayingDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    inner().query(batch, tickets);
    for (Ticket& ticket : tickets) {
        ticket = hold(ticket);
    }
}

Ticket DelayingDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    return hold(inner().draw_and_query(items, pass));
}

Answer DelayingDevice::poll(Ticket ticket)
{
    const uint64_t polls_before = polls_++;
    const Test* test = tests_.find(ticket);
    if (!test) {
        return Answer::lost();
    }
    if (polls_before < test->ready_at_poll || frames_ended_ < test->ready_at_frame) {
        return Answer::pending();
    }
    return pass_on(ticket, *test, inner().poll(test->inner));
}

Answer DelayingDevice::wait(Ticket ticket)
{
    const Test* test = tests_.find(ticket);
    return test ? pass_on(ticket, *test, inner().wait(test->inner)) : Answer::lost();
}

void DelayingDevice::end_frame()
{
    ++frames_ended_;
    inner().end_frame();
}

} // namespace occlude
