#include <occlude/c/detail/callback_device.h>
#include <occlude/c/detail/guard.h>

#include <glm/gtc/type_ptr.hpp>

#include <bit>
#include <cstddef>

namespace occlude::c {

static_assert(sizeof(ItemId) == sizeof(uint32_t), "items are handed over as they are");
static_assert(OCCLUDE_METHOD_PYRAMID == static_cast<int>(TestMethod::pyramid));
static_assert(OCCLUDE_PASS_SHADE_EQUAL == static_cast<int>(DrawPass::shade_equal));
static_assert(OCCLUDE_ANSWER_LOST == static_cast<int>(AnswerState::lost));

namespace {

// The size of the structs in version 1 of this interface.
constexpr size_t kViewSizeOfVersion1 = offsetof(occlude_view, viewport_x_px);
constexpr size_t kDeviceSizeOfVersion1 = offsetof(occlude_device, depth_reads);

const uint32_t* raw(std::span<const ItemId> items)
{
    return items.empty() ? nullptr : &items.front().value;
}

Answer answer_from(const occlude_answer& answer)
{
    switch (answer.state) {
    case OCCLUDE_ANSWER_PENDING:
        return Answer::pending();
    case OCCLUDE_ANSWER_READY:
        return Answer::ready(answer.samples);
    default:
        return Answer::lost();
    }
}

/// A test may count too many samples, but must not wait for ever: if it is pending after a wait, it
/// is lost.
Answer final_answer(const Answer& answer)
{
    return answer.state == AnswerState::pending ? Answer::lost() : answer;
}

} // namespace

Result<View> view_from(const occlude_view* view)
{
    if (view == nullptr || view->struct_size < kViewSizeOfVersion1) {
        return Error{ErrorCode::invalid_argument,
                     "view is null, or its struct_size is not sizeof(occlude_view)"};
    }
    const occlude_view all = all_members(*view);
    if (all.width_px < 0 || all.height_px < 0) {
        return Error{ErrorCode::invalid_argument, "the size of the view is negative"};
    }
    ClipConvention convention;
    convention.range = all.depth_range == OCCLUDE_DEPTH_ZERO_TO_ONE ? DepthRange::zero_to_one
                                                                    : DepthRange::minus_one_to_one;
    convention.order = all.depth_order == OCCLUDE_NEAR_IS_LARGE ? DepthOrder::near_is_large
                                                                : DepthOrder::near_is_small;
    const ViewOptions options{.viewport_origin_px = {all.viewport_x_px, all.viewport_y_px},
                              .tag = all.tag,
                              .ignores_near_plane = all.ignores_near_plane != 0};
    const glm::mat4 clip = glm::make_mat4(all.clip_from_world);
    const glm::ivec2 size{all.width_px, all.height_px};
    return all.camera_relative != 0
               ? View::camera_relative(clip, glm::make_vec3(all.origin), size, convention, options)
               : View::from_clip(clip, size, convention, options);
}

static std::string check_depth_reads(const occlude_device& device)
{
    if (device.depth_read_count > 0 && device.depth_reads == nullptr) {
        return "the device has a depth_read_count, but depth_reads is null";
    }
    for (size_t i = 0; i < device.depth_read_count; ++i) {
        const int32_t tile_px = device.depth_reads[i].tile_px;
        if (tile_px < 1 || !std::has_single_bit(static_cast<uint32_t>(tile_px))) {
            return "depth_reads[" + std::to_string(i) + "].tile_px is " + std::to_string(tile_px) +
                   ", which is no power of two";
        }
        if (tile_px > 1 && device.read_depth_tiles == nullptr) {
            return "the device lists tiles in depth_reads, but has no read_depth_tiles";
        }
    }
    return {};
}

std::string CallbackDevice::check(const occlude_device* device)
{
    if (device == nullptr || device->struct_size < kDeviceSizeOfVersion1) {
        return "device is null, or its struct_size is not sizeof(occlude_device)";
    }
    if (device->begin_frame == nullptr || device->draw == nullptr) {
        return "the device has no begin_frame or no draw";
    }
    if (device->query != nullptr && (device->poll == nullptr || device->wait == nullptr)) {
        return "the device has query, but no poll or no wait";
    }
    if (device->method_count > 0 && device->methods == nullptr) {
        return "the device has a method_count, but methods is null";
    }
    for (uint32_t i = 0; i < device->method_count; ++i) {
        const uint32_t method = device->methods[i].method;
        if (method < OCCLUDE_METHOD_QUERIES || method > OCCLUDE_METHOD_PYRAMID) {
            return "methods[" + std::to_string(i) + "] is none of queries, raster and pyramid";
        }
    }
    return check_depth_reads(all_members(*device));
}

CallbackDevice::CallbackDevice(const occlude_device& functions, const occlude_view* view)
    : functions_(all_members(functions))
    , view_(view)
{
    caps_.name = "callbacks";
    caps_.samples_at_pixel_centers = functions_.samples_at_pixel_centers != 0;
    set_test_caps();
    set_depth_caps();
    if (functions_.us_per_triangle > 0.0f) {
        caps_.us_per_triangle = functions_.us_per_triangle;
    }
    if (functions_.us_per_item > 0.0f) {
        caps_.us_per_item = functions_.us_per_item;
    }
}

void CallbackDevice::set_test_caps()
{
    caps_.same_frame_results = functions_.same_frame_results != 0 && functions_.query != nullptr;
    caps_.draw_and_query = functions_.draw_and_query != nullptr;
    if (functions_.query == nullptr) {
        caps_.max_outstanding = 0;
        return;
    }
    if (functions_.max_outstanding > 0) {
        caps_.max_outstanding = functions_.max_outstanding;
    }
    for (const occlude_test_cost& cost : std::span{functions_.methods, functions_.method_count}) {
        caps_.methods.push_back({static_cast<TestMethod>(cost.method), cost.us_per_batch,
                                 cost.us_per_test, cost.us_per_box, cost.exact_counts != 0});
    }
    if (caps_.methods.empty()) {
        caps_.methods.push_back({});
    }
    caps_.exact_counts = caps_.methods.front().exact_counts;
}

void CallbackDevice::set_depth_caps()
{
    caps_.read_depth = functions_.read_depth != nullptr;
    for (const occlude_depth_read_cost& cost :
         std::span{functions_.depth_reads, functions_.depth_read_count}) {
        caps_.depth_reads.push_back(
            {cost.tile_px, cost.us_per_read, cost.us_per_pixel, cost.us_per_value});
    }
}

void CallbackDevice::begin_frame(const View&)
{
    functions_.begin_frame(functions_.user, view_);
}

void CallbackDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    functions_.draw(functions_.user, raw(items), items.size(), static_cast<uint32_t>(pass));
}

void CallbackDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    if (functions_.query == nullptr) {
        std::fill(tickets.begin(), tickets.end(), Ticket{}); // answers lost, which counts as
                                                             // visible
        return;
    }
    boxes_.clear();
    for (const QueryBox& box : batch.boxes) {
        boxes_.push_back(
            {{box.box.min.x, box.box.min.y, box.box.min.z},
             {box.box.max.x, box.box.max.y, box.box.max.z},
             box.world_from_box != nullptr ? glm::value_ptr(*box.world_from_box) : nullptr,
             box.subject.value});
    }
    tickets_.assign(tickets.size(), {});
    const occlude_query_batch asked{boxes_.data(), boxes_.size(), batch.test_ends.data(),
                                    batch.test_ends.size(), static_cast<uint32_t>(batch.method)};
    functions_.query(functions_.user, &asked, tickets_.data());
    for (size_t i = 0; i < tickets.size(); ++i) {
        tickets[i] = {tickets_[i].index, tickets_[i].generation};
    }
}

Ticket CallbackDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    if (functions_.draw_and_query == nullptr) {
        return QueryDevice::draw_and_query(items, pass);
    }
    const occlude_ticket ticket = functions_.draw_and_query(
        functions_.user, raw(items), items.size(), static_cast<uint32_t>(pass));
    return {ticket.index, ticket.generation};
}

void CallbackDevice::flush()
{
    if (functions_.flush != nullptr) {
        functions_.flush(functions_.user);
    }
}

Answer CallbackDevice::poll(Ticket ticket)
{
    if (functions_.poll == nullptr || !ticket.valid()) {
        return Answer::lost();
    }
    return answer_from(functions_.poll(functions_.user, {ticket.index, ticket.generation}));
}

Answer CallbackDevice::wait(Ticket ticket)
{
    if (functions_.wait == nullptr || !ticket.valid()) {
        return Answer::lost();
    }
    return final_answer(
        answer_from(functions_.wait(functions_.user, {ticket.index, ticket.generation})));
}

bool CallbackDevice::read_depth(const PixelRect& rect, std::span<float> out)
{
    return functions_.read_depth != nullptr &&
           functions_.read_depth(functions_.user, rect.x, rect.y, rect.width, rect.height,
                                 out.data()) != 0;
}

bool CallbackDevice::read_depth_tiles(int tile_px, std::span<float> out)
{
    return functions_.read_depth_tiles != nullptr && caps_.find_depth_read(tile_px) != nullptr &&
           functions_.read_depth_tiles(functions_.user, tile_px, out.data(), out.size()) != 0;
}

void CallbackDevice::end_frame()
{
    if (functions_.end_frame != nullptr) {
        functions_.end_frame(functions_.user);
    }
}

} // namespace occlude::c
