#include <occlude/backends/cpu_fast/occluder_buffer.h>

#include <occlude/backends/cpu_fast/detail/mesh_setup.h>
#include <occlude/backends/cpu_fast/detail/tile_raster.h>
#include <occlude/backends/cpu_fast/detail/workers.h>
#include <occlude/core/assert.h>
#include <occlude/screen/depth_pyramid.h>
#include <occlude/screen/projection.h>

#include <algorithm>
#include <array>
#include <vector>

namespace occlude {

namespace {

// Instances are handed to threads in this many batches each, so that none waits long for another.
constexpr size_t kBatchesPerThread = 4;

constexpr size_t kBoxesAtOnce = 64;

// The pixels of the rectangle inside of a target of this size; without overflow.
PixelRect clipped(const PixelRect& rect, glm::ivec2 size)
{
    const int64_t x0 = std::max(rect.x, 0);
    const int64_t y0 = std::max(rect.y, 0);
    const int64_t x1 = std::min<int64_t>(int64_t{rect.x} + rect.width, size.x);
    const int64_t y1 = std::min<int64_t>(int64_t{rect.y} + rect.height, size.y);
    if (x0 >= x1 || y0 >= y1) {
        return {};
    }
    return {static_cast<int>(x0), static_cast<int>(y0), static_cast<int>(x1 - x0),
            static_cast<int>(y1 - y0)};
}

} // namespace

struct OccluderBuffer::State {
    struct Instance {
        const OccluderMesh* mesh;
        glm::mat4 world_from_mesh;
    };

    explicit State(const OccluderBufferOptions& given);

    void set_up(size_t batch);
    void fill(size_t tile);
    void refresh();
    PixelRect cells_of(const PixelRect& rect_px) const;
    Visibility test(const PixelRect& rect_px, float nearest) const;

    OccluderBufferOptions options;
    cpu_fast::Workers workers;
    View view;
    cpu_fast::Grid grid;
    std::vector<Instance> pending;
    std::vector<size_t> batch_ends; ///< into `pending`
    std::vector<cpu_fast::PrimBatch> batches;
    std::vector<cpu_fast::MeshSetup> setups; ///< one per batch
    std::span<float> depth;
    DepthPyramid pyramid; ///< its pixels are the cells
    bool pyramid_fresh = false;
    OccluderStatistics statistics;
};

OccluderBuffer::State::State(const OccluderBufferOptions& given)
    : options(given)
    , workers(given.threads)
{
    options.cell_px = std::clamp(options.cell_px, 1, 16);
    batches.resize(workers.count() > 1 ? workers.count() * kBatchesPerThread : 1);
    setups.resize(batches.size());
}

OccluderBuffer::OccluderBuffer(const OccluderBufferOptions& options)
    : state_(std::make_unique<State>(options))
{
}

OccluderBuffer::~OccluderBuffer() = default;
OccluderBuffer::OccluderBuffer(OccluderBuffer&&) noexcept = default;
OccluderBuffer& OccluderBuffer::operator=(OccluderBuffer&&) noexcept = default;

void OccluderBuffer::begin(const View& view)
{
    State& s = *state_;
    s.view = view;
    s.pending.clear();
    s.statistics = {};
    const glm::ivec2 size = view.size_px();
    const int most = cpu_fast::kMaxSide * s.options.cell_px;
    const bool usable =
        view.usable() && size.x > 0 && size.y > 0 && size.x <= most && size.y <= most;
    s.grid = usable ? cpu_fast::Grid(size, s.options.cell_px) : cpu_fast::Grid{};
    s.depth = s.pyramid.resize(s.grid.size_cells);
    std::ranges::fill(s.depth, 1.0f);
    s.pyramid_fresh = false;
}

void OccluderBuffer::add(const OccluderMesh& mesh, const glm::mat4& world_from_mesh)
{
    if (!state_->depth.empty() && !mesh.empty()) {
        state_->pending.push_back({&mesh, world_from_mesh});
    }
}

// Transforms one batch of instances.
void OccluderBuffer::State::set_up(size_t batch)
{
    cpu_fast::PrimBatch& out = batches[batch];
    out.clear(grid.tile_count());
    const size_t begin = batch == 0 ? 0 : batch_ends[batch - 1];
    for (size_t i = begin; i < batch_ends[batch]; ++i) {
        const OccluderMesh& mesh = *pending[i].mesh;
        const cpu_fast::InstanceTransform transform(view, grid, pending[i].world_from_mesh,
                                                    mesh.box());
        if (transform.usable) {
            ++out.instances;
            out.triangles += mesh.triangles().size();
            setups[batch].add(mesh, transform, grid, out);
        }
    }
}

void OccluderBuffer::State::fill(size_t tile)
{
    cpu_fast::PieceTile scratch;
    const int tx = static_cast<int>(tile) % grid.size_tiles.x;
    const int ty = static_cast<int>(tile) / grid.size_tiles.x;
    const int x = tx * cpu_fast::kTileWidth;
    const int y = ty * cpu_fast::kTileHeight;
    const cpu_fast::DepthTile target{
        depth.data() + static_cast<ptrdiff_t>(y) * grid.size_cells.x + x, grid.size_cells.x,
        std::min(cpu_fast::kTileWidth, grid.size_cells.x - x)};
    cpu_fast::fill_tile(cpu_fast::tile_kernels(options.kernel),
                        std::span{batches}.first(batch_ends.size()), tx, ty, tile, target, scratch);
}

void OccluderBuffer::rasterize()
{
    State& s = *state_;
    if (s.pending.empty()) {
        return;
    }
    // Batches of about as many triangles each.
    size_t triangles = 0;
    for (const State::Instance& instance : s.pending) {
        triangles += instance.mesh->triangles().size();
    }
    const size_t per_batch = triangles / s.batches.size() + 1;
    s.batch_ends.clear();
    size_t in_batch = 0;
    for (size_t i = 0; i < s.pending.size(); ++i) {
        in_batch += s.pending[i].mesh->triangles().size();
        if (in_batch >= per_batch && s.batch_ends.size() + 1 < s.batches.size()) {
            s.batch_ends.push_back(i + 1);
            in_batch = 0;
        }
    }
    s.batch_ends.push_back(s.pending.size());
    s.workers.for_each(s.batch_ends.size(), [&](size_t batch) { s.set_up(batch); });
    s.workers.for_each(s.grid.tile_count(), [&](size_t tile) { s.fill(tile); });
    for (size_t i = 0; i < s.batch_ends.size(); ++i) {
        s.statistics.instances += s.batches[i].instances;
        s.statistics.triangles += s.batches[i].triangles;
        s.statistics.filled += s.batches[i].prims.size();
    }
    s.pending.clear();
    s.pyramid_fresh = false;
}

void OccluderBuffer::State::refresh()
{
    if (!pyramid_fresh) {
        pyramid.build(options.kernel);
        pyramid_fresh = true;
    }
}

// The cells that some of the pixels lie in.
PixelRect OccluderBuffer::State::cells_of(const PixelRect& rect) const
{
    const int cell = options.cell_px;
    const int x = rect.x / cell;
    const int y = rect.y / cell;
    return {x, y, (rect.x + rect.width - 1) / cell - x + 1,
            (rect.y + rect.height - 1) / cell - y + 1};
}

Visibility OccluderBuffer::State::test(const PixelRect& rect_px, float nearest) const
{
    const PixelRect rect = clipped(rect_px, grid.size_px);
    if (rect.width <= 0 || rect.height <= 0) {
        return Visibility::outside;
    }
    return pyramid.hides(cells_of(rect), nearest) ? Visibility::hidden : Visibility::visible;
}

Visibility OccluderBuffer::test(const Aabb& box_world) const
{
    Visibility result = Visibility::visible;
    test(std::span{&box_world, 1}, std::span{&result, 1});
    return result;
}

void OccluderBuffer::test(std::span<const Aabb> boxes, std::span<Visibility> results) const
{
    OCCLUDE_ASSERT(boxes.size() == results.size(), "OccluderBuffer::test needs a result per box");
    State& s = *state_;
    if (boxes.size() != results.size() || s.depth.empty()) {
        std::ranges::fill(results, Visibility::visible);
        return;
    }
    s.refresh();
    std::array<ScreenBounds, kBoxesAtOnce> bounds;
    for (size_t first = 0; first < boxes.size(); first += kBoxesAtOnce) {
        const size_t count = std::min(kBoxesAtOnce, boxes.size() - first);
        project_boxes(s.view, boxes.subspan(first, count), std::span{bounds}.first(count),
                      s.options.kernel);
        for (size_t i = 0; i < count; ++i) {
            results[first + i] = bounds[i].valid ? s.test(bounds[i].rect, bounds[i].near_depth)
                                                 : Visibility::visible;
        }
    }
}

Visibility OccluderBuffer::test(const PixelRect& rect_px, float nearest) const
{
    State& s = *state_;
    if (s.depth.empty()) {
        return Visibility::visible;
    }
    s.refresh();
    return s.test(rect_px, nearest);
}

const View& OccluderBuffer::view() const
{
    return state_->view;
}

glm::ivec2 OccluderBuffer::size_cells() const
{
    return state_->grid.size_cells;
}

int OccluderBuffer::cell_px() const
{
    return state_->options.cell_px;
}

std::span<const float> OccluderBuffer::depth() const
{
    return state_->depth;
}

const OccluderStatistics& OccluderBuffer::statistics() const
{
    return state_->statistics;
}

bool OccluderBuffer::read_depth(const PixelRect& rect, std::span<float> out) const
{
    const State& s = *state_;
    if (s.depth.empty() || !is_inside(rect, s.grid.size_px) || out.size() != pixel_count(rect)) {
        return false;
    }
    const int cell = s.options.cell_px;
    for (int row = 0; row < rect.height; ++row) {
        float* to = out.data() + static_cast<ptrdiff_t>(row) * rect.width;
        const int y = rect.y + row;
        if (row > 0 && y % cell != 0) {
            std::copy(to - rect.width, to, to);
            continue;
        }
        const float* from = s.depth.data() + static_cast<ptrdiff_t>(y / cell) * s.grid.size_cells.x;
        if (cell == 1) {
            std::copy(from + rect.x, from + rect.x + rect.width, to);
            continue;
        }
        int x = rect.x;
        while (x < rect.x + rect.width) { // a cell at a time
            const int end = std::min((x / cell + 1) * cell, rect.x + rect.width);
            std::fill(to + (x - rect.x), to + (end - rect.x), from[x / cell]);
            x = end;
        }
    }
    return true;
}

} // namespace occlude
