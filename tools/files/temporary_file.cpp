#include "files/temporary_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace occlude::tools {

namespace fs = std::filesystem;

namespace {

constexpr std::array kEndingSignals = {SIGINT, SIGTERM, SIGHUP};

// The data that the signal handler reads: plain memory, written only while the handler is not
// installed.
std::array<char, PATH_MAX> doomed_path{};
bool guarded = false;

extern "C" void remove_and_end(int signal)
{
    ::unlink(doomed_path.data());
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

void set_handler(void (*from)(int), void (*to)(int))
{
    for (const int signal : kEndingSignals) {
        struct sigaction action {};
        if (::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == from) {
            action.sa_handler = to;
            ::sigaction(signal, &action, nullptr);
        }
    }
}

/// True if a signal that ends the program will remove `path` first.
bool guard(const fs::path& path)
{
    const std::string& text = path.native();
    if (guarded || text.size() >= doomed_path.size()) {
        return false;
    }
    std::memcpy(doomed_path.data(), text.c_str(), text.size() + 1);
    guarded = true;
    set_handler(SIG_DFL, remove_and_end);
    return true;
}

void unguard(const fs::path& path)
{
    if (guarded && path.native() == doomed_path.data()) {
        set_handler(remove_and_end, SIG_DFL);
        guarded = false;
    }
}

} // namespace

int write_all(int descriptor, std::string_view content)
{
    while (!content.empty()) {
        const ssize_t written = ::write(descriptor, content.data(), content.size());
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            return written < 0 ? errno : ENOSPC;
        }
        content.remove_prefix(static_cast<size_t>(written));
    }
    return 0;
}

TemporaryFile::TemporaryFile(const fs::path& beside)
    : path_(beside)
{
    path_ += fmt::format(".{}.part", ::getpid());
    guard(path_);
    constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
    descriptor_ = ::open(path_.c_str(), kFlags, 0666);
    if (descriptor_ < 0 && errno == EEXIST) { // left by a dead process with our number
        ::unlink(path_.c_str());
        descriptor_ = ::open(path_.c_str(), kFlags, 0666);
    }
    if (descriptor_ < 0) {
        failed_ = errno;
        unguard(path_);
        return;
    }
    there_ = true;
    struct stat old {};
    if (::stat(beside.c_str(), &old) == 0) {
        // A file system without permissions refuses this, but only the content matters.
        [[maybe_unused]] const int refused = ::fchmod(descriptor_, old.st_mode & 07777);
    }
}

TemporaryFile::~TemporaryFile()
{
    close();
    if (there_) {
        ::unlink(path_.c_str());
    }
    unguard(path_);
}

void TemporaryFile::write(std::string_view content)
{
    if (failed_ == 0) {
        failed_ = write_all(descriptor_, content);
    }
}

void TemporaryFile::close()
{
    if (descriptor_ >= 0 && ::close(descriptor_) != 0 && failed_ == 0) {
        failed_ = errno;
    }
    descriptor_ = -1;
}

void TemporaryFile::rename_to(const fs::path& name)
{
    close();
    if (failed_ == 0 && std::rename(path_.c_str(), name.c_str()) != 0) {
        failed_ = errno;
    }
    there_ = failed_ != 0;
}

} // namespace occlude::tools
