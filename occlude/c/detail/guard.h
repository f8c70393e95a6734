// The frame of every function of the C interface: nothing throws across it, and a status other than
// OCCLUDE_OK leaves a sentence.
#pragma once

#include <occlude/c/occlude.h>
#include <occlude/core/option_text.h>
#include <occlude/core/query_device.h>
#include <occlude/core/result.h>
#include <occlude/hierarchy/hierarchy.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <vector>

namespace occlude::c {

/// Keeps the sentence for occlude_last_error() of this thread, and returns `status`.
occlude_status fail(occlude_status status, std::string sentence) noexcept;
occlude_status fail(const Error& error) noexcept;

/// Runs `body`, which returns an occlude_status, and turns an exception into a status.
template <class Body>
occlude_status guarded(Body&& body) noexcept
{
    try {
        return body();
    } catch (const std::bad_alloc&) {
        return fail(OCCLUDE_OUT_OF_MEMORY, "there is not enough memory");
    } catch (const std::exception& error) {
        return fail(OCCLUDE_DEVICE_FAILED, error.what());
    } catch (...) {
        return fail(OCCLUDE_DEVICE_FAILED, "a callback threw");
    }
}

/// A copy of a struct of the caller, who may know fewer members; the missing ones are 0.
template <class Struct>
Struct all_members(const Struct& from)
{
    Struct all{};
    std::memcpy(&all, &from, std::min(from.struct_size, sizeof all));
    return all;
}

/// Options as the registry takes them. An error names the entry whose name or value is null.
Result<std::vector<OptionValue>> options_from(const occlude_option* options, size_t count);

/// The library's form of a view; an error says what is missing.
Result<View> view_from(const occlude_view* view);

} // namespace occlude::c
