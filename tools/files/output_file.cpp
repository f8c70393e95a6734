#include "files/output_file.h"

#include "files/temporary_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace occlude::tools {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxLinks = 40; // Linux follows as many

Error cannot_write(const fs::path& path, std::string_view why)
{
    return {ErrorCode::invalid_argument, fmt::format("cannot write '{}': {}", path.string(), why)};
}

bool same_file(const struct stat& a, const struct stat& b)
{
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// The descriptor of standard output or standard error, if it writes to this plain file. Renaming
/// would separate the file from the descriptor; a second descriptor would overwrite its output.
std::optional<int> standard_stream_to(const struct stat& file)
{
    for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) {
        struct stat stream {};
        if (::fstat(descriptor, &stream) == 0 && S_ISREG(stream.st_mode) &&
            same_file(stream, file)) {
            return descriptor;
        }
    }
    return std::nullopt;
}

/// The file at the end of a chain of symbolic links, whether it exists or not; empty if the links
/// run in a circle.
fs::path follow_links(fs::path path)
{
    for (int links = 0; links < kMaxLinks; ++links) {
        std::error_code not_a_link;
        const fs::path next = fs::read_symlink(path, not_a_link);
        if (not_a_link) {
            return path;
        }
        path = next.is_absolute() ? next : path.parent_path() / next;
    }
    return {};
}

fs::path directory_of(const fs::path& path)
{
    return path.has_parent_path() ? path.parent_path() : fs::path{"."};
}

} // namespace

Result<OutputFile> OutputFile::open(const fs::path& path)
{
    if (path.empty()) {
        return cannot_write(path, "the name is empty; give a file name");
    }
    struct stat there {};
    const bool exists = ::stat(path.c_str(), &there) == 0;
    std::error_code ignored;
    if (exists ? S_ISDIR(there.st_mode) : !path.has_filename()) {
        return cannot_write(path, "it is a directory; give a file name");
    }
    if (exists && ::access(path.c_str(), W_OK) != 0) {
        return cannot_write(path, fmt::format("{}; choose another place or change its permissions",
                                              std::strerror(errno)));
    }
    const bool plain = exists && S_ISREG(there.st_mode) && there.st_nlink == 1;
    if (exists && (!plain || standard_stream_to(there))) {
        return OutputFile{path, path, How::through};
    }
    fs::path target = follow_links(path);
    if (target.empty()) {
        return cannot_write(path, "its symbolic links lead in a circle; choose another place");
    }
    const fs::path directory = directory_of(target);
    if (!fs::is_directory(directory, ignored)) {
        return Error{ErrorCode::not_found,
                     fmt::format("cannot write '{}': there is no directory '{}'; create it first",
                                 path.string(), directory.string())};
    }
    if (const TemporaryFile probe{target}; probe.failed() != 0) {
        if (exists) { // the directory accepts no new files, but this file can be written
            return OutputFile{path, path, How::through};
        }
        return cannot_write(
            path, fmt::format("{}; choose another place or change the permissions of '{}'",
                              std::strerror(probe.failed()), directory.string()));
    }
    return OutputFile{path, std::move(target), How::replace};
}

Result<bool> OutputFile::commit(std::string_view content)
{
    return how_ == How::replace ? replace(content) : write_through(content);
}

Result<bool> OutputFile::replace(std::string_view content) const
{
    TemporaryFile file{target_};
    if (file.failed() == 0) {
        file.write(content);
    }
    if (file.failed() == 0) {
        file.rename_to(target_);
    }
    if (file.failed() != 0) {
        return Error{ErrorCode::bad_data, fmt::format("cannot write '{}': {}", path_.string(),
                                                      std::strerror(file.failed()))};
    }
    return true;
}

Result<bool> OutputFile::write_through(std::string_view content) const
{
    struct stat there {};
    std::optional<int> stream;
    if (::stat(target_.c_str(), &there) == 0 && S_ISREG(there.st_mode)) {
        stream = standard_stream_to(there);
    }
    // Truncates a plain file; others have no length. Opening a FIFO waits for its reader here.
    const int descriptor =
        stream ? ::dup(*stream) : ::open(target_.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC, 0666);
    int failed = descriptor < 0 ? errno : write_all(descriptor, content);
    if (descriptor >= 0 && ::close(descriptor) != 0 && failed == 0) {
        failed = errno;
    }
    if (failed != 0) {
        return Error{ErrorCode::bad_data,
                     fmt::format("cannot write '{}': {}", path_.string(), std::strerror(failed))};
    }
    return true;
}

} // namespace occlude::tools
