// QueryDevice on OpenGL 3.3 core and up, around the draw callback of an engine.
//
// The target is the framebuffer that GlScene::begin_frame binds to GL_DRAW_FRAMEBUFFER, and in it
// the viewport, depth range and clip control that are set when begin_frame returns. Tests run
// there, so that they see the same samples as the image, multisampled or not; read_depth reads it.
// The viewport may lie anywhere, its origin may be the upper left, and its depth may be a part of
// the depth buffer; its size must be the view's.
//
// docs/devices.md lists the state that tests change and the state that they need. read_depth puts
// back everything that it changes.
//
// Counts: a box is drawn with its back faces, too, so that neither winding nor mirrored transforms
// matter. A wholly visible box that covers n samples answers up to 2 n. draw_and_query counts the
// samples that the geometry draws. The methods raster and pyramid answer 0, or 1 for any number.
//
// Faults: if tests cannot answer for a frame (another context, a lost one, an incomplete target, a
// viewport of another size, an open query of the engine), they are lost, which reads as visible.
// Each fault is reported once through GlDeviceOptions::on_message:
//   gl.no_context gl.other_context gl.context_lost gl.incomplete_target gl.viewport gl.depth_range
//   gl.viewport_origin gl.query_open gl.no_query gl.pool_full gl.wait_budget gl.out_of_memory
//   gl.read_depth
// and, with state checks, states that hide objects although tests seem to work
// (gl_state_check.cpp):
//   gl.depth_function gl.clip_control gl.depth_clear gl.stencil_test gl.scissor gl.polygon_mode
//   gl.polygon_offset gl.rasterizer_discard gl.alpha_to_coverage gl.sample_coverage
//   gl.clip_distance gl.primitive_restart gl.transform_feedback gl.conditional_rendering
//   gl.logic_op gl.error
#pragma once

#include <occlude/backends/gl/gl_scene.h>
#include <occlude/core/messages.h>
#include <occlude/core/query_device.h>
#include <occlude/core/result.h>

#include <cstdint>
#include <memory>

namespace occlude {

/// When the OpenGL state is compared with the state that tests need.
enum class GlStateChecks : uint8_t {
    debug_builds, ///< like after_draws in debug builds of the library, like off in release builds
    off,
    after_draws, ///< at the first test after draws: some thirty calls to the driver
};

struct GlDeviceOptions {
    /// The largest number of unspent tickets; a query object is made for each when it is needed.
    uint32_t max_outstanding = 4096;

    /// Boxes are tested nearer to the viewer than they are, by this window depth plus the possible
    /// rounding of positions in float (View::clip_rounding). It covers the interpolation of depth
    /// and a depth buffer of 24 bits or 32-bit float. A larger value is safe and finds less hidden.
    /// A 16-bit buffer needs 0x1p-14.
    float depth_bias = 0x1p-20f;

    /// Uses no feature newer than this version of OpenGL, in the form 10 * major + minor.
    int max_gl_version = 99;

    /// The receiver of faults; none by default.
    MessageHandler on_message = {};
    GlStateChecks state_checks = GlStateChecks::debug_builds;

    /// How long one frame may wait, in all, for answers that do not come; then they are lost. 0:
    /// for ever.
    double wait_budget_ms = 2000.0;
};

/// The query device of one OpenGL context. Not thread-safe. The context that was current when the
/// device was created must be current in every call and in the destructor. In another context
/// nothing is tested, and the destructor leaves the objects of the device to the end of their
/// context.
class GlDevice final : public QueryDevice {
public:
    /// A device around `scene`, which must outlive it. Fails without a current OpenGL context of at
    /// least 3.3, or if the driver refuses a shader. Leaves the vertex array and buffer bindings at
    /// 0.
    static Result<std::unique_ptr<GlDevice>> create(GlScene& scene,
                                                    const GlDeviceOptions& options = {});
    ~GlDevice() override;

    /// Makes the driver compile the shaders of tests and read_depth for the current target;
    /// otherwise the first test of a frame may take milliseconds. Call it inside a frame, at best
    /// one with the formats of the whole scene; draws nothing. Engines warm up their own shaders
    /// with draw() and draw_and_query().
    void warm_up();

    const DeviceCaps& caps() const override;
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;

    /// Makes `method` the method of batches that name none (`automatic`: queries). Fails and lists
    /// the available methods if this context does not have it. Outside frames only.
    Result<bool> use_method(TestMethod method);

    /// A batch gets the default method if it names one that caps.methods does not list. Empty tests
    /// and tests of unbounded boxes, which break C5 and C6, are lost, and so is everything in a
    /// frame with a fault.
    ///   queries  one occlusion query and one instanced draw per test
    ///   raster   one instanced draw per batch into a buffer of flags, from OpenGL 4.3 on
    ///   pyramid  reads depth at the first test after each draw(), and answers on the CPU:
    ///            query() blocks until the draws are done, and its answers are available at once
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;

    /// glFlush: drivers run nothing before it, so call it right after a batch of tests.
    void flush() override;

    /// Never blocks, but a driver may flush here.
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    /// Tiles of 2 to 64 pixels, reduced on the device.
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

private:
    // The owner of the current state: the engine, or a test method.
    enum class Mode : uint8_t { drawing, queries, raster };
    // What may be done in this frame.
    enum class Frame : uint8_t {
        good,
        untestable, ///< tests are lost, and depth cannot be read
        foreign,    ///< likewise, and OpenGL must not be called
    };

    struct Parts;
    GlDevice(GlScene& scene, std::unique_ptr<Parts> parts);
    bool enter_tests(Mode mode, TestMethod method);
    void leave_tests();
    void find_faults(const View& view);
    void report_pool();
    TestMethod method_of(const QueryBatch& batch) const;
    void test_with_pyramid(const QueryBatch& batch, std::span<Ticket> tickets);

    GlScene& scene_;
    std::unique_ptr<Parts> parts_;
    DeviceCaps caps_;
    View view_;
    Mode mode_ = Mode::drawing;
    Frame frame_ = Frame::good;
    bool query_is_open_ = false; ///< the engine's, saved when the state of queries was set
};

} // namespace occlude
