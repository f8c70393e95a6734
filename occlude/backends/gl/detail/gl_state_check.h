// Compares the OpenGL state at a test with the state that tests need, and names the differences.
#pragma once

#include <occlude/backends/gl/detail/gl_target_state.h>
#include <occlude/core/messages.h>
#include <occlude/core/view.h>

namespace occlude {

/// Reports every difference through `messages`. Makes some thirty calls to OpenGL and reads its
/// error state, so it is too slow for every frame. Ends conditional rendering if it is active. Call
/// it after GlScene::prepare_tests() and before the device has changed any state. `gl_version` is
/// 10 * major + minor.
void check_gl_state(const View& view, const GlTargetState& target, int gl_version,
                    Messages& messages);

} // namespace occlude
