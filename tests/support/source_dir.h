// Where the repository lies, for tests that read its assets and documents.
#pragma once

#include <string>

namespace occlude {

/// The repository's folder, absolute, without a slash at its end.
std::string source_dir();

} // namespace occlude
