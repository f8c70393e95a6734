#include <occlude/device/handed_depth_device.h>

#include <occlude/core/assert.h>

#include <algorithm>

namespace occlude {

HandedDepthDevice::HandedDepthDevice()
{
    caps_.name = "handed depth";
    caps_.exact_counts = false;
    caps_.read_depth = true;
    caps_.methods = {{.method = TestMethod::pyramid,
                      .us_per_batch = 1.0f,
                      .us_per_test = 0.1f,
                      .us_per_box = 0.1f,
                      .exact_counts = false}};
}

void HandedDepthDevice::hand_over(glm::ivec2 size_px, std::span<const float> depth)
{
    const bool fits = size_px.x > 0 && size_px.y > 0 && depth.size() == pixel_count(size_px);
    OCCLUDE_ASSERT(fits, "HandedDepthDevice::hand_over needs one value per pixel");
    pyramid_.forget();
    size_px_ = fits ? size_px : glm::ivec2{0};
    depth_.assign(depth.begin(), fits ? depth.end() : depth.begin());
    if (fits) {
        std::ranges::copy(depth, pyramid_.resize(size_px).begin());
        pyramid_.build();
    }
}

void HandedDepthDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    OCCLUDE_ASSERT(tickets.size() == batch.test_ends.size(),
                   "HandedDepthDevice::query needs one ticket per test");
    pyramid_.answer(view_, batch, answers_);
    for (size_t i = 0; i < tickets.size(); ++i) {
        const bool room = i < answers_.size() && tickets_.size() < caps_.max_outstanding;
        tickets[i] = room ? tickets_.add(answers_[i]) : Ticket{};
    }
}

Answer HandedDepthDevice::wait(Ticket ticket)
{
    return tickets_.take(ticket).value_or(Answer::lost());
}

bool HandedDepthDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    if (view_.size_px() != size_px_ || !is_inside(rect, size_px_) ||
        out.size() != pixel_count(rect)) {
        return false;
    }
    for (int row = 0; row < rect.height; ++row) {
        const auto from =
            depth_.begin() + (rect.y + row) * static_cast<ptrdiff_t>(size_px_.x) + rect.x;
        std::copy(from, from + rect.width, out.begin() + row * static_cast<ptrdiff_t>(rect.width));
    }
    return true;
}

} // namespace occlude
