#include <occlude/device/counting_device.h>

#include <algorithm>

namespace occlude {

FrameCounters CountingDevice::total() const
{
    FrameCounters sum = earlier_;
    sum += frame_;
    return sum;
}

void CountingDevice::enter(State state)
{
    if (state_ != state) {
        state_ = state;
        ++frame_.state_changes;
    }
}

void CountingDevice::count_draw(std::span<const ItemId> items, DrawPass pass)
{
    enter(State::drawing);
    ++frame_.draw_calls;
    if (pass == DrawPass::shade_equal) {
        return;
    }
    frame_.items_drawn += items.size();
    for (const ItemId item : items) {
        if (item.value < options_.triangles_by_item.size()) {
            frame_.triangles_drawn += options_.triangles_by_item[item.value];
        }
    }
}

Answer CountingDevice::count_answer(Ticket ticket, Answer answer)
{
    if (answer.state == AnswerState::pending) {
        return answer;
    }
    const bool lost = answer.state == AnswerState::lost;
    frame_.lost_answers += lost ? 1 : 0;
    const bool visible = lost || answer.samples > options_.visible_above;
    const bool multiquery = multiqueries_.erase(ticket) > 0;
    frame_.multiqueries_failed += multiquery && visible ? 1 : 0;
    return answer;
}

void CountingDevice::begin_frame(const View& view)
{
    earlier_ += frame_;
    frame_ = {};
    state_ = State::drawing;
    inner().begin_frame(view);
}

void CountingDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    count_draw(items, pass);
    inner().draw(items, pass);
}

void CountingDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    enter(State::querying);
    ++frame_.batches;
    frame_.queries += batch.test_ends.size();
    frame_.boxes += batch.boxes.size();
    inner().query(batch, tickets);

    uint32_t begin = 0;
    for (size_t i = 0; i < batch.test_ends.size(); ++i) {
        const auto boxes = batch.boxes.subspan(begin, batch.test_ends[i] - begin);
        begin = batch.test_ends[i];
        const bool multiquery = std::any_of(boxes.begin(), boxes.end(), [&](const QueryBox& box) {
            return box.subject != boxes.front().subject;
        });
        if (multiquery) {
            ++frame_.multiqueries;
            multiqueries_.insert(tickets[i]);
        }
    }
}

Ticket CountingDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    count_draw(items, pass);
    ++frame_.queries;
    return inner().draw_and_query(items, pass);
}

Answer CountingDevice::poll(Ticket ticket)
{
    return count_answer(ticket, inner().poll(ticket));
}

Answer CountingDevice::wait(Ticket ticket)
{
    ++frame_.waits;
    return count_answer(ticket, inner().wait(ticket));
}

bool CountingDevice::count_depth_read(bool read, size_t values)
{
    if (read) {
        ++frame_.depth_reads;
        frame_.pixels_read += values;
    }
    return read;
}

bool CountingDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    return count_depth_read(inner().read_depth(rect, out), out.size());
}

bool CountingDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    return count_depth_read(inner().read_depth_tiles(tile_px, out), out.size());
}

} // namespace occlude
