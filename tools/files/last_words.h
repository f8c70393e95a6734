// Replaces a bare "Segmentation fault" by a sentence: graphics drivers crash if they get no memory.
#pragma once

namespace occlude::tools {

/// From now on, a signal for an invalid address ends the program with a sentence on the standard
/// error output and exit code 2. Nothing is cleaned up. Does nothing in builds with sanitizers,
/// which have their own messages. Call it once, at start-up.
void install_last_words();

} // namespace occlude::tools
