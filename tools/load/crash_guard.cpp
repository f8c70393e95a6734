#include "load/crash_guard.h"

#include <utility>

#include <unistd.h>

namespace occlude::tools {
namespace {

constexpr int kSignals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
constexpr size_t kStackSize = 64 * 1024; // the kernel saves all vector registers on it

const std::string* g_last_words = nullptr;

// Calls only what POSIX allows in a handler.
extern "C" void say_last_words(int)
{
    constexpr int kFailed = 2;
    const ssize_t written = ::write(STDERR_FILENO, g_last_words->data(), g_last_words->size());
    static_cast<void>(written);
    ::_exit(kFailed);
}

} // namespace

CrashGuard::CrashGuard(std::string last_words)
    : last_words_(std::move(last_words))
    , stack_(kStackSize)
{
    g_last_words = &last_words_;
    stack_t stack{};
    stack.ss_sp = stack_.data();
    stack.ss_size = stack_.size();
    ::sigaltstack(&stack, &stack_before_);
    struct sigaction action {};
    action.sa_handler = say_last_words;
    action.sa_flags = SA_ONSTACK;
    for (const int signal : kSignals) {
        ::sigaction(signal, &action, &actions_before_.emplace_back());
    }
}

CrashGuard::~CrashGuard()
{
    for (size_t i = 0; i < actions_before_.size(); ++i) {
        ::sigaction(kSignals[i], &actions_before_[i], nullptr);
    }
    ::sigaltstack(&stack_before_, nullptr);
    g_last_words = nullptr;
}

} // namespace occlude::tools
