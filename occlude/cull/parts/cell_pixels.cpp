#include <occlude/cull/parts/cell_pixels.h>

#include <occlude/core/assert.h>
#include <occlude/screen/projection.h>

#include <algorithm>
#include <optional>

namespace occlude {

bool CellPixels::asks_whole_cell(const OcclusionGrid& grid, const AskedCell& asked) const
{
    const PixelRect all = grid.pixels(asked.cell);
    return asked.part == all || (whole_cell_share_ > 0.0 &&
                                 static_cast<double>(pixel_count(asked.part)) >=
                                     whole_cell_share_ * static_cast<double>(pixel_count(all)));
}

bool CellPixels::any_pixel_is_free(CullFrame& frame, OcclusionGrid& grid,
                                   const PixelQuestion& question, std::span<const AskedCell> cells)
{
    if (cells.empty()) {
        return false;
    }
    OCCLUDE_ASSERT(question.depth >= 0.0f, "a question about pixels needs a window depth");
    frame.flush_draws();
    if (join_ != Join::cell) {
        return look(frame, grid, question, cells);
    }
    return std::any_of(cells.begin(), cells.end(), [&](const AskedCell& cell) {
        return look(frame, grid, question, {&cell, 1});
    });
}

// --- read-back -----------------------------------------------------------------------------------

bool ReadBackPixels::look(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
                          std::span<const AskedCell> cells)
{
    if (join() != Join::cell && !copy_rows(frame, grid, cells)) {
        return true;
    }
    for (const AskedCell& a : cells) {
        ++frame.counters().cells_asked;
        const bool whole = asks_whole_cell(grid, a);
        const PixelRect seen = whole ? grid.pixels(a.cell) : a.part;
        size_t stride = 0;
        const float* pixels = pixels_of(frame, seen, stride);
        if (pixels == nullptr) {
            return true;
        }
        if (whole) {
            grid.update(a.cell, farthest_depth(pixels, static_cast<size_t>(seen.width),
                                               static_cast<size_t>(seen.height), stride));
        }
        pixels += static_cast<size_t>(a.part.y - seen.y) * stride +
                  static_cast<size_t>(a.part.x - seen.x);
        const float farthest = farthest_depth(pixels, static_cast<size_t>(a.part.width),
                                              static_cast<size_t>(a.part.height), stride);
        if (question.depth <= farthest &&
            !(question.faces != nullptr && hides(pixels, stride, a.part, *question.faces))) {
            return true;
        }
    }
    return false;
}

static void mark_copied(OcclusionGrid& grid, int first_row, int end_row)
{
    for (int y = first_row; y < end_row; ++y) {
        for (int x = 0; x < grid.size_in_cells().x; ++x) {
            grid.cell({x, y}).copied = true;
        }
    }
}

// Reads the rows of all asked cells into pixels_. False if the device cannot.
bool ReadBackPixels::copy_rows(CullFrame& frame, OcclusionGrid& grid,
                               std::span<const AskedCell> cells)
{
    int begin = grid.size_in_cells().y;
    int end = 0;
    for (const AskedCell& a : cells) {
        if (!grid.cell(a.cell).copied) {
            begin = std::min(begin, a.cell.y);
            end = std::max(end, a.cell.y + 1);
        }
    }
    if (begin >= end) {
        return true;
    }
    if (join() == Join::target) {
        begin = 0;
        end = grid.size_in_cells().y;
    }
    const glm::ivec2 size = frame.view().size_px();
    const auto width = static_cast<size_t>(size.x);
    pixels_.resize(width * static_cast<size_t>(size.y));
    const PixelRect first = grid.pixels({0, begin});
    const PixelRect last = grid.pixels({0, end - 1});
    const PixelRect rows{0, first.y, size.x, last.y + last.height - first.y};
    const auto out = std::span{pixels_}.subspan(static_cast<size_t>(rows.y) * width,
                                                static_cast<size_t>(rows.height) * width);
    if (!frame.read_depth(rows, out)) {
        return false;
    }
    mark_copied(grid, begin, end);
    return true;
}

// Reads `rect` and returns its first pixel, with `stride` floats between rows; null if the device
// cannot.
const float* ReadBackPixels::pixels_of(CullFrame& frame, const PixelRect& rect, size_t& stride)
{
    if (join() != Join::cell) {
        stride = static_cast<size_t>(frame.view().size_px().x);
        return pixels_.data() + static_cast<size_t>(rect.y) * stride + static_cast<size_t>(rect.x);
    }
    stride = static_cast<size_t>(rect.width);
    pixels_.resize(pixel_count(rect));
    return frame.read_depth(rect, pixels_) ? pixels_.data() : nullptr;
}

// --- tiles ---------------------------------------------------------------------------------------

bool TiledPixels::look(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
                       std::span<const AskedCell> cells)
{
    const bool all_copied = std::all_of(
        cells.begin(), cells.end(), [&](const AskedCell& a) { return grid.cell(a.cell).copied; });
    if (!all_copied && !read(frame, grid)) {
        return true;
    }
    for (const AskedCell& a : cells) {
        ++frame.counters().cells_asked;
        if (asks_whole_cell(grid, a)) {
            grid.update(a.cell, farthest(grid.pixels(a.cell)));
        }
        if (any_tile_is_free(question, a.part)) {
            return true;
        }
    }
    return false;
}

// Reads the tiles of the whole target into tiles_. False if the device cannot.
bool TiledPixels::read(CullFrame& frame, OcclusionGrid& grid)
{
    size_in_tiles_ = tiles_in(frame.view().size_px(), tile_px_);
    tiles_.resize(pixel_count(size_in_tiles_));
    if (!frame.read_depth_tiles(tile_px_, tiles_)) {
        return false;
    }
    mark_copied(grid, 0, grid.size_in_cells().y);
    return true;
}

// An upper bound of the depths in `rect`, because a tile may reach beyond it.
float TiledPixels::farthest(const PixelRect& rect) const
{
    const glm::ivec2 low{rect.x / tile_px_, rect.y / tile_px_};
    const glm::ivec2 high{(rect.x + rect.width - 1) / tile_px_,
                          (rect.y + rect.height - 1) / tile_px_};
    const auto stride = static_cast<size_t>(size_in_tiles_.x);
    return farthest_depth(
        tiles_.data() + static_cast<size_t>(low.y) * stride + static_cast<size_t>(low.x),
        static_cast<size_t>(high.x - low.x + 1), static_cast<size_t>(high.y - low.y + 1), stride);
}

bool TiledPixels::any_tile_is_free(const PixelQuestion& question, const PixelRect& part) const
{
    if (question.faces == nullptr) {
        return question.depth <= farthest(part);
    }
    const int end_x = part.x + part.width;
    const int end_y = part.y + part.height;
    for (int y = part.y - part.y % tile_px_; y < end_y; y += tile_px_) {
        for (int x = part.x - part.x % tile_px_; x < end_x; x += tile_px_) {
            const float tile = farthest({x, y, 1, 1});
            const glm::ivec2 low{std::max(x, part.x), std::max(y, part.y)};
            const glm::ivec2 high{std::min(x + tile_px_, end_x) - 1,
                                  std::min(y + tile_px_, end_y) - 1};
            if (question.depth <= tile && !question.faces->beyond(double{tile}, low, high)) {
                return true;
            }
        }
    }
    return false;
}

// --- queries -------------------------------------------------------------------------------------

// An answer of 0 samples means: nearer than zmax, or the rectangle could not be drawn at all. A
// pixel that was drawn into beyond this depth counts as free, which errs toward visible.
float QueriedPixels::uncovered_depth() const
{
    return 1.0f - 0x1p-18f;
}

bool QueriedPixels::look(CullFrame& frame, OcclusionGrid& grid, const PixelQuestion& question,
                         std::span<const AskedCell> cells)
{
    batch_.clear();
    rectangles_.clear();
    maps_.clear();
    maps_.reserve(2 * cells.size()); // keeps the matrices where they are: the batch points to them
    bool free = false;
    for (const AskedCell& a : cells) {
        const PixelRect all = grid.pixels(a.cell);
        if (a.part == all) {
            free |= !add_rectangle(frame.view(), question, all, {a.cell, true, true});
            continue;
        }
        if (asks_whole_cell(grid, a)) {
            add_rectangle(frame.view(), question, all, {a.cell, true, false});
        }
        free |= !add_rectangle(frame.view(), question, a.part, {a.cell, false, true});
    }
    return (!batch_.empty() && read_answers(frame, grid, question.depth)) || free;
}

// Adds the test of a rectangle at the question's depth to the batch. False if the rectangle cannot
// be tested.
bool QueriedPixels::add_rectangle(const View& view, const PixelQuestion& question,
                                  const PixelRect& rect, RectangleTest test)
{
    static const Aabb kUnitSquare{glm::vec3{0.0f}, glm::vec3{1.0f, 1.0f, 0.0f}};
    const std::optional<glm::mat4> map = world_from_rectangle(view, rect, question.depth);
    if (!map) {
        return false;
    }
    maps_.push_back(*map);
    batch_.add_box(kUnitSquare, maps_.back(), question.subject);
    batch_.end_test();
    rectangles_.push_back(test);
    return true;
}

bool QueriedPixels::read_answers(CullFrame& frame, OcclusionGrid& grid, float depth)
{
    frame.counters().cells_asked += batch_.test_count();
    frame.query(batch_, tickets_);
    bool free = false;
    for (size_t i = 0; i < tickets_.size(); ++i) {
        const Answer answer = frame.wait(tickets_[i]);
        const RectangleTest& test = rectangles_[i];
        if (!is_visible(answer, 0)) {
            if (test.whole) {
                grid.learn_hidden(test.cell, depth);
            }
            continue;
        }
        free |= test.part;
        if (answer.state == AnswerState::ready) {
            grid.learn_free(test.cell, depth);
        }
    }
    return free;
}

} // namespace occlude
