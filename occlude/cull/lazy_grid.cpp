#include <occlude/cull/lazy_grid.h>

#include <algorithm>

namespace occlude {

namespace {

using Variant = LazyGridOptions::Variant;
using Update = LazyGridOptions::Update;
using Traversal = LazyGridOptions::Traversal;
using Source = LazyGridOptions::Source;
using Bounds = LazyGridOptions::Bounds;

// Heaps with the frontmost volume on top. Of equally near volumes, the smallest id comes first.
constexpr auto by_znear = [](const auto& a, const auto& b) {
    return a.bounds.near_depth != b.bounds.near_depth ? a.bounds.near_depth > b.bounds.near_depth
                                                      : a.node > b.node;
};
constexpr auto by_zfar = [](const auto& a, const auto& b) {
    return a.bounds.far_depth != b.bounds.far_depth ? a.bounds.far_depth > b.bounds.far_depth
                                                    : a.node > b.node;
};

template <class Volume, class Order>
Volume pop(std::vector<Volume>& heap, Order order)
{
    std::pop_heap(heap.begin(), heap.end(), order);
    const Volume volume = heap.back();
    heap.pop_back();
    return volume;
}

template <class Volume, class Order>
void push(std::vector<Volume>& heap, const Volume& volume, Order order)
{
    heap.push_back(volume);
    std::push_heap(heap.begin(), heap.end(), order);
}

} // namespace

LazyGrid::LazyGrid(HierarchyRef hierarchy, LazyGridOptions options)
    : Culler(hierarchy)
    , options_(clamped(options))
    , sources_{ReadBackPixels{options_.join, options_.whole_cell_share},
               TiledPixels{options_.whole_cell_share, static_cast<int>(options_.tile)},
               QueriedPixels{options_.join, options_.whole_cell_share}}
{
    if (options_.variant == Variant::occlusion_buffer) {
        // Covered pixels hide a box only if everything that covers them is nearer than the box.
        options_.traversal = Traversal::two_lists;
    }
}

CellPixels& LazyGrid::pixels(const CullFrame& frame)
{
    if (options_.source == Source::queries) {
        return sources_.queries;
    }
    const auto tile_px = static_cast<int>(options_.tile);
    if (tile_px > 1 && frame.caps().find_depth_read(tile_px) != nullptr) {
        return sources_.tiles;
    }
    return sources_.read_back;
}

// --- Figures 2 and 3: the occlusion test ---------------------------------------------------------

bool LazyGrid::is_occluded(CullFrame& frame, const Volume& volume)
{
    if (!volume.bounds.valid) {
        return false; // rule R1
    }
    choose_faces(volume);
    return !internal_cell_is_free_without_pixel_query(volume) &&
           !border_cell_is_free_without_pixel_query(volume) &&
           !internal_cell_is_free_with_pixel_query(frame, volume) &&
           !border_cell_is_free_with_pixel_query(frame, volume);
}

// The answer of is_occluded() if the states of the cells decide it.
LazyGrid::Verdict LazyGrid::verdict_of_states(const Volume& volume)
{
    if (!volume.bounds.valid) {
        return Verdict::visible;
    }
    choose_faces(volume);
    if (internal_cell_is_free_without_pixel_query(volume) ||
        border_cell_is_free_without_pixel_query(volume)) {
        return Verdict::visible;
    }
    return internal_.empty() && border_.empty() ? Verdict::occluded : Verdict::needs_pixels;
}

// Fills internal_, the paper's internalPixelqueryList.
bool LazyGrid::internal_cell_is_free_without_pixel_query(const Volume& volume)
{
    internal_.clear();
    const float znear = depth_to_beat(volume);
    const CellRange cells = internal_cells(volume);
    // If depth is read back, the faces of a box may be hidden at the pixel that is known to be
    // free.
    const bool pixels_tell_more = tested_ != nullptr && options_.source == Source::depth;
    for (int y = cells.begin.y; y < cells.end.y; ++y) {
        for (int x = cells.begin.x; x < cells.end.x; ++x) {
            const OcclusionGrid::Cell& cell = grid_.cell({x, y});
            if (znear > cell.zfar) {
                continue; // an outdated zfar is still an upper bound
            }
            const PixelRect all = grid_.pixels({x, y});
            if (faces_are_behind(cell, all)) {
                continue;
            }
            const bool free = znear <= cell.known_free && (cell.untouched || !pixels_tell_more);
            if (free || is_improbable(cell)) {
                return true;
            }
            internal_.push_back({{x, y}, all});
        }
    }
    return false;
}

// Fills border_, the paper's borderPixelqueryList.
bool LazyGrid::border_cell_is_free_without_pixel_query(const Volume& volume)
{
    border_.clear();
    const float znear = depth_to_beat(volume);
    const CellRange internal = internal_cells(volume);
    const CellRange cells = grid_.touched(volume.bounds.rect);
    for (int y = cells.begin.y; y < cells.end.y; ++y) {
        for (int x = cells.begin.x; x < cells.end.x; ++x) {
            const OcclusionGrid::Cell& cell = grid_.cell({x, y});
            if (internal.contains({x, y}) || znear > cell.zfar) {
                continue;
            }
            const PixelRect part = intersection(grid_.pixels({x, y}), volume.bounds.rect);
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

bool LazyGrid::internal_cell_is_free_with_pixel_query(CullFrame& frame, const Volume& volume)
{
    return pixels_->any_pixel_is_free(frame, grid_, question(volume), internal_);
}

bool LazyGrid::border_cell_is_free_with_pixel_query(CullFrame& frame, const Volume& volume)
{
    return pixels_->any_pixel_is_free(frame, grid_, question(volume), border_);
}

PixelQuestion LazyGrid::question(const Volume& volume)
{
    // Cells are asked only after choose_faces(), so that faces_ belongs to this volume.
    return {volume.node, depth_to_beat(volume), faces_ ? &*faces_ : nullptr};
}

// The depth that all pixels must be nearer than to hide the volume: its znear, or zmax if covered
// pixels hide.
float LazyGrid::depth_to_beat(const Volume& volume)
{
    return covered_hides_ ? pixels_->uncovered_depth() : volume.bounds.near_depth;
}

// Section 6: a large volume has no border cells.
CellRange LazyGrid::internal_cells(const Volume& volume) const
{
    const PixelRect& rect = volume.bounds.rect;
    const bool large =
        options_.internal_above_pixels > 0 && pixel_count(rect) >= options_.internal_above_pixels;
    return large ? grid_.touched(rect) : grid_.internal(rect);
}

// Section 6: so little was drawn into the cell that a look at its pixels is not worth its cost.
bool LazyGrid::is_improbable(const OcclusionGrid::Cell& cell) const
{
    return static_cast<double>(cell.covered) < options_.free_below_covered;
}

// With Bounds::faces, the box of a volume with items is tested as the space between its faces.
void LazyGrid::choose_faces(const Volume& volume)
{
    const bool by_faces = options_.bounds == Bounds::faces && has_objects(volume.node);
    tested_ = by_faces ? &hierarchy().node(volume.node).box : nullptr;
    faces_.reset();
}

// The faces of the tested box, computed at the first call.
const ScreenBox& LazyGrid::faces()
{
    if (!faces_) {
        faces_.emplace(screen_, *tested_);
    }
    return *faces_;
}

// True if, by its faces and the cell's zfar, no point of the box in `part` of the cell is visible.
bool LazyGrid::faces_are_behind(const OcclusionGrid::Cell& cell, const PixelRect& part)
{
    return tested_ != nullptr &&
           faces().beyond(cell.zfar, {part.x, part.y},
                          {part.x + part.width - 1, part.y + part.height - 1});
}

// --- Figures 4 and 6: the traversal --------------------------------------------------------------

void LazyGrid::cull_frame(CullFrame& frame)
{
    initialize(frame);
    insert_if_in_frustum(frame, hierarchy().root(), Frustum::kAllPlanes);
    while (!test_list_.empty() || !draw_list_.empty() || !waiting_.empty()) {
        const bool before_tests = draw_comes_before(frontmost(test_list_));
        if (before_tests && draw_comes_before(waiting_)) {
            draw(frame, pop(draw_list_, by_zfar));
        } else if (!before_tests && !test_list_.empty()) {
            test(frame, pop(test_list_, by_znear));
        } else {
            test_waiting(frame);
        }
    }
}

void LazyGrid::initialize(CullFrame& frame)
{
    pixels_ = &pixels(frame);
    grid_.reset(frame.view().size_px(), static_cast<int>(options_.cell_size));
    if (options_.bounds == Bounds::faces) {
        screen_ = ScreenSpace{frame.view(), frame.samples()};
    }
    // Items with ItemFlags::never_cull are queued before everything else, however far they are.
    // Then a covered pixel proves nothing, and boxes are compared with depth.
    covered_hides_ = options_.variant == Variant::occlusion_buffer && frame.queued_items() == 0;
    test_list_.clear();
    draw_list_.clear();
    waiting_.clear();
}

void LazyGrid::insert_if_in_frustum(CullFrame& frame, NodeId node, PlaneMask mask)
{
    if (frame.visit(node, mask)) {
        const ScreenBounds bounds =
            project(frame.view(), hierarchy().node(node).box, frame.samples());
        push(test_list_, Volume{bounds, node, mask}, by_znear);
    }
}

std::span<const LazyGrid::Volume> LazyGrid::frontmost(std::span<const Volume> heap)
{
    return heap.first(heap.empty() ? 0 : 1);
}

// True if the frontmost volume of the draw list lies wholly before all of `tests`. If the depths
// are equal, the test comes first. So every drawn volume is nearer than all volumes that are not
// tested yet, which the occlusion buffer relies on.
bool LazyGrid::draw_comes_before(std::span<const Volume> tests) const
{
    return !draw_list_.empty() && std::all_of(tests.begin(), tests.end(), [&](const Volume& test) {
        return draw_list_.front().bounds.far_depth < test.bounds.near_depth;
    });
}

// Decides by the states of the cells; if they do not suffice, the volume waits for a look at
// pixels.
void LazyGrid::test(CullFrame& frame, const Volume& volume)
{
    const Verdict verdict = verdict_of_states(volume);
    if (verdict != Verdict::needs_pixels) {
        handle(frame, volume, verdict);
        return;
    }
    waiting_.push_back(volume);
    if (waiting_.size() >= options_.tests_at_once) {
        test_waiting(frame);
    }
}

// Tests all waiting volumes before it draws anything. Then it starts the draws of the visible ones
// at once, so that the device works while the next tests are found.
void LazyGrid::test_waiting(CullFrame& frame)
{
    verdicts_.clear();
    for (const Volume& volume : waiting_) {
        verdicts_.push_back(is_occluded(frame, volume) ? Verdict::occluded : Verdict::visible);
    }
    for (size_t i = 0; i < waiting_.size(); ++i) {
        handle(frame, waiting_[i], verdicts_[i]);
    }
    waiting_.clear();
    if (!test_list_.empty()) {
        frame.start_draws();
    }
}

void LazyGrid::handle(CullFrame& frame, const Volume& volume, Verdict verdict)
{
    if (verdict == Verdict::occluded) {
        frame.decide(volume.node, Decision::hidden);
        return;
    }
    if (!hierarchy().is_leaf(volume.node)) {
        const Node& node = hierarchy().node(volume.node);
        for (uint32_t i = 0; i < node.child_count; ++i) {
            insert_if_in_frustum(frame, NodeId{node.first_child.value + i}, volume.mask);
        }
    }
    if (has_objects(volume.node)) {
        if (options_.traversal == Traversal::two_lists) {
            push(draw_list_, volume, by_zfar);
        } else {
            draw(frame, volume);
        }
    }
}

void LazyGrid::draw(CullFrame& frame, const Volume& volume)
{
    const Decision decision = volume.bounds.valid ? Decision::drawn_revealed : Decision::drawn_near;
    if (hierarchy().is_leaf(volume.node)) {
        frame.draw_leaf(volume.node, volume.mask, decision);
    } else {
        frame.draw_own(volume.node, volume.mask, decision);
    }
    grid_.mark_drawn(volume.bounds.rect);
    if (options_.update == Update::busy) {
        update_busily(frame, volume);
    }
}

// --- section 7: the busy update ------------------------------------------------------------------

// Finds the state of all cells that the drawn volume's rectangle touches, to compare with the lazy
// update.
void LazyGrid::update_busily(CullFrame& frame, const Volume& drawn)
{
    if (options_.source == Source::queries && !covered_hides_) {
        return; // a query answers for one depth, and no box is being tested yet
    }
    internal_.clear();
    const CellRange touched = grid_.touched(drawn.bounds.rect);
    for (int y = touched.begin.y; y < touched.end.y; ++y) {
        for (int x = touched.begin.x; x < touched.end.x; ++x) {
            const bool full = grid_.cell({x, y}).zfar < OcclusionGrid::kFarthest;
            if (!covered_hides_ || !full) {
                internal_.push_back({{x, y}, grid_.pixels({x, y})});
            }
        }
    }
    update_states(frame, drawn.node);
}

void LazyGrid::update_states(CullFrame& frame, NodeId subject)
{
    const PixelQuestion states{subject, pixels_->state_depth()};
    if (options_.join != CellPixels::Join::cell) {
        pixels_->any_pixel_is_free(frame, grid_, states, internal_);
        return;
    }
    for (const AskedCell& asked : internal_) { // one by one, because a free cell would end a
                                               // question over several
        pixels_->any_pixel_is_free(frame, grid_, states, {&asked, 1});
    }
}

} // namespace occlude
