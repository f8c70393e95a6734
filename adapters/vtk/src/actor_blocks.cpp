#include "actor_blocks.h"

#include "prop_kind.h"

#include <occlude/core/rng.h>

#include <vtkAbstractMapper.h>
#include <vtkActor.h>
#include <vtkAppendPolyData.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkTexture.h>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <limits>
#include <utility>

namespace occlude {

namespace {

constexpr uint32_t kSameFrames = 3; // before an actor is cut
constexpr uint64_t kForgetAfterFrames = 300;

struct Polygon {
    uint32_t triangles = 0;
    Aabb box = Aabb::empty();
};

bool has_colors(vtkMapper& mapper, vtkPolyData& leaf)
{
    int of_cells = 0;
    return mapper.GetScalarVisibility() != 0 &&
           vtkAbstractMapper::GetAbstractScalars(&leaf, mapper.GetScalarMode(),
                                                 mapper.GetArrayAccessMode(), mapper.GetArrayId(),
                                                 mapper.GetArrayName(), of_cells) != nullptr;
}

// Differs when anything has changed that blocks are made from.
uint64_t version_of(vtkActor& actor)
{
    vtkMapper& mapper = *actor.GetMapper();
    uint64_t version = hash64(reinterpret_cast<uintptr_t>(&mapper), mapper.GetMTime(),
                              reinterpret_cast<uintptr_t>(actor.GetTexture()));
    for (vtkPolyData* leaf : leaves_of(mapper)) {
        version = hash64(version, reinterpret_cast<uintptr_t>(leaf), leaf->GetMTime());
    }
    return version;
}

// Leaves may be drawn as one surface if each has the same kinds of data at its points.
bool can_be_cut(vtkMapper& mapper, const std::vector<vtkPolyData*>& leaves)
{
    return std::ranges::all_of(leaves, [&](vtkPolyData* leaf) {
        vtkPointData& data = *leaf->GetPointData();
        vtkPointData& first = *leaves.front()->GetPointData();
        const auto alike = [](const void* a, const void* b) {
            return (a == nullptr) == (b == nullptr);
        };
        return leaf->GetNumberOfStrips() == 0 && !has_colors(mapper, *leaf) &&
               leaf->GetCellData()->GetNormals() == nullptr &&
               leaf->GetCellData()->GetArray("vtkGhostType") == nullptr &&
               alike(data.GetNormals(), first.GetNormals()) &&
               alike(data.GetTCoords(), first.GetTCoords()) &&
               alike(data.GetTangents(), first.GetTangents());
    });
}

float half_area(const Aabb& box)
{
    const glm::vec3 size = box.max - box.min;
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

// Where the run is best parted in two, by the surface area heuristic; an eighth is the least part.
size_t best_cut(std::span<const Polygon> run)
{
    std::vector<float> behind(run.size()); // the cost of the polygons from there on
    Aabb box = Aabb::empty();
    uint32_t triangles = 0;
    for (size_t i = run.size(); i-- > 1;) {
        box = merge(box, run[i].box);
        triangles += run[i].triangles;
        behind[i] = half_area(box) * static_cast<float>(triangles);
    }
    box = Aabb::empty();
    triangles = 0;
    size_t best = run.size() / 2;
    float least = std::numeric_limits<float>::max();
    for (size_t i = 1; i < run.size() * 7 / 8; ++i) {
        box = merge(box, run[i - 1].box);
        triangles += run[i - 1].triangles;
        const float cost = half_area(box) * static_cast<float>(triangles) + behind[i];
        if (cost < least && i > run.size() / 8) {
            least = cost;
            best = i;
        }
    }
    return best;
}

// Parts a run of polygons until the parts are small enough. Polygons keep their order: where two
// have the same depth, the later one shows.
void split(std::span<const Polygon> run, size_t begin, uint32_t block_triangles,
           std::vector<std::pair<size_t, size_t>>& parts)
{
    uint64_t triangles = 0;
    for (const Polygon& polygon : run) {
        triangles += polygon.triangles;
    }
    if (triangles <= block_triangles || run.size() < 2) {
        parts.emplace_back(begin, begin + run.size());
        return;
    }
    const size_t half = triangles <= 4 * uint64_t{block_triangles}
                            ? run.size() / 2 // so that parts are not tiny
                            : best_cut(run);
    split(run.first(half), begin, block_triangles, parts);
    split(run.subspan(half), begin + half, block_triangles, parts);
}

std::vector<Polygon> polygons_of(vtkPolyData& surface)
{
    std::vector<Polygon> polygons;
    vtkCellArray& cells = *surface.GetPolys();
    polygons.reserve(static_cast<size_t>(cells.GetNumberOfCells()));
    for (vtkIdType cell = 0; cell < cells.GetNumberOfCells(); ++cell) {
        vtkIdType count = 0;
        const vtkIdType* corners = nullptr;
        cells.GetCellAtId(cell, count, corners);
        Polygon polygon;
        polygon.triangles = static_cast<uint32_t>(std::max<vtkIdType>(count - 2, 0));
        for (vtkIdType i = 0; i < count; ++i) {
            glm::dvec3 corner;
            surface.GetPoint(corners[i], &corner.x);
            const glm::vec3 point{corner};
            polygon.box = merge(polygon.box, {point, point});
        }
        polygons.push_back(polygon);
    }
    return polygons;
}

// Of the points that its polygons use.
Bounds bounds_of(vtkPolyData& surface)
{
    Bounds bounds{};
    surface.GetCellsBounds(bounds.data());
    return bounds;
}

} // namespace

Bounds placed_by(vtkActor& actor, const Bounds& local)
{
    const vtkMatrix4x4& m = *actor.GetMatrix();
    Bounds placed{};
    for (int row = 0; row < 3; ++row) {
        double low = m.GetElement(row, 3);
        double high = low;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = m.GetElement(row, axis) * local[static_cast<size_t>(2 * axis)];
            const double b = m.GetElement(row, axis) * local[static_cast<size_t>(2 * axis + 1)];
            low += std::min(a, b);
            high += std::max(a, b);
        }
        placed[static_cast<size_t>(2 * row)] = low;
        placed[static_cast<size_t>(2 * row + 1)] = high;
    }
    return placed;
}

std::vector<vtkSmartPointer<vtkPolyData>> cut(vtkPolyData& surface, uint32_t block_triangles)
{
    const std::vector<Polygon> polygons = polygons_of(surface);
    std::vector<std::pair<size_t, size_t>> parts;
    split(polygons, 0, std::max(block_triangles, 1u), parts);
    std::vector<vtkSmartPointer<vtkPolyData>> blocks;
    for (const auto& [begin, end] : parts) {
        const vtkNew<vtkCellArray> cells;
        for (size_t polygon = begin; polygon < end; ++polygon) {
            vtkIdType count = 0;
            const vtkIdType* corners = nullptr;
            surface.GetPolys()->GetCellAtId(static_cast<vtkIdType>(polygon), count, corners);
            cells->InsertNextCell(count, corners);
        }
        auto block = vtkSmartPointer<vtkPolyData>::New();
        block->SetPoints(surface.GetPoints());
        block->GetPointData()->ShallowCopy(surface.GetPointData());
        block->SetPolys(cells);
        blocks.push_back(block);
    }
    return blocks;
}

void ActorBlocks::begin_frame()
{
    ++frame_;
    if (frame_ % kForgetAfterFrames == 0) {
        std::erase_if(entries_, [this](const auto& entry) {
            return entry.second.last_seen + kForgetAfterFrames < frame_;
        });
    }
}

std::span<const ActorBlock> ActorBlocks::blocks_of(vtkActor& actor, uint32_t triangles)
{
    if (block_triangles_ == 0 || triangles <= 2 * block_triangles_) {
        return {};
    }
    const uint64_t version = version_of(actor);
    Entry& entry = entries_[&actor];
    const bool same = entry.version == version && entry.last_seen + 1 >= frame_;
    entry.same_frames = same ? entry.same_frames + 1 : 0;
    entry.last_seen = frame_;
    if (entry.version != version) {
        entry.version = version;
        entry.tried = false;
        entry.blocks.clear();
    }
    if (!entry.tried && entry.same_frames >= kSameFrames) {
        entry.tried = true;
        make_blocks(actor, entry);
        entry.version = version_of(actor); // whoever copies a mapper gives it a table of colours
    }
    return entry.blocks;
}

void ActorBlocks::make_blocks(vtkActor& actor, Entry& entry) const
{
    vtkMapper& mapper = *actor.GetMapper();
    const std::vector<vtkPolyData*> leaves = leaves_of(mapper);
    vtkTexture* texture = actor.GetTexture();
    if (!can_be_cut(mapper, leaves) || (texture != nullptr && texture->GetTransform() != nullptr)) {
        return;
    }
    vtkSmartPointer<vtkPolyData> surface = leaves.front();
    if (leaves.size() > 1) {
        const vtkNew<vtkAppendPolyData> append;
        for (vtkPolyData* leaf : leaves) {
            append->AddInputData(leaf);
        }
        append->Update();
        surface = append->GetOutput();
    }
    for (const vtkSmartPointer<vtkPolyData>& part : cut(*surface, block_triangles_)) {
        ActorBlock block{vtkSmartPointer<vtkPolyDataMapper>::New(), bounds_of(*part),
                         triangles_of(*part)};
        block.mapper->vtkMapper::ShallowCopy(&mapper);
        block.mapper->SetInputData(part);
        block.mapper->ScalarVisibilityOff();
        entry.blocks.push_back(block);
    }
}

} // namespace occlude
