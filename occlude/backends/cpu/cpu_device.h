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
// Why a box covers what is in it (rule R2). Let a triangle in the box own a sample. The point of
// the triangle that lands on the sample was moved by snapping by at most half a snap in x and in y,
// and not in depth; so were the faces of the box. View::inflated_for_test has put the faces at
// least four snaps (1/64 px) away from that point. So moving the faces by half a snap cannot carry
// them across it: it still lies inside the snapped, closed box, and the ray from it to the viewer
// crosses a face, whose fragment at this sample is nearer in real numbers. Rounding to float keeps
// order; the rounding of the interpolation in double is what kBoxBias, 10^8 times larger, pays for.
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
    /// Tickets that may be unspent at a time; a test beyond that is lost (C11).
    uint32_t max_outstanding = 4096;
};

class CpuDevice final : public QueryDevice {
public:
    /// One step of float depth just below 1: what the faces of tested boxes are moved by.
    static constexpr double kBoxBias = 0x1p-24;

    /// Which triangle a pixel shows; `item` is invalid where nothing was drawn.
    struct Owner {
        ItemId item;
        uint32_t triangle = 0; ///< counted from the item's first

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

    /// Clears the target; its size is the view's. A view that is not finite, that has no pixel or
    /// that is larger than cpu::kMaxSide gives a frame that draws nothing, whose tests are lost and
    /// whose depth cannot be read.
    void begin_frame(const View& view) override;

    /// `shade` and `depth_only` are the same here for opaque items; `shade_equal` does nothing,
    /// because which triangle a pixel shows is known already. Translucent items are drawn by
    /// `shade` alone.
    void draw(std::span<const ItemId> items, DrawPass pass) override;

    /// Makes `method`, queries or pyramid, the one of batches that name none (`automatic`: queries
    /// again). Fails, and says which there are, for others. Outside frames only.
    Result<bool> use_method(TestMethod method);

    /// Answers at once, by the default method where the batch names one that caps.methods does not
    /// list. A box that is not bounded or (with queries) touches the near rectangle makes its test
    /// lost, and so does a test without boxes.
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;

    /// Counts the samples that the items won while they were drawn, each once, even if an item of
    /// the same call took them over; with `shade_equal`, the samples that the items own.
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;

    void flush() override {}
    Answer poll(Ticket ticket) override { return wait(ticket); }
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override { in_frame_ = false; }

    /// The target of the last frame: its size (0 before the first), its window depth, and who owns
    /// a pixel (row by row from the bottom).
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
    /// What was drawn, pixel by pixel.
    struct Target {
        glm::ivec2 size_px{0};
        std::vector<float> depth;
        std::vector<uint32_t> items;     ///< unspecified where depth is 1
        std::vector<uint32_t> triangles; ///< likewise
        std::vector<TranslucentFragment> translucent;
    };
    /// The vertices of the item being drawn, each transformed once: those marked by `current`.
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
