// QueryDevice on OpenGL 3.3 core and up, around the draw callback of an engine.
//
// The target is whatever GlScene::begin_frame binds to GL_DRAW_FRAMEBUFFER: tests run in it, so
// they see the same samples as the image, multisampled or not, and read_depth reads it. The device
// never binds another one, except inside read_depth, which puts it back.
//
// State that tests change. All of it is free for the device from query() until the device calls
// GlScene::restore_state(), just before the next draw() and before end_frame():
//   program, vertex array, GL_ARRAY_BUFFER, colour mask and depth mask (off), depth test (on),
//   depth function (LEQUAL, or GEQUAL where near is large), GL_DEPTH_CLAMP (on), GL_CULL_FACE (off)
// with the method `raster` also: GL_SHADER_STORAGE_BUFFER and its binding point 7
// and, after read_depth and with the method `pyramid` only:
//   blending and stencil test (off), active texture unit (0), unit 0's GL_TEXTURE_2D_MULTISAMPLE,
//   GL_PIXEL_PACK_BUFFER (0), pack alignment (4), pack row length and skips (0)
//
// State that tests expect, as it is while the engine's geometry is drawn: the framebuffer,
// viewport, scissor, depth range, clip control and sample mask are those of the geometry; stencil
// test, clip distances, rasterizer discard, polygon offset and alpha to coverage are off; polygon
// mode is FILL.
//
// Counts: a box is drawn with the back of its faces, so that neither winding nor mirrored
// transforms matter; a wholly visible box that covers n samples answers up to 2 n. draw_and_query
// counts as the geometry is drawn. The methods raster and pyramid answer 0, or 1 for "some".
#pragma once

#include <occlude/backends/gl/gl_scene.h>
#include <occlude/core/query_device.h>
#include <occlude/core/result.h>

#include <cstdint>
#include <memory>

namespace occlude::gl {

struct GlDeviceOptions {
    /// At most this many tickets may be unspent; one query object is made for each when needed.
    uint32_t max_outstanding = 4096;

    /// Boxes are tested nearer to the viewer than they are by this window depth, and by what the
    /// rounding of positions in float can amount to (View::clip_rounding). It covers the
    /// interpolation of depth and a depth buffer of 24 bits or 32-bit float. Larger is safe and
    /// finds less hidden. A 16-bit buffer needs 0x1p-14.
    float depth_bias = 0x1p-20f;

    /// Use nothing newer than this version of OpenGL, in the form 10 * major + minor.
    int max_gl_version = 99;
};

/// One OpenGL context's query device. Not thread-safe; the context that was current when it was
/// created must be current in every call and in the destructor.
class GlDevice final : public QueryDevice {
public:
    /// A device around `scene`, which outlives it. Fails without a current OpenGL context of at
    /// least 3.3, or if the driver refuses a shader. Leaves the vertex array and buffer bindings at
    /// 0.
    static Result<std::unique_ptr<GlDevice>> create(GlScene& scene,
                                                    const GlDeviceOptions& options = {});
    ~GlDevice() override;

    /// Makes the driver compile what tests and read_depth need for the current target; otherwise
    /// the first test of a frame may take milliseconds. Inside a frame only, at best one with the
    /// whole scene's formats bound; draws nothing. Engines warm up their own shaders with draw()
    /// and draw_and_query().
    void warm_up();

    const DeviceCaps& caps() const override;
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;

    /// Makes `method` the one of batches that name none (`automatic`: queries again). Fails, and
    /// says which there are, if this context has no such method. Outside frames only.
    Result<bool> use_method(TestMethod method);

    /// A batch that names a method which caps.methods does not list gets the default one. Empty
    /// tests and tests of unbounded boxes, which break C5 and C6, are lost.
    ///   queries  one occlusion query and one instanced draw per test
    ///   raster   one instanced draw per batch into a buffer of flags, from OpenGL 4.3 on
    ///   pyramid  reads depth once after each draw(), if a test comes, and answers on the CPU:
    ///            query() blocks until the draws are done, and its answers are there at once
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;

    /// glFlush: drivers run nothing before it, so call it right after a batch of tests.
    void flush() override;

    /// Never blocks, but a driver may flush here.
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    void end_frame() override;

private:
    struct Parts;
    GlDevice(GlScene& scene, std::unique_ptr<Parts> parts);
    void leave_tests();
    TestMethod method_of(const QueryBatch& batch) const;
    void test_with_pyramid(const QueryBatch& batch, std::span<Ticket> tickets);

    // Whose state is set: the engine's, that of a method of testing, or neither's.
    enum class Mode : uint8_t { drawing, queries, raster, unknown };

    GlScene& scene_;
    std::unique_ptr<Parts> parts_;
    DeviceCaps caps_;
    View view_;
    Mode mode_ = Mode::drawing;
};

} // namespace occlude::gl
