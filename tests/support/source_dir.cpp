#include "support/source_dir.h"

namespace occlude {

std::string source_dir()
{
    return OCCLUDE_SOURCE_DIR;
}

} // namespace occlude
