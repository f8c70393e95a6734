#include <occlude/backends/cpu_fast/occluder_buffer.h>

#include <occlude/backends/cpu_fast/detail/bin_raster.h>
#include <occlude/backends/cpu_fast/detail/masked_depth.h>
#include <occlude/backends/cpu_fast/detail/mesh_setup.h>
#include <occlude/backends/cpu_fast/detail/workers.h>
#include <occlude/core/assert.h>
#include <occlude/screen/projection.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

namespace occlude {

namespace {

// A round is set up and filled before the next one starts: its prims stay in the caches. It is
// handed to threads in several batches each, so that none waits long for another.
constexpr size_t kBatchesPerThread = 4;
constexpr size_t kTrianglesPerThread = 4096;

constexpr size_t kBoxesAtOnce = 64;
constexpr size_t kInstancesAtOnce = 64; // of which one thread finds the places

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
        cpu_fast::InstanceTransform transform;
    };

    explicit State(const OccluderBufferOptions& given);

    void place(size_t chunk);
    void sort_instances();
    void make_batches(size_t begin);
    void set_up(size_t batch);
    void fill(size_t bin);
    std::span<const float> expanded_depth();
    cpu_fast::CellRect cells_of(const PixelRect& rect_px) const;
    Visibility test(const PixelRect& rect_px, float nearest) const;

    OccluderBufferOptions options;
    cpu_fast::Workers workers;
    View view;
    cpu_fast::Grid grid;
    std::vector<Instance> pending;
    std::vector<uint32_t> order; ///< into `pending`, near ones first
    size_t batches_begin = 0;    ///< of a round, into `order`
    std::vector<size_t> batch_ends;
    size_t triangles_per_batch = 0;
    std::vector<cpu_fast::PrimBatch> batches;
    std::vector<cpu_fast::MeshSetup> setups; ///< one per batch
    cpu_fast::MaskedDepth depth;
    std::vector<float> expanded; ///< depth by cells, where somebody asked for it
    bool expanded_fresh = false;
    OccluderStatistics statistics;
};

OccluderBuffer::State::State(const OccluderBufferOptions& given)
    : options(given)
    , workers(given.threads)
{
    options.cell_px = std::clamp(options.cell_px, 1, 16);
    batches.resize(workers.count() > 1 ? workers.count() * kBatchesPerThread : 1);
    setups.resize(batches.size());
    triangles_per_batch = kTrianglesPerThread * workers.count() / batches.size();
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
    s.depth.clear(s.grid);
    s.expanded_fresh = false;
}

void OccluderBuffer::add(const OccluderMesh& mesh, const glm::mat4& world_from_mesh)
{
    if (state_->grid.bin_count() != 0 && !mesh.empty()) {
        state_->pending.push_back({&mesh, world_from_mesh, {}});
    }
}

// Finds where one chunk of the instances lies.
void OccluderBuffer::State::place(size_t chunk)
{
    const size_t end = std::min((chunk + 1) * kInstancesAtOnce, pending.size());
    for (size_t i = chunk * kInstancesAtOnce; i < end; ++i) {
        Instance& instance = pending[i];
        instance.transform =
            cpu_fast::InstanceTransform(view, grid, instance.world_from_mesh, instance.mesh->box());
    }
}

// Leaves out what is outside, and puts near ones to the front: what is filled first hides most, and
// the two layers of the masked depth lose least.
void OccluderBuffer::State::sort_instances()
{
    order.clear();
    for (uint32_t i = 0; i < pending.size(); ++i) {
        if (pending[i].transform.usable) {
            order.push_back(i);
            statistics.triangles += pending[i].mesh->triangles().size();
        }
    }
    std::ranges::sort(order, {}, [&](uint32_t i) {
        const cpu_fast::InstanceTransform& transform = pending[i].transform;
        return std::tuple{transform.nearest, transform.tie_break, i};
    });
    statistics.instances += order.size();
}

// The instances of the round that starts at `begin`, in batches of about as many triangles each.
void OccluderBuffer::State::make_batches(size_t begin)
{
    batch_ends.clear();
    size_t in_batch = 0;
    size_t i = begin;
    for (; i < order.size() && batch_ends.size() < batches.size(); ++i) {
        in_batch += pending[order[i]].mesh->triangles().size();
        if (in_batch >= triangles_per_batch) {
            batch_ends.push_back(i + 1);
            in_batch = 0;
        }
    }
    if (in_batch != 0) {
        batch_ends.push_back(i);
    }
    batches_begin = begin;
}

// Transforms one batch of instances.
void OccluderBuffer::State::set_up(size_t batch)
{
    cpu_fast::PrimBatch& out = batches[batch];
    out.clear(grid.bin_count());
    const cpu_fast::SetupKernels& kernels = cpu_fast::setup_kernels(options.kernel);
    const size_t begin = batch == 0 ? batches_begin : batch_ends[batch - 1];
    for (size_t i = begin; i < batch_ends[batch]; ++i) {
        const Instance& instance = pending[order[i]];
        setups[batch].add(*instance.mesh, instance.transform, grid, kernels, out);
    }
}

void OccluderBuffer::State::fill(size_t bin)
{
    const auto used = std::span{batches}.first(batch_ends.size());
    if (std::ranges::all_of(used, [&](const auto& batch) { return batch.bins[bin].empty(); })) {
        return;
    }
    cpu_fast::PieceBin scratch;
    const auto across = static_cast<size_t>(grid.size_bins.x);
    const int x = static_cast<int>(bin % across) * cpu_fast::kBinWidth;
    const int y = static_cast<int>(bin / across) * cpu_fast::kBinHeight;
    depth.set_farthest(bin, cpu_fast::fill_bin(cpu_fast::bin_kernels(options.kernel), used, bin, x,
                                               y, depth.farthest(bin), depth.write(bin), scratch));
}

void OccluderBuffer::rasterize()
{
    State& s = *state_;
    if (s.pending.empty()) {
        return;
    }
    const size_t chunks = (s.pending.size() + kInstancesAtOnce - 1) / kInstancesAtOnce;
    s.workers.for_each(chunks, [&](size_t chunk) { s.place(chunk); });
    s.sort_instances();
    for (size_t begin = 0; begin < s.order.size(); begin = s.batch_ends.back()) {
        s.make_batches(begin);
        s.workers.for_each(s.batch_ends.size(), [&](size_t batch) { s.set_up(batch); });
        s.workers.for_each(s.grid.bin_count(), [&](size_t bin) { s.fill(bin); });
        for (size_t i = 0; i < s.batch_ends.size(); ++i) {
            s.statistics.filled += s.batches[i].prims.size();
        }
    }
    s.pending.clear();
    s.expanded_fresh = false;
}

std::span<const float> OccluderBuffer::State::expanded_depth()
{
    if (!expanded_fresh) {
        expanded.resize(pixel_count(grid.size_cells));
        depth.expand(expanded);
        expanded_fresh = true;
    }
    return expanded;
}

// The cells that some of the pixels lie in.
cpu_fast::CellRect OccluderBuffer::State::cells_of(const PixelRect& rect) const
{
    const int size = options.cell_px;
    const auto cell = [&](int px) {
        return static_cast<int16_t>(size == 1 ? px : size == 2 ? px >> 1 : px / size);
    };
    return {cell(rect.x), cell(rect.y), cell(rect.x + rect.width - 1),
            cell(rect.y + rect.height - 1)};
}

Visibility OccluderBuffer::State::test(const PixelRect& rect_px, float nearest) const
{
    const PixelRect rect = clipped(rect_px, grid.size_px);
    if (rect.width <= 0 || rect.height <= 0) {
        return Visibility::outside;
    }
    return depth.hides(cells_of(rect), nearest) ? Visibility::hidden : Visibility::visible;
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
    const State& s = *state_;
    if (boxes.size() != results.size() || s.grid.bin_count() == 0) {
        std::ranges::fill(results, Visibility::visible);
        return;
    }
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
    const State& s = *state_;
    return s.grid.bin_count() == 0 ? Visibility::visible : s.test(rect_px, nearest);
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
    return state_->expanded_depth();
}

const OccluderStatistics& OccluderBuffer::statistics() const
{
    return state_->statistics;
}

bool OccluderBuffer::read_depth(const PixelRect& rect, std::span<float> out) const
{
    State& s = *state_;
    if (s.grid.bin_count() == 0 || !is_inside(rect, s.grid.size_px) ||
        out.size() != pixel_count(rect)) {
        return false;
    }
    const std::span<const float> depth = s.expanded_depth();
    const int cell = s.options.cell_px;
    for (int row = 0; row < rect.height; ++row) {
        float* to = out.data() + static_cast<ptrdiff_t>(row) * rect.width;
        const int y = rect.y + row;
        if (row > 0 && y % cell != 0) {
            std::copy(to - rect.width, to, to);
            continue;
        }
        const float* from = depth.data() + static_cast<ptrdiff_t>(y / cell) * s.grid.size_cells.x;
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
