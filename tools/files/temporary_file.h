// A file beside the one it will replace, which no way of ending the program leaves behind.
#pragma once

#include <filesystem>
#include <string_view>

namespace occlude::tools {

/// Writes everything to the descriptor. Returns 0, or the errno of the failure.
int write_all(int descriptor, std::string_view content);

/// Removed when it goes out of scope, or by a signal that ends the program (SIGINT, SIGTERM,
/// SIGHUP, as far as nobody else handles them), unless it was renamed. At most one per process at
/// any time has the protection from signals.
class TemporaryFile {
public:
    /// Creates `beside`.PID.part with the permissions of `beside`, if that exists.
    explicit TemporaryFile(const std::filesystem::path& beside);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    /// 0, or the errno of the first thing that failed; nothing is done after a failure.
    int failed() const { return failed_; }

    void write(std::string_view content);
    /// For writers of their own; -1 after a failure. It belongs to this object.
    int descriptor() const { return descriptor_; }
    /// Gives the file its name, replacing what has it.
    void rename_to(const std::filesystem::path& name);

private:
    void close();

    std::filesystem::path path_;
    int descriptor_ = -1;
    int failed_ = 0;
    bool there_ = false;
};

} // namespace occlude::tools
