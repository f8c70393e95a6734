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
    const bool fits =
        size_px.x > 0 && size_px.y > 0 &&
        depth.size() == static_cast<size_t>(size_px.x) * static_cast<size_t>(size_px.y);
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
    const Answer* found = tickets_.find(ticket);
    if (found == nullptr) {
        return Answer::lost();
    }
    const Answer answer = *found;
    tickets_.release(ticket);
    return answer;
}

bool HandedDepthDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    const bool fits =
        view_.size_px() == size_px_ && rect.x >= 0 && rect.y >= 0 && rect.width >= 0 &&
        rect.height >= 0 && rect.width <= size_px_.x - rect.x &&
        rect.height <= size_px_.y - rect.y &&
        out.size() == static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height);
    if (!fits) {
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
