// Result<T>: a value, or an error with a sentence for a person. Nothing in the library throws
// across its boundary; what can go wrong in the world (files, drivers, options) comes back as a
// Result.
#pragma once

#include <occlude/core/assert.h>

#include <string>
#include <utility>
#include <variant>

namespace occlude {

enum class ErrorCode : unsigned char {
    invalid_argument, ///< the caller asked for something that has no meaning
    not_found,        ///< a file, a name or an entry does not exist
    bad_data,         ///< it exists but is broken
    unsupported,      ///< the device or this build cannot do it
    device_failed,    ///< the graphics API refused
};

struct Error {
    ErrorCode code = ErrorCode::invalid_argument;
    std::string message; ///< names the thing, the place and the remedy
};

template <class T>
class Result {
public:
    Result(T value)
        : state_(std::move(value))
    {
    }
    Result(Error error)
        : state_(std::move(error))
    {
    }

    explicit operator bool() const { return std::holds_alternative<T>(state_); }

    T& operator*() { return value(); }
    const T& operator*() const { return value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    /// The value. Precondition: the result holds one.
    T& value()
    {
        OCCLUDE_ASSERT(*this, "value() of a failed Result");
        return std::get<T>(state_);
    }
    const T& value() const
    {
        OCCLUDE_ASSERT(*this, "value() of a failed Result");
        return std::get<T>(state_);
    }

    /// The error. Precondition: the result holds none.
    const Error& error() const
    {
        OCCLUDE_ASSERT(!*this, "error() of a Result that succeeded");
        return std::get<Error>(state_);
    }

private:
    std::variant<T, Error> state_;
};

} // namespace occlude
