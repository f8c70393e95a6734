#include <occlude/device/cost_model_device.h>

#include <algorithm>

namespace occlude {

// A poll takes time, so that a caller that only polls gets its answer eventually.
constexpr double kPollUs = 0.2;

void CostModelDevice::work(double us)
{
    device_us_ = std::max(device_us_, host_us_) + us;
}

double CostModelDevice::drawing_us(std::span<const ItemId> items) const
{
    double us = costs_.per_draw + costs_.per_item * static_cast<double>(items.size());
    for (const ItemId item : items) {
        const bool known = item.value < triangles_by_item_.size();
        us += known ? costs_.per_triangle * triangles_by_item_[item.value] : 0.0;
    }
    return us;
}

Ticket CostModelDevice::hold(Ticket inner)
{
    return inner.valid() ? tests_.add({inner, device_us_ + costs_.latency}) : Ticket{};
}

void CostModelDevice::begin_frame(const View& view)
{
    work(costs_.per_frame);
    size_px_ = view.size_px();
    inner().begin_frame(view);
}

void CostModelDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    work(drawing_us(items));
    inner().draw(items, pass);
}

void CostModelDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    inner().query(batch, tickets);
    work(costs_.per_batch);
    OCCLUDE_ASSERT(tickets.size() == batch.test_ends.size(),
                   "CostModelDevice::query needs one ticket per test");
    uint32_t first = 0;
    for (size_t i = 0; i < std::min(tickets.size(), batch.test_ends.size()); ++i) {
        work(costs_.per_test + costs_.per_box * (batch.test_ends[i] - first));
        first = batch.test_ends[i];
        tickets[i] = hold(tickets[i]);
    }
}

Ticket CostModelDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    work(drawing_us(items) + costs_.per_test);
    return hold(inner().draw_and_query(items, pass));
}

Answer CostModelDevice::poll(Ticket ticket)
{
    host_us_ += kPollUs;
    const Test* test = tests_.find(ticket);
    if (test == nullptr) {
        return Answer::lost();
    }
    if (host_us_ < test->known_at_us) {
        return Answer::pending();
    }
    const Answer answer = inner().wait(test->inner);
    tests_.release(ticket);
    return answer;
}

Answer CostModelDevice::wait(Ticket ticket)
{
    const Test* test = tests_.find(ticket);
    if (test == nullptr) {
        return Answer::lost();
    }
    host_us_ = std::max(host_us_, test->known_at_us);
    const Answer answer = inner().wait(test->inner);
    tests_.release(ticket);
    return answer;
}

bool CostModelDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    if (!inner().read_depth(rect, out)) {
        return false;
    }
    work(costs_.per_depth_read + costs_.per_pixel_read * static_cast<double>(out.size()));
    host_us_ = device_us_ + costs_.latency;
    return true;
}

bool CostModelDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    if (!inner().read_depth_tiles(tile_px, out)) {
        return false;
    }
    const double pixels = static_cast<double>(size_px_.x) * size_px_.y;
    work(costs_.per_depth_read + costs_.per_pixel_reduced * pixels +
         costs_.per_pixel_read * static_cast<double>(out.size()));
    host_us_ = device_us_ + costs_.latency;
    return true;
}

void CostModelDevice::end_frame()
{
    inner().end_frame();
    host_us_ = std::max(host_us_, device_us_);
}

} // namespace occlude
