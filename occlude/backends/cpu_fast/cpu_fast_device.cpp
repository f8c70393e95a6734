#include <occlude/backends/cpu_fast/cpu_fast_device.h>

#include <occlude/backends/cpu_fast/detail/occluder_choice.h>
#include <occlude/core/assert.h>

#include <algorithm>
#include <bit>

namespace occlude {

CpuFastDevice::CpuFastDevice(QueryDevice* renderer, const CpuFastScene& scene,
                             const CpuFastDeviceOptions& options)
    : renderer_(renderer)
    , scene_(scene)
    , options_(options)
    , buffer_(options.buffer)
    , choice_(std::make_unique<cpu_fast::OccluderChoice>())
{
    caps_.name = "cpu_fast";
    caps_.exact_counts = false;
    caps_.read_depth = true;
    caps_.max_outstanding = options.max_outstanding;
    caps_.methods = {{.method = TestMethod::pyramid,
                      .us_per_batch = 30.0f,
                      .us_per_test = 0.05f,
                      .us_per_box = 0.1f,
                      .exact_counts = false}};
    caps_.depth_reads = {{.tile_px = 1, .us_per_read = 30.0f, .us_per_value = 0.0003f}};
    if (const int cell = buffer_.cell_px(); cell > 1 && std::has_single_bit(unsigned(cell))) {
        caps_.depth_reads.push_back(
            {.tile_px = cell, .us_per_read = 30.0f, .us_per_value = 0.0003f});
    }
    if (renderer_ != nullptr) {
        caps_.us_per_triangle = renderer_->caps().us_per_triangle;
        caps_.us_per_item = renderer_->caps().us_per_item;
    }
}

CpuFastDevice::~CpuFastDevice() = default;

float CpuFastDevice::spent_us() const
{
    return choice_->spent_us();
}

Result<bool> CpuFastDevice::use_method(TestMethod method)
{
    if (method != TestMethod::automatic && method != TestMethod::pyramid) {
        return Error{ErrorCode::unsupported,
                     "the cpu_fast device tests by 'pyramid' alone; choose that, or the gl device"};
    }
    return true;
}

void CpuFastDevice::begin_frame(const View& view)
{
    OCCLUDE_ASSERT(!in_frame_, "begin_frame before the last frame ended (C1)");
    in_frame_ = true;
    choice_->begin_frame();
    buffer_.begin(view);
    if (renderer_ != nullptr) {
        renderer_->begin_frame(view);
    }
}

void CpuFastDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    OCCLUDE_ASSERT(in_frame_, "draw outside of a frame (C1)");
    if (!in_frame_) {
        return;
    }
    if (renderer_ != nullptr) {
        renderer_->draw(items, pass);
    }
    if (pass == DrawPass::shade_equal) {
        return;
    }
    for (const ItemId id : items) {
        choice_->add(id, scene_.item(id));
    }
}

// What comes later in the frame finds what is left of the budget.
void CpuFastDevice::rasterize_waiting()
{
    choice_->rasterize(buffer_, {.budget_us = options_.budget_us,
                                 .max_triangles = options_.max_triangles,
                                 .min_px_per_triangle = options_.min_px_per_triangle,
                                 .clock_us = options_.clock_us});
}

// 0 samples if all boxes of the test are hidden or outside; lost if nothing is known of one.
Answer CpuFastDevice::answer(std::span<const QueryBox> boxes, size_t first_bounds) const
{
    if (boxes.empty() || buffer_.size_cells().x == 0) {
        return Answer::lost();
    }
    bool seen = false;
    for (size_t i = 0; i < boxes.size(); ++i) {
        if (!boxes[i].box.is_bounded()) {
            return Answer::lost();
        }
        const ScreenBounds& bounds = bounds_[first_bounds + i];
        seen = seen || !bounds.valid ||
               buffer_.test(bounds.rect, bounds.near_depth) == Visibility::visible;
    }
    return Answer::ready(seen ? 1 : 0);
}

void CpuFastDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    OCCLUDE_ASSERT(in_frame_, "query outside of a frame (C1)");
    OCCLUDE_ASSERT(tickets.size() == batch.test_ends.size(), "one ticket per test");
    std::ranges::fill(tickets, Ticket{});
    if (!in_frame_) {
        return;
    }
    rasterize_waiting();
    bounds_.resize(batch.boxes.size());
    project_query_boxes(buffer_.view(), batch.boxes, bounds_);
    size_t begin = 0;
    for (size_t i = 0; i < std::min(tickets.size(), batch.test_ends.size()); ++i) {
        const size_t end = batch.test_ends[i];
        OCCLUDE_ASSERT(begin < end && end <= batch.boxes.size(), "a test without boxes (C6)");
        if (begin < end && end <= batch.boxes.size() && tickets_.size() < caps_.max_outstanding) {
            tickets[i] = tickets_.add(answer(batch.boxes.subspan(begin, end - begin), begin));
        }
        begin = std::max(begin, end);
    }
}

void CpuFastDevice::flush()
{
    if (renderer_ != nullptr) {
        renderer_->flush();
    }
}

Answer CpuFastDevice::wait(Ticket ticket)
{
    return tickets_.take(ticket).value_or(Answer::lost());
}

bool CpuFastDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    rasterize_waiting();
    return buffer_.read_depth(rect, out);
}

bool CpuFastDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    if (caps_.find_depth_read(tile_px) == nullptr || tile_px == 1 ||
        buffer_.depth().size() != out.size()) {
        return false;
    }
    rasterize_waiting();
    std::ranges::copy(buffer_.depth(), out.begin());
    return true;
}

void CpuFastDevice::end_frame()
{
    in_frame_ = false;
    choice_->end_frame(buffer_);
    if (renderer_ != nullptr) {
        renderer_->end_frame();
    }
}

} // namespace occlude
