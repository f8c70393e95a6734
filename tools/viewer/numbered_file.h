// Names for files that the viewer writes without asking.
#pragma once

#include <occlude/core/result.h>
#include <occlude/device/recording.h>

#include <filesystem>
#include <string>

namespace occlude::tools::viewer {

/// The first of "STEM-1.EXTENSION", "STEM-2.EXTENSION", ... in the current folder that is not there
/// yet.
inline std::filesystem::path numbered_file(const std::string& stem, const std::string& extension)
{
    for (int number = 1;; ++number) {
        std::filesystem::path path{stem + "-" + std::to_string(number) + "." + extension};
        std::error_code ignored;
        if (!std::filesystem::exists(path, ignored)) {
            return path;
        }
    }
}

/// Writes a recording to `file`: all of it, or nothing.
Result<bool> save_trace(const Recording& recording, const std::filesystem::path& file);

} // namespace occlude::tools::viewer
