// Last words for what a library that reads files does not survive.
#pragma once

#include <string>
#include <vector>

#include <signal.h>

namespace occlude::tools {

/// While it lives, a signal by which this thread would die without a word (the end of its stack, a
/// wrong address, abort) ends the program with a sentence on the standard error output and exit
/// code 2 instead. Nothing is cleaned up: after a crash nothing can be trusted to. One at a time.
class CrashGuard {
public:
    /// `last_words`: the whole sentence, with its line end.
    explicit CrashGuard(std::string last_words);
    ~CrashGuard();
    CrashGuard(const CrashGuard&) = delete;
    CrashGuard& operator=(const CrashGuard&) = delete;

private:
    std::string last_words_;
    std::vector<char> stack_; ///< for the handler: there may be none left of the thread's own
    stack_t stack_before_{};
    std::vector<struct sigaction> actions_before_;
};

} // namespace occlude::tools
