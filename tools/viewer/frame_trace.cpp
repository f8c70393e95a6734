#include "viewer/frame_trace.h"

#include <occlude/core/assert.h>

namespace occlude::tools::viewer {

void TraceDevice::begin(FrameTrace& trace, uint64_t frame)
{
    trace = {};
    trace.frame = frame;
    trace.begin_s = clock_();
    trace.end_s = trace.begin_s;
    trace_ = &trace;
    places_.clear();
    overhead_s_ = 0.0;
}

TracedCall& TraceDevice::add(DeviceVerb verb)
{
    trace_->calls.push_back({.verb = verb, .begin_s = clock_()});
    return trace_->calls.back();
}

void TraceDevice::begin_frame(const View& view)
{
    TracedCall& call = add(DeviceVerb::begin_frame);
    inner_->begin_frame(view);
    call.end_s = clock_();
}

void TraceDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    TracedCall& call = add(DeviceVerb::draw);
    call.items = static_cast<uint32_t>(items.size());
    inner_->draw(items, pass);
    call.end_s = clock_();
}

void TraceDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    TracedCall& call = add(DeviceVerb::query);
    call.first_test = static_cast<uint32_t>(trace_->tests.size());
    call.test_count = static_cast<uint32_t>(tickets.size());
    inner_->query(batch, tickets);
    call.end_s = clock_();
    uint32_t first = 0;
    for (size_t test = 0; test < tickets.size(); ++test) {
        TracedTest traced{.method = batch.method, .issued_s = call.begin_s};
        for (uint32_t box = first; box < batch.test_ends[test]; ++box) {
            const QueryBox& tested = batch.boxes[box];
            traced.subjects.push_back(tested.subject);
            traced.boxes.push_back(tested.world_from_box != nullptr
                                       ? transformed(*tested.world_from_box, tested.box)
                                       : tested.box);
        }
        first = batch.test_ends[test];
        if (!tickets[test].valid()) {
            traced.state = AnswerState::lost;
        } else {
            places_[tickets[test]] = static_cast<uint32_t>(trace_->tests.size());
            pending_[tickets[test]] = traced;
        }
        trace_->tests.push_back(std::move(traced));
    }
    overhead_s_ += clock_() - trace_->calls.back().end_s;
}

Ticket TraceDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    TracedCall& call = add(DeviceVerb::draw_and_query);
    call.items = static_cast<uint32_t>(items.size());
    call.first_test = static_cast<uint32_t>(trace_->tests.size());
    call.test_count = 1;
    const Ticket ticket = inner_->draw_and_query(items, pass);
    call.end_s = clock_();
    places_[ticket] = static_cast<uint32_t>(trace_->tests.size());
    trace_->tests.push_back({.issued_s = call.begin_s});
    return ticket;
}

void TraceDevice::flush()
{
    TracedCall& call = add(DeviceVerb::flush);
    inner_->flush();
    call.end_s = clock_();
}

void TraceDevice::note_answer(Ticket ticket, const Answer& answer)
{
    if (answer.state == AnswerState::pending) {
        return;
    }
    const auto fill = [&](TracedTest& test) {
        test.state = answer.state;
        test.samples = answer.samples;
        test.answered_s = clock_();
    };
    const auto earlier = pending_.find(ticket);
    if (const auto place = places_.find(ticket); place != places_.end()) {
        fill(trace_->tests[place->second]);
    } else if (earlier != pending_.end()) { // asked in an earlier frame: told in this one
        fill(earlier->second);
        trace_->tests.push_back(earlier->second);
    }
    if (earlier != pending_.end()) {
        pending_.erase(earlier);
    }
}

Answer TraceDevice::poll(Ticket ticket)
{
    const double begin = clock_();
    const Answer answer = inner_->poll(ticket);
    if (trace_ != nullptr && answer.state != AnswerState::pending) {
        TracedCall& call = add(DeviceVerb::poll);
        call.begin_s = begin;
        call.end_s = clock_();
        note_answer(ticket, answer);
    }
    return answer;
}

Answer TraceDevice::wait(Ticket ticket)
{
    TracedCall& call = add(DeviceVerb::wait);
    const Answer answer = inner_->wait(ticket);
    call.end_s = clock_();
    note_answer(ticket, answer);
    return answer;
}

bool TraceDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    TracedCall& call = add(DeviceVerb::read_depth);
    call.rect = rect;
    const bool read = inner_->read_depth(rect, out);
    call.end_s = clock_();
    return read;
}

bool TraceDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    TracedCall& call = add(DeviceVerb::read_depth_tiles);
    const bool read = inner_->read_depth_tiles(tile_px, out);
    call.end_s = clock_();
    return read;
}

void TraceDevice::end_frame()
{
    TracedCall& call = add(DeviceVerb::end_frame);
    inner_->end_frame();
    call.end_s = clock_();
    trace_->end_s = call.end_s;
}

} // namespace occlude::tools::viewer
