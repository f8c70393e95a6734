#include <occlude/core/assert.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace occlude {

static AssertHandler& handler()
{
    static AssertHandler current = [](std::string_view condition, std::string_view message,
                                      std::string_view file, int line) {
        std::fprintf(stderr, "%.*s:%d: %.*s (%.*s)\n", static_cast<int>(file.size()), file.data(),
                     line, static_cast<int>(message.size()), message.data(),
                     static_cast<int>(condition.size()), condition.data());
        std::abort();
    };
    return current;
}

AssertHandler set_assert_handler(AssertHandler next)
{
    return std::exchange(handler(), std::move(next));
}

namespace detail {

void assert_failed(std::string_view condition, std::string_view message, std::string_view file,
                   int line)
{
    handler()(condition, message, file, line);
}

} // namespace detail
} // namespace occlude
