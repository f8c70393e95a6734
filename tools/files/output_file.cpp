#include "files/output_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <unistd.h>

namespace occlude::tools {

namespace fs = std::filesystem;

Result<OutputFile> OutputFile::open(const fs::path& path)
{
    std::error_code ignored;
    if (path.empty() || fs::is_directory(path, ignored)) {
        return Error{
            ErrorCode::invalid_argument,
            fmt::format("cannot write '{}': it is a directory; give a file name", path.string())};
    }
    const fs::path directory = path.has_parent_path() ? path.parent_path() : fs::path{"."};
    if (!fs::is_directory(directory, ignored)) {
        return Error{ErrorCode::not_found,
                     fmt::format("cannot write '{}': there is no directory '{}'; create it first",
                                 path.string(), directory.string())};
    }
    fs::path temporary = path;
    temporary += fmt::format(".{}.part", ::getpid());
    std::ofstream stream{temporary, std::ios::binary | std::ios::trunc};
    if (!stream) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("cannot write '{}': {}; choose another place or change the "
                                 "permissions of '{}'",
                                 path.string(), std::strerror(errno), directory.string())};
    }
    return OutputFile{path, std::move(temporary), std::move(stream)};
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_))
    , temporary_(std::exchange(other.temporary_, {}))
    , stream_(std::move(other.stream_))
{
}

OutputFile::~OutputFile()
{
    if (!temporary_.empty()) {
        std::error_code ignored;
        fs::remove(temporary_, ignored);
    }
}

Result<bool> OutputFile::commit(std::string_view content)
{
    stream_.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream_.close();
    if (!stream_) {
        return Error{ErrorCode::bad_data, fmt::format("cannot write '{}': {}; is the disk full?",
                                                      path_.string(), std::strerror(errno))};
    }
    std::error_code failed;
    fs::rename(temporary_, path_, failed);
    if (failed) {
        return Error{ErrorCode::bad_data,
                     fmt::format("cannot replace '{}': {}", path_.string(), failed.message())};
    }
    temporary_.clear();
    return true;
}

} // namespace occlude::tools
