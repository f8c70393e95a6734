#include <occlude/device/replay_device.h>

#include <occlude/device/detail/recorded_calls.h>

#include <algorithm>

namespace occlude {

using detail::call_of;
using detail::depth_call;
using detail::draw_call;
using detail::frame_call;
using detail::query_call;
using detail::tiles_call;

void ReplayDevice::fail(std::string why)
{
    if (mismatch_.empty()) {
        mismatch_ = std::move(why);
    }
}

const RecordedCall* ReplayDevice::match(const RecordedCall& asked)
{
    if (!mismatch_.empty()) {
        return nullptr;
    }
    const std::string where = "call " + std::to_string(next_) + ", " + name(asked.verb) + ": ";
    if (next_ == recording_.calls.size()) {
        fail(where + "the recording has ended");
        return nullptr;
    }
    const RecordedCall& recorded = recording_.calls[next_];
    if (recorded.verb != asked.verb) {
        fail(where + "the recording has " + name(recorded.verb) + " here");
        return nullptr;
    }
    if (detail::question_bytes(recorded) != detail::question_bytes(asked)) {
        fail(where + "the recorded one has other arguments");
        return nullptr;
    }
    ++next_;
    return &recorded;
}

Ticket ReplayDevice::issue(uint32_t test)
{
    return test == RecordedCall::kNoTest ? Ticket{} : tests_.add(test);
}

void ReplayDevice::begin_frame(const View& view)
{
    const RecordedCall* recorded = match(frame_call(view));
    if (recorded != nullptr && recorded->new_caps) {
        caps_ = *recorded->new_caps;
    }
}

void ReplayDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    match(draw_call(DeviceVerb::draw, items, pass));
}

void ReplayDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    std::fill(tickets.begin(), tickets.end(), Ticket{});
    const RecordedCall* recorded = match(query_call(batch));
    if (!recorded) {
        return;
    }
    if (recorded->issued_tests.size() != tickets.size()) {
        fail("call " + std::to_string(next_ - 1) +
             ", query: the recorded one has another number of tickets");
        return;
    }
    std::transform(recorded->issued_tests.begin(), recorded->issued_tests.end(), tickets.begin(),
                   [this](uint32_t test) { return issue(test); });
}

Ticket ReplayDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    const RecordedCall* recorded = match(draw_call(DeviceVerb::draw_and_query, items, pass));
    return recorded && !recorded->issued_tests.empty() ? issue(recorded->issued_tests.front())
                                                       : Ticket{};
}

void ReplayDevice::flush()
{
    match(call_of(DeviceVerb::flush));
}

Answer ReplayDevice::answer(RecordedCall asked, Ticket ticket)
{
    const uint32_t* test = tests_.find(ticket);
    asked.asked_test = test ? *test : RecordedCall::kNoTest;
    const RecordedCall* recorded = match(asked);
    const Answer answer = recorded ? recorded->answer : Answer::lost();
    if (answer.state != AnswerState::pending) {
        tests_.release(ticket);
    }
    return answer;
}

Answer ReplayDevice::poll(Ticket ticket)
{
    return answer(call_of(DeviceVerb::poll), ticket);
}

Answer ReplayDevice::wait(Ticket ticket)
{
    return answer(call_of(DeviceVerb::wait), ticket);
}

bool ReplayDevice::replay_depth(const RecordedCall& asked, std::span<float> out)
{
    const RecordedCall* recorded = match(asked);
    if (!recorded || recorded->depth.empty() || recorded->depth.size() != out.size()) {
        return false;
    }
    std::copy(recorded->depth.begin(), recorded->depth.end(), out.begin());
    return true;
}

bool ReplayDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    return replay_depth(depth_call(rect), out);
}

bool ReplayDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    return replay_depth(tiles_call(tile_px), out);
}

void ReplayDevice::end_frame()
{
    match(call_of(DeviceVerb::end_frame));
}

} // namespace occlude
