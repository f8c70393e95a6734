#include <occlude/core/messages.h>

#include <gtest/gtest.h>

#include <string>

namespace occlude {
namespace {

TEST(Messages, EachNameIsReportedOnce)
{
    std::string heard;
    Messages messages{[&](const Message& message) {
        heard += std::string(name(message.severity)) + " " + std::string(message.name) + ": " +
                 std::string(message.text) + "\n";
    }};
    EXPECT_TRUE(messages.due("a"));
    messages.report(Severity::error, "a", "first");
    EXPECT_FALSE(messages.due("a"));
    messages.report(Severity::error, "a", "again");
    messages.report(Severity::note, "b", "other");
    EXPECT_EQ(heard, "error a: first\nnote b: other\n");
}

TEST(Messages, NothingIsDueWithoutAHandler)
{
    Messages messages;
    EXPECT_FALSE(messages.due("a"));
    messages.report(Severity::warning, "a", "nobody hears it");
}

} // namespace
} // namespace occlude
