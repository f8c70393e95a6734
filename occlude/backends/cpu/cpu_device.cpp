#include <occlude/backends/cpu/cpu_device.h>

#include <occlude/core/assert.h>

#include <algorithm>
#include <array>

namespace occlude {

namespace {

constexpr float kClearDepth = 1.0f;

glm::dvec4 clip_position(const glm::dmat4& clip_from_local, const glm::vec3& local)
{
    return clip_from_local * glm::dvec4{glm::dvec3{local}, 1.0};
}

// Corner i has the box's maximum on axis a if bit a of i is set.
std::array<glm::dvec4, 8> clip_corners(const glm::dmat4& clip_from_local, const Aabb& box)
{
    std::array<glm::dvec4, 8> corners;
    for (size_t i = 0; i < corners.size(); ++i) {
        const glm::vec3 local{(i & 1) != 0 ? box.max.x : box.min.x,
                              (i & 2) != 0 ? box.max.y : box.min.y,
                              (i & 4) != 0 ? box.max.z : box.min.z};
        corners[i] = clip_position(clip_from_local, local);
    }
    return corners;
}

// The six faces as quads, corners in order around each.
constexpr std::array<std::array<size_t, 4>, 6> kBoxFaces{{
    {0, 2, 6, 4},
    {1, 3, 7, 5},
    {0, 1, 5, 4},
    {2, 3, 7, 6},
    {0, 1, 3, 2},
    {4, 5, 7, 6},
}};

constexpr int kLargestTile = 64; // pixels

// The next value of a stamp. When all values are used up, every mark is cleared first.
void advance_stamp(uint32_t& current, std::vector<uint32_t>& marks)
{
    if (++current == 0) {
        std::fill(marks.begin(), marks.end(), 0u);
        current = 1;
    }
}

} // namespace

CpuDevice::CpuDevice(const CpuScene& scene, const CpuDeviceOptions& options)
    : scene_(scene)
{
    caps_.name = "cpu";
    caps_.draw_and_query = true;
    caps_.read_depth = true;
    caps_.samples_at_pixel_centers = true;
    caps_.max_outstanding = options.max_outstanding;
    caps_.methods = {{.method = TestMethod::queries,
                      .us_per_batch = 0.1f,
                      .us_per_test = 0.1f,
                      .us_per_box = 20.0f},
                     {.method = TestMethod::pyramid,
                      .us_per_batch = 300.0f,
                      .us_per_test = 0.1f,
                      .us_per_box = 0.1f,
                      .exact_counts = false}};
    caps_.us_per_triangle = 0.1f;
    for (int tile_px = 1; tile_px <= kLargestTile; tile_px *= 2) {
        caps_.depth_reads.push_back({.tile_px = tile_px,
                                     .us_per_read = 1.0f,
                                     .us_per_pixel = tile_px > 1 ? 0.0004f : 0.0f,
                                     .us_per_value = 0.0004f});
    }
}

Result<bool> CpuDevice::use_method(TestMethod method)
{
    if (!caps_.make_default(method)) {
        return Error{
            ErrorCode::unsupported,
            "the cpu device has no test method 'raster'; choose queries or pyramid, or the "
            "gl device"};
    }
    return true;
}

void CpuDevice::begin_frame(const View& view)
{
    OCCLUDE_ASSERT(!in_frame_, "begin_frame before the last frame ended (C1)");
    in_frame_ = true;
    ++frame_count_;
    view_ = view;
    transform_ = cpu::ScreenTransform(view);
    const glm::ivec2 size = transform_.usable() ? view.size_px() : glm::ivec2{0};
    if (size != target_.size_px) {
        target_.size_px = size;
        const size_t pixels = pixel_count(size);
        target_.items.assign(pixels, 0);
        target_.triangles.assign(pixels, 0);
        stamps_.assign(pixels, 0);
        target_.depth.resize(pixels);
        current_stamp_ = 0;
    }
    std::fill(target_.depth.begin(), target_.depth.end(), kClearDepth);
    target_.translucent.clear();
    pyramid_.forget();
}

const cpu::Vertex* CpuDevice::transformed_vertex(const CpuItem& item,
                                                 const glm::dmat4& clip_from_mesh, uint32_t index)
{
    if (index >= item.positions.size()) {
        return nullptr;
    }
    if (transformed_.marks[index] != transformed_.current) {
        transformed_.marks[index] = transformed_.current;
        transformed_.vertices[index] =
            transform_.process(clip_position(clip_from_mesh, item.positions[index]));
    }
    return &transformed_.vertices[index];
}

bool CpuDevice::outside_of_view(const Aabb& box, const glm::dmat4& clip_from_mesh) const
{
    if (!box.is_bounded()) {
        return false;
    }
    unsigned shared = cpu::kBeyondView;
    for (const glm::dvec4& corner : clip_corners(clip_from_mesh, box)) {
        shared &= transform_.code(corner);
    }
    return shared != 0;
}

// Calls fragment(triangle, pixel, depth) for every sample that the item covers.
template <class Fragment>
void CpuDevice::rasterize_item(const CpuItem& item, Fragment&& fragment)
{
    const glm::dmat4 clip_from_mesh = transform_.clip_from_local(item.world_from_mesh);
    if (!transform_.usable() || outside_of_view(item.box, clip_from_mesh)) {
        return;
    }
    if (transformed_.vertices.size() < item.positions.size()) {
        transformed_.vertices.resize(item.positions.size());
        transformed_.marks.resize(item.positions.size(), 0);
    }
    advance_stamp(transformed_.current, transformed_.marks);
    for (size_t i = 0; i + 2 < item.indices.size(); i += 3) {
        const cpu::Vertex* a = transformed_vertex(item, clip_from_mesh, item.indices[i]);
        const cpu::Vertex* b = transformed_vertex(item, clip_from_mesh, item.indices[i + 1]);
        const cpu::Vertex* c = transformed_vertex(item, clip_from_mesh, item.indices[i + 2]);
        if (a == nullptr || b == nullptr || c == nullptr) {
            continue;
        }
        const auto triangle = static_cast<uint32_t>(i / 3);
        cpu::draw_triangle(transform_, *a, *b, *c,
                           [&](size_t pixel, double depth) { fragment(triangle, pixel, depth); });
    }
}

// Draws one fragment; true if the pixel now shows it.
bool CpuDevice::write(size_t pixel, double depth, ItemId item, uint32_t triangle)
{
    const auto depth01 = static_cast<float>(depth);
    float& stored = target_.depth[pixel];
    if (depth01 >= stored) {
        // No fragment may equal the cleared depth, because LESS against 1 fails there.
        const bool wins_tie =
            depth01 == stored && stored != kClearDepth &&
            (item.value < target_.items[pixel] ||
             (item.value == target_.items[pixel] && triangle <= target_.triangles[pixel]));
        if (!wins_tie) {
            return false;
        }
    }
    stored = depth01;
    target_.items[pixel] = item.value;
    target_.triangles[pixel] = triangle;
    return true;
}

// Lists one translucent fragment; true if it is visible.
bool CpuDevice::blend(size_t pixel, double depth, ItemId item, uint32_t triangle)
{
    const bool seen = static_cast<float>(depth) < target_.depth[pixel];
    if (seen) {
        target_.translucent.push_back({pixel, {item, triangle}});
    }
    return seen;
}

// True if a fragment of an item is what the pixel shows.
bool CpuDevice::owns(size_t pixel, double depth, ItemId item) const
{
    return target_.depth[pixel] != kClearDepth &&
           static_cast<float>(depth) == target_.depth[pixel] && target_.items[pixel] == item.value;
}

void CpuDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    OCCLUDE_ASSERT(in_frame_, "draw outside of a frame (C1)");
    if (!in_frame_ || pass == DrawPass::shade_equal) {
        return;
    }
    pyramid_.forget();
    for (const ItemId item : items) {
        const CpuItem drawn = scene_.item(item);
        if (!drawn.translucent) {
            rasterize_item(drawn, [&](uint32_t triangle, size_t pixel, double depth) {
                write(pixel, depth, item, triangle);
            });
        } else if (pass == DrawPass::shade) {
            rasterize_item(drawn, [&](uint32_t triangle, size_t pixel, double depth) {
                blend(pixel, depth, item, triangle);
            });
        }
    }
}

Ticket CpuDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    OCCLUDE_ASSERT(in_frame_, "draw_and_query outside of a frame (C1)");
    if (!in_frame_ || !transform_.usable()) {
        return {};
    }
    next_stamp();
    pyramid_.forget();
    uint64_t samples = 0;
    for (const ItemId item : items) {
        const CpuItem drawn = scene_.item(item);
        if (drawn.translucent && pass != DrawPass::shade) {
            continue;
        }
        rasterize_item(drawn, [&](uint32_t triangle, size_t pixel, double depth) {
            const bool passed = drawn.translucent ? blend(pixel, depth, item, triangle)
                                : pass == DrawPass::shade_equal
                                    ? owns(pixel, depth, item)
                                    : write(pixel, depth, item, triangle);
            if (passed && stamp(pixel)) {
                ++samples;
            }
        });
    }
    return issue(Answer::ready(samples));
}

void CpuDevice::next_stamp()
{
    advance_stamp(current_stamp_, stamps_);
}

// True the first time that the current test counts the pixel.
bool CpuDevice::stamp(size_t pixel)
{
    const bool first = stamps_[pixel] != current_stamp_;
    stamps_[pixel] = current_stamp_;
    return first;
}

bool CpuDevice::testable(const QueryBox& box) const
{
    const Aabb box_world =
        box.world_from_box != nullptr ? transformed(*box.world_from_box, box.box) : box.box;
    return box.box.is_bounded() && !view_.touches_near(box_world);
}

// Samples of the box that pass and were not counted by this test before.
uint64_t CpuDevice::count_box(const QueryBox& box)
{
    const glm::dmat4 clip_from_box = box.world_from_box != nullptr
                                         ? transform_.clip_from_local(*box.world_from_box)
                                         : transform_.clip_from_world();
    const std::array<glm::dvec4, 8> corners = clip_corners(clip_from_box, box.box);
    std::array<cpu::Vertex, 8> vertices;
    for (size_t i = 0; i < corners.size(); ++i) {
        vertices[i] = transform_.process(corners[i]);
    }
    uint64_t samples = 0;
    const double bias = kBoxBias + double{view_.inflation().depth_bias};
    const auto fragment = [&](size_t pixel, double depth) {
        if (static_cast<float>(depth - bias) <= target_.depth[pixel] && stamp(pixel)) {
            ++samples;
        }
    };
    for (const std::array<size_t, 4>& face : kBoxFaces) {
        const cpu::Vertex& a = vertices[face[0]];
        const cpu::Vertex& c = vertices[face[2]];
        cpu::draw_triangle(transform_, a, vertices[face[1]], c, fragment);
        cpu::draw_triangle(transform_, a, c, vertices[face[3]], fragment);
    }
    return samples;
}

void CpuDevice::test_with_pyramid(const QueryBatch& batch)
{
    if (in_frame_ && transform_.usable() && !pyramid_.fresh()) {
        std::ranges::copy(target_.depth, pyramid_.resize(target_.size_px).begin());
        pyramid_.build();
    }
    pyramid_.answer(view_, batch, answers_);
}

Answer CpuDevice::test(std::span<const QueryBox> boxes)
{
    const bool answerable =
        in_frame_ && transform_.usable() && !boxes.empty() &&
        std::all_of(boxes.begin(), boxes.end(), [&](const QueryBox& box) { return testable(box); });
    if (!answerable) {
        return Answer::lost();
    }
    next_stamp();
    uint64_t samples = 0;
    for (const QueryBox& box : boxes) {
        samples += count_box(box);
    }
    return Answer::ready(samples);
}

void CpuDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    OCCLUDE_ASSERT(in_frame_, "query outside of a frame (C1)");
    OCCLUDE_ASSERT(tickets.size() == batch.test_ends.size(), "one ticket per test");
    std::fill(tickets.begin(), tickets.end(), Ticket{});
    const TestCost* named = caps_.find_method(batch.method);
    if ((named != nullptr ? *named : caps_.methods.front()).method == TestMethod::pyramid) {
        test_with_pyramid(batch);
        for (size_t i = 0; i < std::min(tickets.size(), answers_.size()); ++i) {
            tickets[i] = issue(answers_[i]);
        }
        return;
    }
    size_t begin = 0;
    for (size_t i = 0; i < std::min(tickets.size(), batch.test_ends.size()); ++i) {
        const size_t end = batch.test_ends[i];
        OCCLUDE_ASSERT(begin < end && end <= batch.boxes.size(), "a test without boxes (C6)");
        if (begin < end && end <= batch.boxes.size()) {
            tickets[i] = issue(test(batch.boxes.subspan(begin, end - begin)));
        }
        begin = std::max(begin, end);
    }
}

Ticket CpuDevice::issue(const Answer& answer)
{
    return unspent_.size() < caps_.max_outstanding ? unspent_.add(answer) : Ticket{};
}

Answer CpuDevice::wait(Ticket ticket)
{
    return unspent_.take(ticket).value_or(Answer::lost());
}

CpuDevice::Owner CpuDevice::owner(size_t pixel) const
{
    if (pixel >= target_.depth.size() || target_.depth[pixel] == kClearDepth) {
        return {};
    }
    return {ItemId{target_.items[pixel]}, target_.triangles[pixel]};
}

} // namespace occlude
