// A caller's mistake: in builds with assertions the handler is called with a sentence; in release
// builds the call has a safe result. Both builds run the code after the assertion.
#pragma once

#include <occlude/core/assert.h>

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace occlude::test {

/// Collects the sentences of failed assertions. The process goes on.
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

    /// Expects that the calls since the last check were a mistake: builds with assertions report a
    /// sentence that contains `part`, other builds report nothing.
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

    /// Expects that the calls since the last check were no mistake.
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
