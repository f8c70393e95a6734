// Software occlusion culling by itself: rasterise occluders, test boxes, on the CPU, at once.
//
//   occlude::OccluderBuffer buffer;
//   buffer.begin(view);
//   buffer.add(house, world_from_house); // an OccluderMesh, prepared once
//   buffer.rasterize();
//   if (buffer.test(box) != occlude::Visibility::visible) { ... } // need not be drawn
//
// Implements  J. Hasselgren, M. Andersson, T. Akenine-Moeller, "Masked Software Occlusion Culling",
//             High Performance Graphics 2016.
// Map         masked depth, 2 layers per 8x4 -> MaskedBin, merge_layer (detail/masked_bin.h,
//             bin_raster.cpp); coverage by rows, shuffled to sub-tiles -> bin_raster_simd.cpp;
//             hierarchical test -> MaskedDepth::hides
// Deviations  Coverage is that of whole cells by all triangles of a mesh that face one way, not of
//             pixel centres by single triangles. Bins know their farthest depth, so that there are
//             three levels instead of two.
// Guarantees  Exact for whatever renderer draws the occluders: `hidden` means that every sample of
//             everything in the box, wherever in its pixel, lies behind what the renderer draws of
//             the occluders. docs/occluders.md has the proof. The same answers by every kernel, on
//             any number of threads, and in every order of occluders whose boxes differ.
// Cost        of a triangle of 10x10 cells about 0.1 us, of large ones what they cover, of a test
//             0.02 to 0.2 us. No allocation once the largest frame was seen, but by depth() and
//             read_depth(), which expand the masks when they are called first.
#pragma once

#include <occlude/backends/cpu_fast/occluder_mesh.h>
#include <occlude/core/query_device.h>
#include <occlude/core/view.h>
#include <occlude/screen/kernel.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include <cstdint>
#include <memory>
#include <span>

namespace occlude {

/// What a test says. Whatever is not known is visible.
enum class Visibility : uint8_t {
    visible, ///< something of it may be seen
    hidden,  ///< it is behind the occluders
    outside, ///< it is outside of the view
};

struct OccluderBufferOptions {
    /// Side of a cell in pixels of the view, 1 to 16. With 2, a quarter of the memory and of the
    /// filling, and occluders that end a pixel earlier.
    int cell_px = 2;
    /// Threads that rasterise, by oneTBB; 1: the caller's alone, 0: as many as there are.
    int threads = 1;
    Kernel kernel = Kernel::simd;
};

/// What rasterize() did since begin().
struct OccluderStatistics {
    uint64_t instances = 0; ///< added, and not outside
    uint64_t triangles = 0; ///< of those
    uint64_t filled = 0;    ///< triangles and open edges that were handed to tiles
};

class OccluderBuffer {
public:
    explicit OccluderBuffer(const OccluderBufferOptions& options = {});
    ~OccluderBuffer();
    OccluderBuffer(OccluderBuffer&&) noexcept;
    OccluderBuffer& operator=(OccluderBuffer&&) noexcept;

    /// Starts a frame: nothing hides anything. `view` is the one that the renderer draws with, its
    /// size that of the target. Views of more than 4096 cells along a side hide nothing.
    void begin(const View& view);

    /// Adds an instance of a mesh. The mesh must stay until rasterize(). Only what the renderer
    /// draws in this frame, opaque and with depth, may be added; it may be drawn later.
    void add(const OccluderMesh& mesh, const glm::mat4& world_from_mesh);

    /// Makes the depth of everything added since the last call: tests see it from now on.
    void rasterize();

    /// Tests a box around things that the renderer draws; the box as it is, not inflated.
    Visibility test(const Aabb& box_world) const;
    /// Many boxes are cheaper at once. Precondition: results.size() == boxes.size().
    void test(std::span<const Aabb> boxes_world, std::span<Visibility> results) const;
    /// Tests pixels of the view, of which something shows at `nearest` window depth (0 near, 1 far
    /// in every convention) or beyond. A rectangle outside of the view is `outside`.
    Visibility test(const PixelRect& rect_px, float nearest) const;

    const View& view() const;
    /// Of the grid: the view's, divided by cell_px and rounded up; 0 before begin() and for views
    /// that are not usable.
    glm::ivec2 size_cells() const;
    int cell_px() const;
    /// Window depth by cells, row by row from the bottom: nothing drawn behind it can be seen. Made
    /// by the first call after rasterize(): one thread at a time.
    std::span<const float> depth() const;
    /// The same by pixels of the view. False, and `out` is untouched, where `rect` does not lie in
    /// the view or `out` has not its size.
    bool read_depth(const PixelRect& rect_px, std::span<float> out) const;

    const OccluderStatistics& statistics() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace occlude
