#include <occlude/device/recording_device.h>

#include <occlude/device/detail/recorded_calls.h>

namespace occlude {

using detail::call_of;
using detail::depth_call;
using detail::draw_call;
using detail::frame_call;
using detail::query_call;
using detail::tiles_call;

RecordingDevice::RecordingDevice(QueryDevice& inner)
    : ForwardingDevice(inner)
    , recording_{inner.caps(), {}}
    , caps_bytes_(detail::caps_bytes(inner.caps()))
{
}

uint32_t RecordingDevice::number(Ticket issued)
{
    if (!issued.valid()) {
        return RecordedCall::kNoTest;
    }
    return unspent_[issued] = tests_issued_++;
}

uint32_t RecordingDevice::number_of(Ticket asked) const
{
    const auto found = unspent_.find(asked);
    return found == unspent_.end() ? RecordedCall::kNoTest : found->second;
}

void RecordingDevice::begin_frame(const View& view)
{
    RecordedCall call = frame_call(view);
    inner().begin_frame(view);
    if (std::string caps = detail::caps_bytes(inner().caps()); caps != caps_bytes_) {
        caps_bytes_ = std::move(caps);
        call.new_caps = inner().caps();
    }
    recording_.calls.push_back(std::move(call));
}

void RecordingDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    recording_.calls.push_back(draw_call(DeviceVerb::draw, items, pass));
    inner().draw(items, pass);
}

void RecordingDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    RecordedCall call = query_call(batch);
    inner().query(batch, tickets);
    for (const Ticket ticket : tickets) {
        call.issued_tests.push_back(number(ticket));
    }
    recording_.calls.push_back(std::move(call));
}

Ticket RecordingDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    RecordedCall call = draw_call(DeviceVerb::draw_and_query, items, pass);
    const Ticket ticket = inner().draw_and_query(items, pass);
    call.issued_tests = {number(ticket)};
    recording_.calls.push_back(std::move(call));
    return ticket;
}

void RecordingDevice::flush()
{
    recording_.calls.push_back(call_of(DeviceVerb::flush));
    inner().flush();
}

Answer RecordingDevice::record_answer(RecordedCall call, Ticket ticket, Answer answer)
{
    call.asked_test = number_of(ticket);
    call.answer = answer;
    recording_.calls.push_back(std::move(call));
    if (answer.state != AnswerState::pending) {
        unspent_.erase(ticket);
    }
    return answer;
}

Answer RecordingDevice::poll(Ticket ticket)
{
    return record_answer(call_of(DeviceVerb::poll), ticket, inner().poll(ticket));
}

Answer RecordingDevice::wait(Ticket ticket)
{
    return record_answer(call_of(DeviceVerb::wait), ticket, inner().wait(ticket));
}

bool RecordingDevice::record_depth(RecordedCall call, bool read, std::span<const float> depth)
{
    if (read) {
        call.depth.assign(depth.begin(), depth.end());
    }
    recording_.calls.push_back(std::move(call));
    return read;
}

bool RecordingDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    return record_depth(depth_call(rect), inner().read_depth(rect, out), out);
}

bool RecordingDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    return record_depth(tiles_call(tile_px), inner().read_depth_tiles(tile_px, out), out);
}

void RecordingDevice::end_frame()
{
    recording_.calls.push_back(call_of(DeviceVerb::end_frame));
    inner().end_frame();
}

} // namespace occlude
