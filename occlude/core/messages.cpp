#include <occlude/core/messages.h>

#include <algorithm>

namespace occlude {

bool Messages::due(std::string_view name) const
{
    return handler_ && std::ranges::find(reported_, name) == reported_.end();
}

void Messages::report(Severity severity, std::string_view name, std::string_view text)
{
    if (due(name)) {
        reported_.push_back(name);
        handler_({severity, name, text});
    }
}

} // namespace occlude
