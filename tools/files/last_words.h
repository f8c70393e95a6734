// A sentence instead of a bare "Segmentation fault": graphics drivers crash where they get no
// memory.
#pragma once

namespace occlude::tools {

/// From now on a signal that means a wrong address ends the program with a sentence on the standard
/// error output and exit code 2. Nothing is cleaned up. Does nothing in builds with sanitizers,
/// which have last words of their own. Call it once, at start-up.
void install_last_words();

} // namespace occlude::tools
