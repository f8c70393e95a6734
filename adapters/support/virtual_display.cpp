#include "virtual_display.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>

#include <sys/prctl.h>
#include <unistd.h>

namespace occlude {

namespace {

constexpr int kFirstDisplay = 1000;
constexpr int kDisplays = 50000;

} // namespace

bool start_virtual_display()
{
    std::array<int, 2> pipe_ends{};
    if (pipe(pipe_ends.data()) != 0) {
        return false;
    }
    const pid_t child = fork();
    if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        close(pipe_ends[0]);
        const std::string end = std::to_string(pipe_ends[1]);
        // A number of its own: a server that is just going away may still have another.
        const std::string display = ":" + std::to_string(kFirstDisplay + getpid() % kDisplays);
        execlp("Xvfb", "Xvfb", display.c_str(), "-displayfd", end.c_str(), "-screen", "0",
               "800x600x24", "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
        _exit(127);
    }
    close(pipe_ends[1]);
    std::string number;
    char digit = 0;
    while (read(pipe_ends[0], &digit, 1) == 1 && digit != '\n') {
        number += digit;
    }
    close(pipe_ends[0]);
    return child > 0 && !number.empty() && setenv("DISPLAY", (":" + number).c_str(), 1) == 0;
}

} // namespace occlude
