#include <occlude/core/result.h>

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace occlude {
namespace {

Result<int> parse_digit(const std::string& text)
{
    if (text.size() != 1 || text[0] < '0' || text[0] > '9') {
        return Error{ErrorCode::bad_data, "'" + text + "' is not a digit"};
    }
    return text[0] - '0';
}

TEST(Result, HoldsAValue)
{
    const Result<int> result = parse_digit("7");
    ASSERT_TRUE(result);
    EXPECT_EQ(*result, 7);
    EXPECT_EQ(result.value(), 7);
}

TEST(Result, HoldsAnErrorWithASentence)
{
    const Result<int> result = parse_digit("x");
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::bad_data);
    EXPECT_EQ(result.error().message, "'x' is not a digit");
}

TEST(Result, MovesValuesThatCannotBeCopied)
{
    Result<std::unique_ptr<int>> result = std::make_unique<int>(3);
    ASSERT_TRUE(result);
    const std::unique_ptr<int> owned = std::move(*result);
    EXPECT_EQ(*owned, 3);
}

TEST(Result, ArrowReachesIntoTheValue)
{
    Result<std::string> result = std::string("abc");
    result->push_back('d');
    EXPECT_EQ(*result, "abcd");
}

#if OCCLUDE_ASSERTS
TEST(Result, ReadingTheWrongSideIsACallersBug)
{
    const AssertHandler before =
        set_assert_handler([](std::string_view, std::string_view message, std::string_view, int) {
            throw std::logic_error(std::string(message));
        });
    EXPECT_THROW(static_cast<void>(parse_digit("x").value()), std::logic_error);
    EXPECT_THROW(static_cast<void>(parse_digit("1").error()), std::logic_error);
    set_assert_handler(before);
}
#endif

} // namespace
} // namespace occlude
