// Compares the state of OpenGL at a test with what tests need, and names what is wrong.
#pragma once

#include <occlude/backends/gl/detail/gl_target_state.h>
#include <occlude/core/messages.h>
#include <occlude/core/view.h>

namespace occlude {

/// Reports every difference through `messages`. Asks OpenGL some thirty questions, and its error
/// state is read: not for every frame. Ends conditional rendering if it is active. To be called
/// after GlScene::prepare_tests() and before the device has changed anything; `gl_version` is
/// 10 * major + minor.
void check_gl_state(const View& view, const GlTargetState& target, int gl_version,
                    Messages& messages);

} // namespace occlude
