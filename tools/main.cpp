#include "commands/cli.h"
#include "files/last_words.h"

#include <iostream>

#include <unistd.h>

int main(int argc, char** argv)
{
    using namespace occlude::tools;
    install_last_words();
    const Watcher watcher = ::isatty(STDERR_FILENO) != 0 ? Watcher::terminal : Watcher::log;
    return run_program(argc, argv, {std::cout, std::cerr, watcher});
}
