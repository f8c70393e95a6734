#include "viewer/numbered_file.h"

#include "files/output_file.h"

#include <sstream>

namespace occlude::tools::viewer {

Result<bool> save_trace(const Recording& recording, const std::filesystem::path& file)
{
    std::ostringstream bytes;
    if (const auto saved = save_recording(recording, bytes); !saved) {
        return saved.error();
    }
    auto output = OutputFile::open(file);
    return output ? output->commit(bytes.view()) : Result<bool>{output.error()};
}

} // namespace occlude::tools::viewer
