// Messages by which the library tells its host that something is wrong. It prints nothing itself,
// and is silent without a handler.
//
//   GlDeviceOptions::on_message       faults of the device and of the engine's OpenGL state
//   Culler::set_message_handler       faults that a culler notices of its device and of its view
//
// Every message has a name that never changes, so that a host can filter by it. Each object reports
// a message once, even if the fault recurs in every frame.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

namespace occlude {

enum class Severity : uint8_t {
    note,    ///< the image is right; something costs time
    warning, ///< the image is right because the library gave up culling
    error,   ///< the image may be wrong: objects may be missing
};
/// "note", "warning" or "error".
constexpr const char* name(Severity severity)
{
    switch (severity) {
    case Severity::note:
        return "note";
    case Severity::warning:
        return "warning";
    case Severity::error:
        break;
    }
    return "error";
}

/// The views are valid only during the call of the handler.
struct Message {
    Severity severity = Severity::note;
    std::string_view name; ///< "gl.viewport", "culler.lost_answers", ...
    std::string_view text; ///< what is wrong, where, and what to do
};

/// Called in the thread that called the library, in the middle of its work: it must not call the
/// object that reports.
using MessageHandler = std::function<void(const Message&)>;

/// The messages that an object of the library has already reported.
class Messages {
public:
    explicit Messages(MessageHandler handler = {})
        : handler_(std::move(handler))
    {
    }

    /// True if report() would call the handler: check this before composing the text.
    bool due(std::string_view name) const;

    /// Calls the handler, unless there is none or a message of that name was already reported.
    /// `name` must outlive this object: use a literal.
    void report(Severity severity, std::string_view name, std::string_view text);

private:
    MessageHandler handler_;
    std::vector<std::string_view> reported_;
};

} // namespace occlude
