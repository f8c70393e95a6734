#include <occlude/cull/lazy_grid.h>

#include <algorithm>

namespace occlude {

namespace {

using Variant = LazyGridOptions::Variant;
using Update = LazyGridOptions::Update;
using Traversal = LazyGridOptions::Traversal;
using Source = LazyGridOptions::Source;
using Join = LazyGridOptions::Join;
using Bounds = LazyGridOptions::Bounds;

constexpr uint32_t kMaxCellSize = 1 << 15; // pixels

// What the occlusion-buffer variant asks queries about: nearer than zmax, or the rectangle could
// not be drawn at all. Pixels drawn beyond it read as free, which errs toward visible.
constexpr float kAlmostFarthest = 1.0f - 0x1p-18f;

// Farther than any pixel: asks for the state of cells, not for an answer.
constexpr float kBeyondAll = 2.0f;

int64_t area(const PixelRect& rect)
{
    return static_cast<int64_t>(rect.width) * rect.height;
}

} // namespace

LazyGrid::LazyGrid(const Hierarchy& hierarchy, LazyGridOptions options)
    : Culler(hierarchy)
    , options_(options)
{
    options_.cell_size = std::clamp(options_.cell_size, 1u, kMaxCellSize);
    if (options_.variant == Variant::occlusion_buffer) {
        // Covered pixels hide a box only if all that covers them is nearer than the box.
        options_.traversal = Traversal::two_lists;
    }
}

// --- looking at pixels ---

// Makes pixels_ hold the rows of all asked cells as they are now. False if the device cannot.
bool LazyGrid::copy_rows(CullFrame& frame, std::span<const AskedCell> asked)
{
    const glm::ivec2 size = frame.view().size_px();
    int begin = grid_.size_in_cells().y;
    int end = 0;
    for (const AskedCell& a : asked) {
        if (!grid_.cell(a.cell).copied) {
            begin = std::min(begin, a.cell.y);
            end = std::max(end, a.cell.y + 1);
        }
    }
    if (begin >= end) {
        return true;
    }
    if (options_.join == Join::target) {
        begin = 0;
        end = grid_.size_in_cells().y;
    }
    const auto width = static_cast<size_t>(size.x);
    pixels_.resize(width * static_cast<size_t>(size.y));
    const PixelRect first = grid_.pixels({0, begin});
    const PixelRect last = grid_.pixels({0, end - 1});
    const PixelRect rows{0, first.y, size.x, last.y + last.height - first.y};
    const auto out = std::span{pixels_}.subspan(static_cast<size_t>(rows.y) * width,
                                                static_cast<size_t>(rows.height) * width);
    if (!frame.read_depth(rows, out)) {
        return false;
    }
    for (int y = begin; y < end; ++y) {
        for (int x = 0; x < grid_.size_in_cells().x; ++x) {
            grid_.cell({x, y}).copied = true;
        }
    }
    return true;
}

// The first of the pixels of `rect`, with `stride` floats between rows; null if the device cannot.
const float* LazyGrid::pixels_of(CullFrame& frame, const PixelRect& rect, size_t& stride)
{
    if (options_.join != Join::cell) {
        stride = static_cast<size_t>(frame.view().size_px().x);
        return pixels_.data() + static_cast<size_t>(rect.y) * stride + static_cast<size_t>(rect.x);
    }
    stride = static_cast<size_t>(rect.width);
    pixels_.resize(static_cast<size_t>(area(rect)));
    return frame.read_depth(rect, pixels_) ? pixels_.data() : nullptr;
}

bool LazyGrid::any_pixel_is_as_far(CullFrame& frame, std::span<const AskedCell> asked, float depth)
{
    if (options_.join != Join::cell && !copy_rows(frame, asked)) {
        return true;
    }
    for (const AskedCell& a : asked) {
        ++frame.counters().cells_asked;
        const bool whole = asks_whole_cell(a);
        const PixelRect seen = whole ? grid_.pixels(a.cell) : a.part;
        size_t stride = 0;
        const float* pixels = pixels_of(frame, seen, stride);
        if (pixels == nullptr) {
            return true;
        }
        if (whole) {
            grid_.update(a.cell, farthest_depth(pixels, static_cast<size_t>(seen.width),
                                                static_cast<size_t>(seen.height), stride));
        }
        pixels += static_cast<size_t>(a.part.y - seen.y) * stride +
                  static_cast<size_t>(a.part.x - seen.x);
        const bool passes = depth <= farthest_depth(pixels, static_cast<size_t>(a.part.width),
                                                    static_cast<size_t>(a.part.height), stride);
        if (passes && !(tested_ != nullptr && hides(pixels, stride, a.part, faces()))) {
            return true;
        }
    }
    return false;
}

// Adds the test of a rectangle at a constant depth to the batch. False if it cannot be expressed.
bool LazyGrid::add_rectangle(CullFrame& frame, NodeId subject, const PixelRect& rect, float depth,
                             RectangleTest test)
{
    static const Aabb kUnitSquare{glm::vec3{0.0f}, glm::vec3{1.0f, 1.0f, 0.0f}};
    const std::optional<glm::mat4> map = world_from_rectangle(frame.view(), rect, depth);
    if (!map) {
        return false;
    }
    maps_.push_back(*map);
    batch_.add_box(kUnitSquare, maps_.back(), subject);
    batch_.end_test();
    rectangles_.push_back(test);
    return true;
}

// Sec. 5, made conservative: what is tested is not the box but the part of its screen rectangle in
// the cell, at the box's nearest depth.
bool LazyGrid::any_query_passes(CullFrame& frame, NodeId subject, std::span<const AskedCell> asked,
                                float depth)
{
    batch_.clear();
    rectangles_.clear();
    maps_.clear();
    maps_.reserve(2 * asked.size()); // the batch points to them
    bool free = false;
    for (const AskedCell& a : asked) {
        const PixelRect all = grid_.pixels(a.cell);
        if (a.part == all) {
            free |= !add_rectangle(frame, subject, all, depth, {a.cell, true, true});
            continue;
        }
        if (asks_whole_cell(a)) {
            add_rectangle(frame, subject, all, depth, {a.cell, true, false});
        }
        free |= !add_rectangle(frame, subject, a.part, depth, {a.cell, false, true});
    }
    if (batch_.empty()) {
        return free;
    }
    frame.counters().cells_asked += batch_.test_count();
    frame.query(batch_, tickets_);
    for (size_t i = 0; i < tickets_.size(); ++i) {
        const Answer answer = frame.wait(tickets_[i]);
        const RectangleTest& test = rectangles_[i];
        if (!is_visible(answer, 0)) {
            if (test.whole) {
                grid_.learn_hidden(test.cell, depth);
            }
            continue;
        }
        free |= test.part;
        if (answer.state == AnswerState::ready) {
            grid_.learn_free(test.cell, depth);
        }
    }
    return free;
}

bool LazyGrid::any_pixel_passes(CullFrame& frame, NodeId subject, std::span<const AskedCell> asked,
                                float depth)
{
    frame.flush_draws();
    return options_.source == Source::depth ? any_pixel_is_as_far(frame, asked, depth)
                                            : any_query_passes(frame, subject, asked, depth);
}

// Sec. 7, for comparison: after each draw the state of all cells in its image area is found.
void LazyGrid::update_busily(CullFrame& frame, const Entry& entry)
{
    if (options_.source == Source::queries && options_.variant == Variant::z_buffer) {
        return; // a query answers for one depth, and there is no box yet to be tested
    }
    internal_.clear();
    const CellRange touched = grid_.touched(entry.bounds.rect);
    for (int y = touched.begin.y; y < touched.end.y; ++y) {
        for (int x = touched.begin.x; x < touched.end.x; ++x) {
            const bool full = grid_.cell({x, y}).zfar < OcclusionGrid::kFarthest;
            if (options_.variant == Variant::z_buffer || !full) {
                internal_.push_back({{x, y}, grid_.pixels({x, y})});
            }
        }
    }
    const float depth = options_.source == Source::depth ? kBeyondAll : kAlmostFarthest;
    if (options_.join != Join::cell) {
        any_pixel_passes(frame, entry.node, internal_, depth);
        return;
    }
    for (const AskedCell& asked : internal_) {
        any_pixel_passes(frame, entry.node, {&asked, 1}, depth);
    }
}

// --- the occlusion test ---

// What is hidden where all pixels are nearer than this.
float LazyGrid::depth_to_beat(const ScreenBounds& bounds) const
{
    if (options_.variant == Variant::z_buffer) {
        return bounds.near_depth;
    }
    return options_.source == Source::depth ? OcclusionGrid::kFarthest : kAlmostFarthest;
}

// Of the box that is tested, made when they are first needed.
const ScreenBox& LazyGrid::faces()
{
    if (!faces_) {
        faces_.emplace(screen_, *tested_);
    }
    return *faces_;
}

// True if nothing of the box in `part` of the cell can be seen, by what its faces and the cell
// tell.
bool LazyGrid::faces_are_behind(const OcclusionGrid::Cell& cell, const PixelRect& part)
{
    return tested_ != nullptr &&
           faces().beyond(cell.zfar, {part.x, part.y},
                          {part.x + part.width - 1, part.y + part.height - 1});
}

// Sec. 6: so little was drawn into the cell that it is not worth asking.
bool LazyGrid::is_improbable(const OcclusionGrid::Cell& cell) const
{
    return static_cast<double>(cell.covered) < options_.free_below_covered;
}

// Sec. 6: so much of the cell is to be looked at that one may as well look at all of it.
bool LazyGrid::asks_whole_cell(const AskedCell& asked) const
{
    const PixelRect all = grid_.pixels(asked.cell);
    return asked.part == all || (options_.whole_cell_share > 0.0 &&
                                 static_cast<double>(area(asked.part)) >=
                                     options_.whole_cell_share * static_cast<double>(area(all)));
}

bool LazyGrid::internal_cell_is_free_without_pixel_query(const CellRange& internal, float depth)
{
    internal_.clear();
    // The faces of a box need not be where the pixel is that is known to be free.
    const bool pixels_tell_more = tested_ != nullptr && options_.source == Source::depth;
    for (int y = internal.begin.y; y < internal.end.y; ++y) {
        for (int x = internal.begin.x; x < internal.end.x; ++x) {
            const OcclusionGrid::Cell& cell = grid_.cell({x, y});
            if (depth > cell.zfar) {
                continue; // an old zfar is still an upper bound
            }
            const PixelRect pixels = grid_.pixels({x, y});
            if (faces_are_behind(cell, pixels)) {
                continue;
            }
            const bool free = depth <= cell.known_free && (cell.untouched || !pixels_tell_more);
            if (free || is_improbable(cell)) {
                return true;
            }
            internal_.push_back({{x, y}, pixels});
        }
    }
    return false;
}

bool LazyGrid::border_cell_is_free_without_pixel_query(const CellRange& touched,
                                                       const CellRange& internal,
                                                       const PixelRect& rect, float depth)
{
    border_.clear();
    for (int y = touched.begin.y; y < touched.end.y; ++y) {
        for (int x = touched.begin.x; x < touched.end.x; ++x) {
            const OcclusionGrid::Cell& cell = grid_.cell({x, y});
            if (internal.contains({x, y}) || depth > cell.zfar) {
                continue;
            }
            const PixelRect part = intersection(grid_.pixels({x, y}), rect);
            if (faces_are_behind(cell, part)) {
                continue;
            }
            if (cell.untouched || is_improbable(cell)) {
                return true;
            }
            border_.push_back({{x, y}, part});
        }
    }
    return false;
}

bool LazyGrid::any_cell_is_free_with_pixel_query(CullFrame& frame, NodeId subject,
                                                 std::span<const AskedCell> asked, float depth)
{
    if (asked.empty()) {
        return false;
    }
    if (options_.join != Join::cell) {
        return any_pixel_passes(frame, subject, asked, depth);
    }
    return std::any_of(asked.begin(), asked.end(), [&](const AskedCell& cell) {
        return any_pixel_passes(frame, subject, {&cell, 1}, depth);
    });
}

// The first half of isOccluded: what the grid knows. Fills internal_ and border_ with the cells
// that must be asked otherwise.
LazyGrid::Verdict LazyGrid::verdict_without_pixels(const Entry& entry)
{
    if (!entry.bounds.valid) {
        return Verdict::visible;
    }
    tested_ = options_.bounds == Bounds::faces && has_items(entry.node)
                  ? &hierarchy().node(entry.node).box
                  : nullptr;
    faces_.reset();
    const float depth = depth_to_beat(entry.bounds);
    const PixelRect& rect = entry.bounds.rect;
    const CellRange touched = grid_.touched(rect);
    const bool large = options_.internal_above_pixels > 0 &&
                       static_cast<uint64_t>(area(rect)) >= options_.internal_above_pixels;
    const CellRange internal = large ? touched : grid_.internal(rect);
    if (internal_cell_is_free_without_pixel_query(internal, depth) ||
        border_cell_is_free_without_pixel_query(touched, internal, rect, depth)) {
        return Verdict::visible;
    }
    return internal_.empty() && border_.empty() ? Verdict::occluded : Verdict::needs_pixels;
}

bool LazyGrid::is_occluded(CullFrame& frame, const Entry& entry)
{
    const Verdict verdict = verdict_without_pixels(entry);
    if (verdict != Verdict::needs_pixels) {
        return verdict == Verdict::occluded;
    }
    const float depth = depth_to_beat(entry.bounds);
    return !any_cell_is_free_with_pixel_query(frame, entry.node, internal_, depth) &&
           !any_cell_is_free_with_pixel_query(frame, entry.node, border_, depth);
}

// --- the traversal ---

namespace {

// Heaps with the nearest entry in front; of equally near ones that with the smallest id.
constexpr auto by_nearest_depth = [](const auto& a, const auto& b) {
    return a.bounds.near_depth != b.bounds.near_depth ? a.bounds.near_depth > b.bounds.near_depth
                                                      : a.node > b.node;
};
constexpr auto by_farthest_depth = [](const auto& a, const auto& b) {
    return a.bounds.far_depth != b.bounds.far_depth ? a.bounds.far_depth > b.bounds.far_depth
                                                    : a.node > b.node;
};

template <class Entry, class Order>
Entry pop(std::vector<Entry>& heap, Order order)
{
    std::pop_heap(heap.begin(), heap.end(), order);
    const Entry entry = heap.back();
    heap.pop_back();
    return entry;
}

template <class Entry, class Order>
void push(std::vector<Entry>& heap, const Entry& entry, Order order)
{
    heap.push_back(entry);
    std::push_heap(heap.begin(), heap.end(), order);
}

} // namespace

void LazyGrid::insert(CullFrame& frame, NodeId node, PlaneMask mask)
{
    if (frame.visit(node, mask)) {
        const ScreenBounds bounds =
            project(frame.view(), hierarchy().node(node).box, frame.samples());
        push(test_list_, Entry{bounds, node, mask}, by_nearest_depth);
    }
}

void LazyGrid::draw(CullFrame& frame, const Entry& entry)
{
    const Decision decision = entry.bounds.valid ? Decision::drawn_revealed : Decision::drawn_near;
    if (hierarchy().is_leaf(entry.node)) {
        frame.draw_leaf(entry.node, entry.mask, decision);
    } else {
        frame.draw_own(entry.node, entry.mask, decision);
    }
    grid_.mark_drawn(entry.bounds.rect);
    if (options_.update == Update::busy) {
        update_busily(frame, entry);
    }
}

void LazyGrid::test(CullFrame& frame, const Entry& entry)
{
    const Verdict verdict = verdict_without_pixels(entry);
    if (verdict != Verdict::needs_pixels) {
        handle(frame, entry, verdict);
        return;
    }
    waiting_.push_back(entry);
    if (waiting_.size() >= options_.tests_at_once) {
        test_waiting(frame);
    }
}

// All of them first, so that nothing is drawn between one look at pixels and the next. The device
// can draw what they reveal while the next ones are found.
void LazyGrid::test_waiting(CullFrame& frame)
{
    verdicts_.clear();
    for (const Entry& entry : waiting_) {
        verdicts_.push_back(is_occluded(frame, entry) ? Verdict::occluded : Verdict::visible);
    }
    for (size_t i = 0; i < waiting_.size(); ++i) {
        handle(frame, waiting_[i], verdicts_[i]);
    }
    waiting_.clear();
    if (options_.tests_at_once > 1 && !test_list_.empty()) {
        frame.start_draws();
    }
}

void LazyGrid::handle(CullFrame& frame, const Entry& entry, Verdict verdict)
{
    if (verdict == Verdict::occluded) {
        frame.decide(entry.node, Decision::hidden);
        return;
    }
    if (!hierarchy().is_leaf(entry.node)) {
        const Node& node = hierarchy().node(entry.node);
        for (uint32_t i = 0; i < node.child_count; ++i) {
            insert(frame, NodeId{node.first_child.value + i}, entry.mask);
        }
    }
    if (has_items(entry.node)) {
        if (options_.traversal == Traversal::two_lists) {
            push(draw_list_, entry, by_farthest_depth);
        } else {
            draw(frame, entry);
        }
    }
}

// With equal depths the test comes first: what is drawn is then wholly nearer than what is not
// tested yet, as the occlusion buffer needs it.
bool LazyGrid::draw_comes_before(std::span<const Entry> tests) const
{
    return !draw_list_.empty() && std::all_of(tests.begin(), tests.end(), [&](const Entry& test) {
        return draw_list_.front().bounds.far_depth < test.bounds.near_depth;
    });
}

void LazyGrid::cull_frame(CullFrame& frame)
{
    grid_.reset(frame.view().size_px(), static_cast<int>(options_.cell_size));
    if (options_.bounds == Bounds::faces) {
        screen_ = ScreenSpace{frame.view(), frame.samples()};
    }
    test_list_.clear();
    draw_list_.clear();
    waiting_.clear();
    insert(frame, hierarchy().root(), Frustum::kAllPlanes);
    while (!test_list_.empty() || !draw_list_.empty() || !waiting_.empty()) {
        // The first of a heap is the nearest of all in it.
        const bool before_next_test =
            draw_comes_before(std::span{test_list_}.first(test_list_.empty() ? 0 : 1));
        if (before_next_test && draw_comes_before(waiting_)) {
            draw(frame, pop(draw_list_, by_farthest_depth));
        } else if (!before_next_test && !test_list_.empty()) {
            test(frame, pop(test_list_, by_nearest_depth));
        } else {
            test_waiting(frame);
        }
    }
}

} // namespace occlude
