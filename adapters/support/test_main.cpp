#include "virtual_display.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

// Tests are listed without a display, and run in one of their own.
int main(int argc, char** argv)
{
    const bool lists = argc > 1 && std::strcmp(argv[1], "--gtest_list_tests") == 0;
    testing::InitGoogleTest(&argc, argv);
    if (!lists && !occlude::start_virtual_display()) {
        std::fputs("Xvfb could not be started: install the package xvfb\n", stderr);
        return EXIT_FAILURE;
    }
    return RUN_ALL_TESTS();
}
