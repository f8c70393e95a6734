// Blocks of actors with many triangles, and of composite data sets: a mapper for each, which draws
// its triangles as the actor's own mapper would.
//
// The blocks of one actor share its points, so that OpenGL holds them once. Only what does not
// depend on the cutting is cut: no colours from data, which are indexed by all points or cells, and
// no data of cells that the picture shows. An actor is cut when it has stayed the same for some
// frames, and is drawn whole again as soon as its data changes.
#pragma once

#include "prop_items.h"

#include <vtkPolyDataMapper.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

class vtkActor;
class vtkPolyData;

namespace occlude {

struct ActorBlock {
    vtkSmartPointer<vtkPolyDataMapper> mapper;
    Bounds bounds{}; ///< in the actor's space
    uint32_t triangles = 0;
};

/// The bounds of the image of `local` under the actor's matrix.
Bounds placed_by(vtkActor& actor, const Bounds& local);

/// Parts of `surface` of at most `block_triangles` triangles each: runs of its polygons, cut where
/// the boxes of the runs become small. They share its points and the data at them.
std::vector<vtkSmartPointer<vtkPolyData>> cut(vtkPolyData& surface, uint32_t block_triangles);

class ActorBlocks {
public:
    void set_block_triangles(uint32_t count) { block_triangles_ = count; }

    void begin_frame();
    /// The blocks of a testable actor in this frame; none if it is drawn whole. `triangles`: its
    /// own.
    std::span<const ActorBlock> blocks_of(vtkActor& actor, uint32_t triangles);

private:
    struct Entry {
        uint64_t version = 0; ///< of everything that the blocks were made from
        uint64_t mapper_version = 0;
        uint32_t same_frames = 0;
        uint64_t last_seen = 0;
        bool tried = false; ///< to cut this version
        std::vector<ActorBlock> blocks;
    };

    void make_blocks(vtkActor& actor, Entry& entry) const;

    uint32_t block_triangles_ = 0;
    uint64_t frame_ = 0;
    std::unordered_map<const vtkActor*, Entry> entries_;
};

} // namespace occlude
