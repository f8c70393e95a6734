// A triangle mesh prepared once, so that it can hide things every frame.
//
// Hiding needs to know which triangles share an edge: only along edges that they do not share may
// a mesh let something through (docs/occluders.md has the proof). Preparing finds the
// shared edges, and the pieces of the mesh that hang together by them.
//
// Positions   Vertices with equal positions are one vertex here: engines split them for normals and
//             texture coordinates, and still draw them at the same place. That holds only while
//             equal positions stay equal: a mesh that is skinned or morphed is prepared with
//             MeshWelding::by_index and gets its positions by set_positions() each frame.
// What may    Opaque triangles that are drawn as they are handed over. Alpha-tested and translucent
// hide        ones, and meshes that a shader displaces, may not: leave them out.
#pragma once

#include <occlude/core/aabb.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// Positions as engines keep them: `count` times three floats, `stride_bytes` apart.
struct PositionStream {
    const std::byte* data = nullptr;
    size_t count = 0;
    size_t stride_bytes = sizeof(glm::vec3);

    PositionStream() = default;
    PositionStream(std::span<const glm::vec3> positions)
        : data(reinterpret_cast<const std::byte*>(positions.data()))
        , count(positions.size())
    {
    }
    /// `vertices` vertices of `stride` bytes each, the position at `first`. Precondition: that many
    /// can be read. No alignment is needed.
    PositionStream(const void* first, size_t vertices, size_t stride)
        : data(static_cast<const std::byte*>(first))
        , count(vertices)
        , stride_bytes(stride)
    {
    }
    /// Precondition: i < count.
    glm::vec3 operator[](size_t i) const;
};

/// Which vertices are one.
enum class MeshWelding : uint8_t {
    by_position, ///< those at the same position: for meshes that keep their shape
    by_index,    ///< those with the same index: for meshes whose positions change
};

/// Which sides of its triangles the engine draws.
enum class MeshFaces : uint8_t {
    both,             ///< both, or not known: triangles may be wound as they like
    counterclockwise, ///< the side from which the corners run counter-clockwise in the mesh's own
                      ///< right-handed space, in mirrored instances too, as glTF has it
    clockwise,        ///< the other side
};

struct OccluderMeshOptions {
    MeshWelding welding = MeshWelding::by_position;
    MeshFaces faces = MeshFaces::both;
};

class OccluderMesh {
public:
    static constexpr uint32_t kNoTriangle = UINT32_MAX;

    /// Two or more triangles that hang together by shared edges: a run of triangles().
    struct Piece {
        uint32_t first = 0;
        uint32_t count = 0;
        /// Every edge is shared: it bounds a volume, and one of its two sides faces outward.
        bool closed = false;
        /// Of a closed piece: its triangles are counter-clockwise seen from outside.
        bool outward = true;
    };
    /// Corners, into positions(): counter-clockwise as handed over, or turned around so that
    /// neighbours agree.
    using Triangle = std::array<uint32_t, 3>;
    /// Who shares the edge from corner i to corner i + 1, the other way around; or kNoTriangle.
    using Mates = std::array<uint32_t, 3>;

    OccluderMesh() = default;

    /// Three indices per triangle. Triangles with an index that has no position, with a position
    /// that is not finite, or with two equal corners are left out. O(n log n), about 0.3 us per
    /// triangle.
    static OccluderMesh prepare(const PositionStream& positions, std::span<const uint32_t> indices,
                                const OccluderMeshOptions& options = {});
    static OccluderMesh prepare(const PositionStream& positions, std::span<const uint16_t> indices,
                                const OccluderMeshOptions& options = {});

    /// New positions of the same vertices, for meshes that were prepared with
    /// MeshWelding::by_index. False, and nothing changes, for others and for streams that are too
    /// short. No allocation.
    bool set_positions(const PositionStream& positions);

    bool empty() const { return triangles_.empty(); }
    std::span<const glm::vec3> positions() const { return positions_; }
    std::span<const Triangle> triangles() const { return triangles_; }
    std::span<const Mates> mates() const { return mates_; }
    /// Triangles from here on share no edge, and belong to no piece.
    uint32_t loose_begin() const { return loose_begin_; }
    std::span<const Piece> pieces() const { return pieces_; }
    const Aabb& box() const { return box_; }
    MeshFaces faces() const { return faces_; }

private:
    void weld(const PositionStream& positions, std::span<const uint32_t> indices,
              MeshWelding welding);
    void connect();
    void sort_pieces();
    void sort_positions();
    void update_bounds();

    std::vector<glm::vec3> positions_;
    std::vector<uint32_t> sources_; ///< the index of each position in the stream that it came from
    std::vector<Triangle> triangles_;
    std::vector<Mates> mates_;
    uint32_t loose_begin_ = 0;
    std::vector<Piece> pieces_;
    Aabb box_ = Aabb::empty();
    MeshFaces faces_ = MeshFaces::both;
    MeshWelding welding_ = MeshWelding::by_position;
};

} // namespace occlude
