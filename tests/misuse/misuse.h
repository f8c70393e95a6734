// What a caller's mistake does: in builds with assertions the handler is called with a sentence, in
// release builds nothing happens but a safe answer. Both builds run the code after the assertion.
#pragma once

#include <occlude/core/assert.h>

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace occlude::test {

/// Collects the sentences of failed assertions instead of aborting.
class Mistakes {
public:
    Mistakes()
        : before_(set_assert_handler([this](std::string_view, std::string_view message,
                                            std::string_view,
                                            int) { sentences_.emplace_back(message); }))
    {
    }
    ~Mistakes() { set_assert_handler(before_); }
    Mistakes(const Mistakes&) = delete;
    Mistakes& operator=(const Mistakes&) = delete;

    /// That the calls since the last time were noticed, by builds that assert, with a sentence that
    /// contains `part`; and by others not at all.
    void expect(const std::string& part)
    {
#if OCCLUDE_ASSERTS
        const bool said = !sentences_.empty() && sentences_.front().find(part) != std::string::npos;
        EXPECT_TRUE(said) << "no assertion says '" << part << "'"
                          << (sentences_.empty() ? "" : "; the first says " + sentences_.front());
#else
        EXPECT_TRUE(sentences_.empty());
        static_cast<void>(part);
#endif
        sentences_.clear();
    }

    /// That the calls since the last time are no mistakes.
    void expect_none()
    {
        EXPECT_EQ(sentences_, std::vector<std::string>{});
        sentences_.clear();
    }

private:
    AssertHandler before_;
    std::vector<std::string> sentences_;
};

} // namespace occlude::test
