// Splits a mesh in space by an axis-aligned BSP, cutting the triangles that straddle its planes.
//
// Implements  V. Kovalcik, P. Tobola, "Fast Rendering of Complex Dynamic Scenes",
//             section 3.1, object partitioning.
// Map         "divided recursively by planes until the number of triangles drops below a threshold"
//             -> split_triangles
// Deviations  The paper does not say where the planes go. Here a plane goes where the surface area
//             heuristic is least among borders of triangles, so that meshes with axis-aligned faces
//             are hardly cut. Planes stop where they would make the mesh more than kMaxSplitGrowth
//             times as large: triangles that cross each other could be cut without end.
// Guarantees  Watertight: an edge is cut at most once, at one point, and every triangle with that
//             edge, on whichever side of whichever plane, gets that point as a corner, bit by bit.
//             So edges that met before meet afterwards, without T-junctions. Corners keep their
//             order. Deterministic.
//             The image is NOT guaranteed to be the same: the new corners of a cut triangle are
//             rounded to float, and rasterisers snap them. A sample within a rounding of an edge,
//             or the last bit of a depth, may differ from the uncut mesh. Hence the split mesh
//             replaces the mesh for the reference image and for the culled one.
// Cost        O(n log^2 n) for n triangles; 70,000 in about a second.
#pragma once

#include <occlude/hierarchy/builders/two_level.h>
#include <occlude/scene/partition.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

/// A mesh of n triangles is cut into at most about this many times n.
constexpr uint32_t kMaxSplitGrowth = 8;

struct SplitMesh {
    std::vector<glm::vec3> positions; ///< the given positions, then those of the cuts
    std::vector<glm::vec3> normals;   ///< one per position; the normals at cuts have length 1
    std::vector<uint32_t> indices;
    std::vector<PartitionPart> parts; ///< covers all indices, in order
    LocalTree tree;                   ///< the BSP over the parts
    uint32_t cut_triangles = 0;       ///< how many triangles the cuts added
    /// How many parts are larger than requested because of kMaxSplitGrowth.
    uint32_t unsplit_parts = 0;
};

/// The triangles of `indices` (three per triangle), cut into parts of about `max_triangles` at
/// most. A part has more if no plane makes it smaller or the mesh would grow beyond
/// kMaxSplitGrowth, and a few more if cuts of its neighbours added corners. Normals are
/// interpolated along cut edges. No plane cuts a triangle with coordinates that are not finite.
/// Triangles that shrink to a line or a point when cut are dropped. Preconditions: every index is
/// in `positions`, as many normals as positions, max_triangles > 0.
SplitMesh split_triangles(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                          std::span<const uint32_t> indices, uint32_t max_triangles);

} // namespace occlude
