#include "files/last_words.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace occlude::tools {
namespace {

TEST(LastWordsDeathTest, AWrongAddressEndsTheProgramWithASentence)
{
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    const auto crash = [] {
        install_last_words();
        std::raise(SIGSEGV);
        std::exit(0);
    };
    EXPECT_EXIT(crash(), testing::ExitedWithCode(2), "the program crashed.*--device cpu");
#endif
}

} // namespace
} // namespace occlude::tools
