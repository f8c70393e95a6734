// A file that is there completely or not at all: written beside its name and renamed at the end.
#pragma once

#include <occlude/core/result.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace occlude::tools {

class OutputFile {
public:
    /// Makes sure now that `path` can be written later: creates a temporary file in its directory.
    /// Errors name the path, the reason and the remedy.
    static Result<OutputFile> open(const std::filesystem::path& path);

    /// Writes everything and gives the file its name, replacing what was there.
    Result<bool> commit(std::string_view content);

    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&&) = delete;
    /// Removes the temporary file unless committed.
    ~OutputFile();

private:
    OutputFile(std::filesystem::path path, std::filesystem::path temporary, std::ofstream stream)
        : path_(std::move(path))
        , temporary_(std::move(temporary))
        , stream_(std::move(stream))
    {
    }

    std::filesystem::path path_;
    std::filesystem::path temporary_; ///< empty: nothing to remove
    std::ofstream stream_;
};

} // namespace occlude::tools
