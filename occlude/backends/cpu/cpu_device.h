// An exact software depth buffer behind the query seam: the oracle of the project. No GPU, no
// threads, no SIMD; the same answers on every machine, in debug and in release builds.
//
// Samples   One per pixel, at its centre; row 0 is the bottom row.
// Depth     Window depth as float, 0 at the near and 1 at the far plane in every ClipConvention.
// Draws     Compare LESS against the target cleared to 1; both sides of triangles are drawn. Equal
//           depths go to the smaller item id, then to the smaller triangle: the image is the
//           minimum of (depth, item, triangle) over all fragments, whatever the order of draws.
//           Fragments of translucent items compare LESS too, and are listed in draw order instead
//           of written: draw them after all opaque ones, and whoever shades the image blends them.
// Tests     Compare LESS OR EQUAL, with box faces moved toward the viewer by kBoxBias, so that a
//           wall in the face of its own box is never hidden by itself (rule R3). Each sample counts
//           once per test, however many boxes and faces cover it (C6): the answer is the number of
//           samples of the union. Boxes are drawn by the code that draws triangles.
//
// Why a box covers its contents (rule R2). Let a triangle in the box own a sample. Snapping moved
// the point of the triangle that lands on the sample by at most half a snap in x and in y, and not
// in depth; the same holds for the faces of the box. View::inflated_for_test has put the faces at
// least four snaps (1/64 px) away from that point. So moving the faces by half a snap cannot carry
// them across it: it still lies inside the snapped, closed box. The ray from it to the viewer
// crosses a face, whose fragment at this sample is nearer in real numbers. Rounding to float keeps
// the order. kBoxBias, which is 10^8 times larger, covers the rounding of the interpolation in
// double.
#pragma once

#include <occlude/backends/cpu/cpu_scene.h>
#include <occlude/backends/cpu/rasterizer.h>
#include <occlude/core/query_device.h>
#include <occlude/core/result.h>
#include <occlude/core/ticket_table.h>
#include <occlude/screen/pyramid_tests.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

struct CpuDeviceOptions {
    /// The largest number of unspent tickets; a test beyond it is lost (C11).
    uint32_t max_outstanding = 4096;
};

class CpuDevice final : public QueryDevice {
public:
    /// Moves the faces of tested boxes nearer: one step of float depth just below 1.
    static constexpr double kBoxBias = 0x1p-24;

    /// The triangle that a pixel shows; `item` is invalid if nothing was drawn.
    struct Owner {
        ItemId item;
        uint32_t triangle = 0; ///< index of the triangle, counted from the item's first

        bool operator==(const Owner&) const = default;
    };

    /// A fragment of a translucent item that was nearer than everything opaque drawn before it.
    struct TranslucentFragment {
        size_t pixel = 0;
        Owner owner;

        bool operator==(const TranslucentFragment&) const = default;
    };

    /// A device that draws the items of `scene`, which must outlive it.
    explicit CpuDevice(const CpuScene& scene, const CpuDeviceOptions& options = {});

    const DeviceCaps& caps() const override { return caps_; }

    /// Clears the target; its size is the view's. If the view is not finite, has no pixel or is
    /// larger than cpu::kMaxSide, the frame draws nothing, its tests are lost, and its depth cannot
    /// be read.
    void begin_frame(const View& view) override;

    /// For opaque items, `shade` and `depth_only` are the same, and `shade_equal` does nothing,
    /// because the triangle of each pixel is already known. Only `shade` draws translucent items.
    void draw(std::span<const ItemId> items, DrawPass pass) override;

    /// Makes `method`, queries or pyramid, the method of batches that name none (`automatic`:
    /// queries). Fails and lists the available methods for others. Outside frames only.
    Result<bool> use_method(TestMethod method);

    /// Answers at once. A batch gets the default method if it names one that caps.methods does not
    /// list. A test is lost if it has no boxes, or a box that is not bounded or (with queries)
    /// touches the near rectangle.
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;

    /// Counts the samples that the items won while they were drawn, each once, even if another item
    /// of the same call won them later. With `shade_equal`, counts the samples that the items own.
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;

    void flush() override {}
    Answer poll(Ticket ticket) override { return wait(ticket); }
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override { in_frame_ = false; }

    /// The target of the last frame: its size (0 before the first), its window depth, and the owner
    /// of each pixel (row by row from the bottom).
    glm::ivec2 size_px() const { return target_.size_px; }
    std::span<const float> depth() const { return target_.depth; }
    Owner owner(size_t pixel) const;
    /// In the order in which they were drawn.
    std::span<const TranslucentFragment> translucent_fragments() const
    {
        return target_.translucent;
    }

    /// Counts the calls of begin_frame.
    uint64_t frame_count() const { return frame_count_; }

private:
    /// The content of the target, pixel by pixel.
    struct Target {
        glm::ivec2 size_px{0};
        std::vector<float> depth;
        std::vector<uint32_t> items;     ///< unspecified where depth is 1
        std::vector<uint32_t> triangles; ///< likewise
        std::vector<TranslucentFragment> translucent;
    };
    /// The vertices of the item being drawn, each transformed once; `current` marks the transformed
    /// ones.
    struct TransformedVertices {
        std::vector<cpu::Vertex> vertices;
        std::vector<uint32_t> marks;
        uint32_t current = 0;
    };

    template <class Fragment>
    void rasterize_item(const CpuItem& item, Fragment&& fragment);
    const cpu::Vertex* transformed_vertex(const CpuItem& item, const glm::dmat4& clip_from_mesh,
                                          uint32_t index);
    bool outside_of_view(const Aabb& box, const glm::dmat4& clip_from_mesh) const;
    bool blend(size_t pixel, double depth, ItemId item, uint32_t triangle);
    bool write(size_t pixel, double depth, ItemId item, uint32_t triangle);
    bool owns(size_t pixel, double depth, ItemId item) const;
    void test_with_pyramid(const QueryBatch& batch);
    Answer test(std::span<const QueryBox> boxes);
    uint64_t count_box(const QueryBox& box);
    bool testable(const QueryBox& box) const;
    void next_stamp();
    bool stamp(size_t pixel);
    Ticket issue(const Answer& answer);

    const CpuScene& scene_;
    DeviceCaps caps_;
    View view_;
    cpu::ScreenTransform transform_;
    bool in_frame_ = false;
    uint64_t frame_count_ = 0;

    Target target_;

    std::vector<uint32_t> stamps_; ///< the last test that counted the pixel
    uint32_t current_stamp_ = 0;

    TransformedVertices transformed_;

    PyramidTests pyramid_;
    std::vector<Answer> answers_; ///< of one batch of the method pyramid

    TicketTable<Answer> unspent_;
};

} // namespace occlude
