// A file beside the one that it will replace. It is removed however the program ends.
#pragma once

#include <filesystem>
#include <string_view>

namespace occlude::tools {

/// Writes everything to the descriptor. Returns 0, or the errno of the failure.
int write_all(int descriptor, std::string_view content);

/// Removed in the destructor, or by a signal that ends the program (SIGINT, SIGTERM, SIGHUP, unless
/// the program handles them), if it was not renamed. Only one per process at a time is protected
/// from signals.
class TemporaryFile {
public:
    /// Creates `beside`.PID.part with the permissions of `beside`, if that exists.
    explicit TemporaryFile(const std::filesystem::path& beside);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    /// 0, or the errno of the first failure; nothing is done after a failure.
    int failed() const { return failed_; }

    void write(std::string_view content);
    /// For writers of their own; -1 after a failure. It belongs to this object.
    int descriptor() const { return descriptor_; }
    /// Renames the file to its final name, replacing the file there.
    void rename_to(const std::filesystem::path& name);

private:
    void close();

    std::filesystem::path path_;
    int descriptor_ = -1;
    int failed_ = 0;
    bool there_ = false;
};

} // namespace occlude::tools
