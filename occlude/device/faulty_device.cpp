#include <occlude/device/faulty_device.h>

#include <occlude/core/assert.h>
#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude {

namespace {

// The purpose of a random number, so that no two decisions share one.
enum Purpose : uint64_t { kLost, kNeverReady, kDepth, kPolls, kFrames };

} // namespace

FaultyDevice::FaultyDevice(QueryDevice& inner, const Faults& faults)
    : inner_(inner)
    , faults_(faults)
    , caps_(inner.caps())
{
    OCCLUDE_ASSERT(faults.lost <= 1000 && faults.never_ready <= 1000 && faults.depth_fails <= 1000,
                   "FaultyDevice needs chances of at most 1000 per thousand");
    OCCLUDE_ASSERT(faults.max_polls < ~0u && faults.max_frames < ~0u,
                   "FaultyDevice needs delays below 2^32 - 1");
    if (faults_.max_outstanding != 0) {
        caps_.max_outstanding = std::min(caps_.max_outstanding, faults_.max_outstanding);
    }
    caps_.same_frame_results = caps_.same_frame_results && faults_.same_frame_results;
}

bool FaultyDevice::chance(uint32_t per_thousand, uint64_t what, uint64_t number) const
{
    return uniform_below(hash64(faults_.seed, what, number), 1000) < per_thousand;
}

void FaultyDevice::begin_frame(const View& view)
{
    inner_.begin_frame(view);
    // The device may know the layout of its samples only now; its other caps do not change.
    caps_.samples_at_pixel_centers = inner_.caps().samples_at_pixel_centers;
}

Ticket FaultyDevice::hold(Ticket inner)
{
    const uint64_t number = tests_issued_++;
    Test test{inner, frames_ended_, 0, 0, Fate::answered};
    test.early_polls = uniform_below(hash64(faults_.seed, kPolls, number), faults_.max_polls + 1);
    test.early_frames =
        uniform_below(hash64(faults_.seed, kFrames, number), faults_.max_frames + 1);
    if (chance(faults_.lost, kLost, number)) {
        test.fate = Fate::lost;
    } else if (chance(faults_.never_ready, kNeverReady, number)) {
        test.fate = Fate::never_ready;
    }
    injected_ += test.fate != Fate::answered || test.early_polls + test.early_frames > 0 ? 1 : 0;
    return tests_.add(test);
}

void FaultyDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    inner_.query(batch, tickets);
    for (Ticket& ticket : tickets) {
        if (tests_.size() < caps_.max_outstanding) {
            ticket = hold(ticket);
            continue;
        }
        ++injected_;
        inner_.wait(ticket); // otherwise the inner device would run out of tickets, too
        ticket = Ticket{};
    }
}

Ticket FaultyDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    const Ticket inner = inner_.draw_and_query(items, pass);
    if (tests_.size() < caps_.max_outstanding) {
        return hold(inner);
    }
    ++injected_;
    inner_.wait(inner);
    return Ticket{};
}

bool FaultyDevice::expired(const Test& test) const
{
    return faults_.expires_after_frames != 0 &&
           frames_ended_ - test.asked_in_frame > faults_.expires_after_frames;
}

Answer FaultyDevice::collect(Ticket ticket, const Test& test)
{
    const bool lost = test.fate == Fate::lost || expired(test);
    const Answer answer = inner_.wait(test.inner);
    injected_ += expired(test) ? 1 : 0;
    tests_.release(ticket);
    return lost ? Answer::lost() : answer;
}

Answer FaultyDevice::poll(Ticket ticket)
{
    Test* test = tests_.find(ticket);
    if (test == nullptr) {
        return Answer::lost();
    }
    if (expired(*test)) {
        return collect(ticket, *test);
    }
    if (test->early_polls > 0) {
        --test->early_polls;
        return Answer::pending();
    }
    const bool early = frames_ended_ - test->asked_in_frame < test->early_frames;
    if (early || test->fate == Fate::never_ready) {
        return Answer::pending();
    }
    const Answer answer = inner_.poll(test->inner);
    if (answer.state == AnswerState::pending) {
        return answer;
    }
    const bool lost = test->fate == Fate::lost;
    tests_.release(ticket);
    return lost ? Answer::lost() : answer;
}

Answer FaultyDevice::wait(Ticket ticket)
{
    const Test* test = tests_.find(ticket);
    if (test == nullptr) {
        return Answer::lost();
    }
    const bool too_early = !caps_.same_frame_results && test->asked_in_frame == frames_ended_;
    const Answer answer = collect(ticket, Test{*test});
    injected_ += too_early ? 1 : 0;
    return too_early ? Answer::lost() : answer;
}

bool FaultyDevice::depth_read_fails()
{
    const bool fails = chance(faults_.depth_fails, kDepth, depth_reads_++);
    injected_ += fails ? 1 : 0;
    return fails;
}

bool FaultyDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    return !depth_read_fails() && inner_.read_depth(rect, out);
}

bool FaultyDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    return !depth_read_fails() && inner_.read_depth_tiles(tile_px, out);
}

void FaultyDevice::end_frame()
{
    inner_.end_frame();
    ++frames_ended_;
}

} // namespace occlude
