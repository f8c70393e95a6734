#include "load/guarded_child.h"

#include "load/mapped_file.h"
#include "load/scene_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <string_view>

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace occlude::tools {
namespace {

enum ChildExit : int { kScene = 0, kError = 11, kNoMemory = 12, kException = 13 };

/// Address sanitizers reserve terabytes of addresses, so a limit on them would end every child.
constexpr bool kCanLimitAddresses =
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    false;
#else
    true;
#endif

rlim_t address_space_in_use()
{
    std::ifstream status("/proc/self/statm");
    uint64_t pages = 0;
    status >> pages;
    return static_cast<rlim_t>(pages) * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

void lower_limit(int resource, rlim_t value)
{
    rlimit limit{};
    ::getrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
    limit.rlim_cur = std::min(limit.rlim_max, value);
    ::setrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
}

/// Runs in the child and does not return. Nothing of the parent is cleaned up here: it is not ours.
[[noreturn]] void run_child(int out, const ChildLimits& limits, pid_t parent,
                            const std::function<Result<LoadedScene>()>& read)
{
    ::prctl(PR_SET_PDEATHSIG, SIGKILL); // who waits for us is gone: so are we
    if (::getppid() != parent) {
        ::_exit(kException);
    }
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
        std::signal(signal, SIG_DFL); // no handler of the parent's speaks for us
    }
    lower_limit(RLIMIT_CORE, 0);
    lower_limit(RLIMIT_STACK, rlim_t{1} << 23);
    lower_limit(RLIMIT_CPU, limits.seconds + 1);
    if (kCanLimitAddresses) {
        lower_limit(RLIMIT_AS, address_space_in_use() + (rlim_t{limits.memory_mib} << 20));
    }
    const int silent = ::open("/dev/null", O_WRONLY);
    ::dup2(silent, STDOUT_FILENO); // libraries talk
    ::dup2(silent, STDERR_FILENO);
    std::FILE* stream = ::fdopen(out, "wb");
    int code = kException;
    try {
        const auto scene = read();
        code = scene ? kScene : kError;
        if (scene) {
            code = write_scene(stream, *scene) ? kScene : kNoMemory;
        } else {
            const auto kind = static_cast<char>(scene.error().code);
            std::fwrite(&kind, 1, 1, stream);
            std::fwrite(scene.error().message.data(), 1, scene.error().message.size(), stream);
        }
    } catch (const std::bad_alloc&) {
        code = kNoMemory;
    } catch (const std::exception& error) {
        std::fputs(error.what(), stream);
    } catch (...) {
        std::fputs("an exception of an unknown kind", stream);
    }
    ::_exit(std::fflush(stream) == 0 ? code : kNoMemory);
}

/// A number that this process and its child see.
class SharedShare {
public:
    SharedShare()
        : page_(::mmap(nullptr, sizeof(Share), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS,
                       -1, 0))
        , share_(page_ != MAP_FAILED ? new (page_) Share{0.0} : nullptr)
    {
    }
    ~SharedShare()
    {
        if (share_ != nullptr) {
            ::munmap(page_, sizeof(Share));
        }
    }
    SharedShare(const SharedShare&) = delete;
    SharedShare& operator=(const SharedShare&) = delete;

    void set(double share) const
    {
        if (share_ != nullptr) {
            share_->store(share, std::memory_order_relaxed);
        }
    }
    double get() const { return share_ != nullptr ? share_->load(std::memory_order_relaxed) : 0.0; }

private:
    using Share = std::atomic<double>;
    static_assert(Share::is_always_lock_free, "two processes share it");
    void* page_;
    Share* share_;
};

/// Waits for the child; after `seconds` it is killed. True if it ended by itself.
bool wait_for(pid_t child, uint32_t seconds, int& status, const std::function<void()>& meanwhile)
{
    constexpr int64_t kLookEveryMs = 100;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    const auto process = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
    bool in_time = true;
    while (process >= 0) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
            end - std::chrono::steady_clock::now());
        pollfd ended{process, POLLIN, 0};
        in_time = left.count() > 0;
        if (!in_time ||
            ::poll(&ended, 1, static_cast<int>(std::min(left.count(), kLookEveryMs))) > 0) {
            break;
        }
        meanwhile();
    }
    if (process >= 0) {
        ::close(process);
    }
    if (!in_time) {
        ::kill(child, SIGKILL);
    }
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return in_time;
}

std::string_view as_text(std::span<const uint8_t> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Error child_error(const std::string& file, const std::string& what)
{
    return {ErrorCode::bad_data, fmt::format("{}: {}", file, what)};
}

/// What the way the child ended says, if it is not a scene.
Error describe_end(const std::string& file, const std::string& reader, const ChildLimits& limits,
                   int status, std::span<const uint8_t> bytes)
{
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code == kError && !bytes.empty()) {
        return {static_cast<ErrorCode>(bytes[0]), std::string{as_text(bytes.subspan(1))}};
    }
    const bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL; // for its memory
    if (code == kNoMemory || killed) {
        return child_error(
            file,
            fmt::format("{} needs more than {} MiB to read it; raise --load-memory, or export "
                        "it again, smaller or as GLB",
                        reader, limits.memory_mib));
    }
    if (code == kException) {
        return child_error(file, fmt::format("reading it failed in {} ({}); export it again, "
                                             "smaller or as GLB",
                                             reader, as_text(bytes)));
    }
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU)) {
        return child_error(file,
                           fmt::format("{} did not finish reading it within {} seconds; raise "
                                       "--load-seconds, or export it again as GLB",
                                       reader, limits.seconds));
    }
    return child_error(file, fmt::format("reading it crashed {} ({}): it nests too deeply, refers "
                                         "to itself or is damaged; export it again with fewer "
                                         "levels, or as GLB",
                                         reader,
                                         WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status))
                                                             : "it ended the process"));
}

} // namespace

Result<LoadedScene>
read_in_child(const std::string& file, const std::string& reader, const ChildLimits& limits,
              const ReadProgress& progress,
              const std::function<Result<LoadedScene>(const ReadProgress& progress)>& read)
{
    const SharedShare share;
    const int memory = ::memfd_create("occlude scene", MFD_CLOEXEC);
    const pid_t parent = ::getpid();
    const pid_t child = memory < 0 ? -1 : ::fork();
    if (child < 0) {
        return child_error(file, fmt::format("no process to read it in could be started ({})",
                                             std::strerror(errno)));
    }
    if (child == 0) {
        run_child(memory, limits, parent, [&] { return read([&](double s) { share.set(s); }); });
    }
    int status = 0;
    const bool in_time = wait_for(child, limits.seconds, status, [&] {
        if (progress) {
            progress(share.get());
        }
    });
    auto bytes = MappedFile::of_descriptor(memory, file);
    ::close(memory);
    if (!bytes) {
        return bytes.error();
    }
    if (!in_time) {
        return describe_end(file, reader, limits, SIGXCPU, {});
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == kScene) {
        if (auto scene = read_scene(bytes->bytes())) {
            return std::move(*scene);
        }
        return child_error(file,
                           fmt::format("what {} made of it is not whole; export it again", reader));
    }
    return describe_end(file, reader, limits, status, bytes->bytes());
}

} // namespace occlude::tools
