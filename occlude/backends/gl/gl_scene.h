// What GlDevice asks of an engine: draw these items, and set your state again after my tests.
#pragma once

#include <occlude/core/ids.h>
#include <occlude/core/query_device.h>
#include <occlude/core/view.h>

#include <span>

namespace occlude {

/// The engine's side of a GlDevice. All calls come from the thread that calls the device, with the
/// same OpenGL context current.
class GlScene {
public:
    virtual ~GlScene() = default;

    /// Binds the target, sets the viewport (view.size_px() pixels from view.viewport_origin_px(),
    /// or wherever the engine draws this view; and glClipControl and glDepthRange, where the view's
    /// convention needs them), clears, and sets everything that draw() relies on.
    virtual void begin_frame(const View& view) = 0;

    /// Draws the items with the camera of begin_frame(). Must neither begin nor end a query of
    /// target GL_SAMPLES_PASSED or GL_ANY_SAMPLES_PASSED: one may be active. `shade_equal` must
    /// compute bit-identical positions to `depth_only` (`invariant gl_Position`).
    virtual void draw(std::span<const ItemId> items, DrawPass pass) = 0;

    /// Called once before the first test after drawing, before the device changes anything. An
    /// engine that draws with state that tests do not allow turns it off here (docs/devices.md
    /// lists it: stencil, polygon offset, alpha to coverage, ...), and saves what restore_state()
    /// is to set again.
    virtual void prepare_tests() {}

    /// Sets again what draw() relies on of the state that tests or prepare_tests() changed. Called
    /// once before the first draw() after tests, and before end_frame() after tests.
    virtual void restore_state() = 0;

    virtual void end_frame() {}
};

} // namespace occlude
