// Checks of two strengths. Both report a mistake of the caller. Release builds contain neither,
// unless they ask for it.
#pragma once

#include <functional>
#include <string_view>

namespace occlude {

/// Receives the failed condition, its place and a sentence. The default handler prints to stderr
/// and aborts; tests install one that throws. Only builds with OCCLUDE_ASSERTS call it.
using AssertHandler = std::function<void(std::string_view condition, std::string_view message,
                                         std::string_view file, int line)>;

/// Replaces the handler and returns the previous one. Not thread-safe: call it at start-up.
AssertHandler set_assert_handler(AssertHandler handler);

namespace detail {
void assert_failed(std::string_view condition, std::string_view message, std::string_view file,
                   int line);
} // namespace detail

} // namespace occlude

#if !defined(NDEBUG) || defined(OCCLUDE_ENABLE_ASSERTS)
#define OCCLUDE_ASSERTS 1
/// Checks for a caller's bug. Cheap, and always with a message.
#define OCCLUDE_ASSERT(condition, message)                                                         \
    ((condition) ? static_cast<void>(0)                                                            \
                 : ::occlude::detail::assert_failed(#condition, message, __FILE__, __LINE__))
/// A costly check of a whole structure: `call` returns an empty string or the first broken rule.
#define OCCLUDE_VALIDATE(call)                                                                     \
    do {                                                                                           \
        const auto occlude_problem = (call);                                                       \
        if (!occlude_problem.empty()) {                                                            \
            ::occlude::detail::assert_failed(#call, occlude_problem, __FILE__, __LINE__);          \
        }                                                                                          \
    } while (false)
#else
#define OCCLUDE_ASSERTS 0
#define OCCLUDE_ASSERT(condition, message) static_cast<void>(0)
#define OCCLUDE_VALIDATE(call) static_cast<void>(0)
#endif
