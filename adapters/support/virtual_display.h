// An X server without a screen, for tests that need windows.
#pragma once

namespace occlude {

/// Starts Xvfb, which ends with this process, and sets DISPLAY. False if there is none.
bool start_virtual_display();

} // namespace occlude
