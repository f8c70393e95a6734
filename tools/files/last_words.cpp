#include "files/last_words.h"

#include <array>
#include <string_view>

#include <signal.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define OCCLUDE_SANITIZED 1
#else
#define OCCLUDE_SANITIZED 0
#endif

namespace occlude::tools {
namespace {

constexpr std::string_view kLastWords =
    "occlude: the program crashed. If memory is limited (ulimit -v, a container), the graphics "
    "driver may have run out of it: allow more, use --device cpu, or a smaller --size. Otherwise "
    "this is a bug: please report the command.\n";

alignas(16) std::array<char, 64 * 1024> g_stack; // the thread's own stack may be full

// Calls only what POSIX allows in a handler.
void say_last_words(int)
{
    constexpr int kFailed = 2;
    const ssize_t written = ::write(STDERR_FILENO, kLastWords.data(), kLastWords.size());
    static_cast<void>(written);
    ::_exit(kFailed);
}

} // namespace

void install_last_words()
{
    if (OCCLUDE_SANITIZED != 0) {
        return;
    }
    stack_t stack{};
    stack.ss_sp = g_stack.data();
    stack.ss_size = g_stack.size();
    ::sigaltstack(&stack, nullptr);
    struct sigaction action {};
    action.sa_handler = say_last_words;
    action.sa_flags = SA_ONSTACK;
    for (const int signal : {SIGSEGV, SIGBUS}) {
        ::sigaction(signal, &action, nullptr);
    }
}

} // namespace occlude::tools
