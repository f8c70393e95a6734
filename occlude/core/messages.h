// How the library tells its host that something is wrong. It prints nothing by itself: without a
// handler it stays silent.
//
//   GlDeviceOptions::on_message       what the device and the engine's OpenGL state have
//   Culler::set_message_handler       what a culler notices of its device and of its view
//
// Every message has a name that never changes, by which a host can filter, and is reported once by
// each object: a fault of every frame is one message.
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

/// Views are valid during the call of the handler only.
struct Message {
    Severity severity = Severity::note;
    std::string_view name; ///< "gl.viewport", "culler.lost_answers", ...
    std::string_view text; ///< what is wrong, where, and what to do
};

/// Called in the thread that called the library, in the middle of its work: it must not call the
/// object that reports.
using MessageHandler = std::function<void(const Message&)>;

/// What an object of the library has told its host.
class Messages {
public:
    explicit Messages(MessageHandler handler = {})
        : handler_(std::move(handler))
    {
    }

    /// True if report() would call the handler: ask before making the text.
    bool due(std::string_view name) const;

    /// Calls the handler, unless there is none or a message of that name was reported before.
    /// `name` must live as long as this object: a literal.
    void report(Severity severity, std::string_view name, std::string_view text);

private:
    MessageHandler handler_;
    std::vector<std::string_view> reported_;
};

} // namespace occlude
