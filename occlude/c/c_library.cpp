#include <occlude/c/detail/guard.h>

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <utility>

namespace occlude::c {

namespace {

std::string& last_error()
{
    thread_local std::string sentence;
    return sentence;
}

occlude_status status_of(ErrorCode code)
{
    switch (code) {
    case ErrorCode::invalid_argument:
        return OCCLUDE_INVALID_ARGUMENT;
    case ErrorCode::not_found:
        return OCCLUDE_NOT_FOUND;
    case ErrorCode::bad_data:
        return OCCLUDE_BAD_DATA;
    case ErrorCode::unsupported:
        return OCCLUDE_UNSUPPORTED;
    case ErrorCode::device_failed:
        return OCCLUDE_DEVICE_FAILED;
    }
    return OCCLUDE_INVALID_ARGUMENT;
}

} // namespace

occlude_status fail(occlude_status status, std::string sentence) noexcept
{
    last_error() = std::move(sentence);
    return status;
}

occlude_status fail(const Error& error) noexcept
{
    try {
        return fail(status_of(error.code), error.message);
    } catch (...) {
        last_error().clear(); // the sentence did not fit into memory; the status still tells
        return status_of(error.code);
    }
}

Result<std::vector<OptionValue>> options_from(const occlude_option* options, size_t count)
{
    std::vector<OptionValue> values;
    if (count > 0 && options == nullptr) {
        return Error{ErrorCode::invalid_argument,
                     "options is null, but option_count is " + std::to_string(count)};
    }
    for (size_t i = 0; i < count; ++i) {
        if (options[i].name == nullptr || options[i].value == nullptr) {
            return Error{ErrorCode::invalid_argument,
                         "option " + std::to_string(i) + " has no name or no value"};
        }
        values.emplace_back(options[i].name, options[i].value);
    }
    return values;
}

} // namespace occlude::c

using namespace occlude;

extern "C" {

const char* occlude_version(void)
{
    return OCCLUDE_VERSION;
}

uint32_t occlude_abi_version(void)
{
    return OCCLUDE_C_ABI_VERSION;
}

const char* occlude_last_error(void)
{
    return c::last_error().c_str();
}

size_t occlude_algorithm_count(void)
{
    return algorithms().size();
}

occlude_status occlude_algorithm_at(size_t index, occlude_algorithm* algorithm)
{
    return c::guarded([&] {
        if (algorithm == nullptr || index >= algorithms().size()) {
            return c::fail(OCCLUDE_INVALID_ARGUMENT,
                           "there are " + std::to_string(algorithms().size()) +
                               " algorithms, and `algorithm` must not be null");
        }
        const AlgorithmInfo& info = algorithms()[index];
        *algorithm = {info.name.c_str(),  info.paper.c_str(),    info.summary.c_str(),  info.exact,
                      info.needs.queries, info.needs.depth_read, info.needs.visible_set};
        return OCCLUDE_OK;
    });
}

size_t occlude_hierarchy_kind_count(void)
{
    return hierarchy_kinds().size();
}

const char* occlude_hierarchy_kind_at(size_t index)
{
    // The names are string literals, so they end in a zero.
    return index < hierarchy_kinds().size() ? hierarchy_kinds()[index].name.data() : nullptr;
}

} // extern "C"
