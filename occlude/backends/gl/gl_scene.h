// The interface that an engine implements for GlDevice: draw items, and restore state after tests.
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
    /// or where the engine draws this view), and glClipControl and glDepthRange if the view's
    /// convention needs them. Clears, and sets all state that draw() relies on.
    virtual void begin_frame(const View& view) = 0;

    /// Draws the items with the camera of begin_frame(). Must neither begin nor end a query of
    /// target GL_SAMPLES_PASSED or GL_ANY_SAMPLES_PASSED: one may be active. `shade_equal` must
    /// compute bit-identical positions to `depth_only` (`invariant gl_Position`).
    virtual void draw(std::span<const ItemId> items, DrawPass pass) = 0;

    /// Called once before the first test after drawing, before the device changes any state. An
    /// engine that draws with state that tests do not allow (docs/devices.md lists it: stencil,
    /// polygon offset, alpha to coverage, ...) turns it off here, and saves the state that
    /// restore_state() sets again.
    virtual void prepare_tests() {}

    /// Restores the state that draw() relies on and that tests or prepare_tests() changed. Called
    /// once before the first draw() after tests, and before end_frame() after tests.
    virtual void restore_state() = 0;

    virtual void end_frame() {}
};

} // namespace occlude
