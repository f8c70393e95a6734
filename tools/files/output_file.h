// A file that the program writes: either complete, or unchanged.
//
// A plain file is written beside its name and then renamed, so that no reader ever sees half of it.
// Other files are written in place: a device node, a FIFO, a socket's descriptor, a file with
// several names (hard links), and a file that standard output or standard error already writes to.
// A symbolic link stays; its target is replaced.
#pragma once

#include <occlude/core/result.h>

#include <filesystem>
#include <string_view>

namespace occlude::tools {

class OutputFile {
public:
    /// Checks whether `path` can be written later, before long work starts. Leaves nothing behind,
    /// neither a temporary file nor an open descriptor. Errors name the path, the reason and the
    /// remedy.
    static Result<OutputFile> open(const std::filesystem::path& path);

    /// Writes everything. On an error a plain file is unchanged. If SIGINT, SIGTERM or SIGHUP ends
    /// the program meanwhile, the temporary file is removed first.
    Result<bool> commit(std::string_view content);

private:
    enum class How : unsigned char {
        replace, ///< written beside `target_`, then renamed
        through, ///< opened and written in place
    };

    OutputFile(std::filesystem::path path, std::filesystem::path target, How how)
        : path_(std::move(path))
        , target_(std::move(target))
        , how_(how)
    {
    }

    Result<bool> replace(std::string_view content) const;
    Result<bool> write_through(std::string_view content) const;

    std::filesystem::path path_;   ///< as the user wrote it
    std::filesystem::path target_; ///< the target of symbolic links
    How how_;
};

} // namespace occlude::tools
