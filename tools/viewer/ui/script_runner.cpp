#include "viewer/ui/script_runner.h"

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools::viewer {

using Kind = InputEvent::Kind;

Error ScriptRunner::failed(const ScriptStep& step, const std::string& what) const
{
    return {ErrorCode::bad_data, fmt::format("{}: line {}: {}", name_, step.line, what)};
}

void ScriptRunner::click(glm::vec2 at, int button)
{
    queue_.push_back({{.kind = Kind::move, .at = at}});
    queue_.push_back({{.kind = Kind::button, .code = button, .down = true, .at = at}});
    queue_.push_back({{.kind = Kind::button, .code = button, .down = false, .at = at}});
}

void ScriptRunner::drag(const ScriptStep& step)
{
    constexpr int kDragFrames = 4;
    queue_.push_back({{.kind = Kind::move, .at = step.from}});
    queue_.push_back({{.kind = Kind::button, .code = step.button, .down = true, .at = step.from}});
    for (int i = 1; i <= kDragFrames; ++i) {
        const float share = static_cast<float>(i) / static_cast<float>(kDragFrames);
        queue_.push_back({{.kind = Kind::move, .at = step.from + share * (step.to - step.from)}});
    }
    queue_.push_back({{.kind = Kind::button, .code = step.button, .down = false, .at = step.to}});
}

// The frames of an input.
void ScriptRunner::queue_input(const ScriptStep& step)
{
    const auto key = [&](bool down) {
        return InputEvent{
            .kind = Kind::key, .code = step.key, .down = down, .control = step.control};
    };
    switch (step.kind) {
    case ScriptStep::Kind::key:
    case ScriptStep::Kind::hold:
        queue_.push_back({key(true)});
        for (int i = 1; i < step.count; ++i) {
            queue_.emplace_back();
        }
        queue_.push_back({key(false)});
        break;
    case ScriptStep::Kind::move:
        queue_.push_back({{.kind = Kind::move, .at = step.from}});
        break;
    case ScriptStep::Kind::click:
        click(step.from, 0);
        break;
    case ScriptStep::Kind::drag:
        drag(step);
        break;
    case ScriptStep::Kind::scroll:
        queue_.push_back({{.kind = Kind::scroll, .at = {0.0f, static_cast<float>(step.count)}}});
        break;
    case ScriptStep::Kind::type:
        for (const char c : step.text) {
            queue_.push_back({{.kind = Kind::character, .code = c}});
        }
        break;
    case ScriptStep::Kind::drop:
        queue_.push_back({{.kind = Kind::drop, .text = step.text}});
        break;
    case ScriptStep::Kind::resize:
        queue_.push_back({{.kind = Kind::resize, .at = step.to}});
        break;
    default: // no input
        break;
    }
}

Result<bool> ScriptRunner::begin(const ScriptStep& step, const ScreenNotes& notes)
{
    switch (step.kind) {
    case ScriptStep::Kind::wait:
        wait_ = step.count;
        break;
    case ScriptStep::Kind::click_label: {
        const auto place = notes.places.find(step.text);
        if (place == notes.places.end()) {
            return failed(step, fmt::format("nothing in sight is labelled '{}'", step.text));
        }
        click({place->second.x, place->second.y}, 0);
        break;
    }
    case ScriptStep::Kind::assert_text:
    case ScriptStep::Kind::assert_no_text: {
        const bool shown = notes.text.find(step.text) != std::string::npos;
        const bool wanted = step.kind == ScriptStep::Kind::assert_text;
        if (shown != wanted) {
            return failed(step, fmt::format("the text '{}' is {}shown; the window says:\n{}",
                                            step.text, wanted ? "not " : "", notes.text));
        }
        break;
    }
    case ScriptStep::Kind::screenshot:
        screenshot_ = step.text;
        wait_ = 1;
        break;
    default:
        queue_input(step);
        break;
    }
    return true;
}

// Whether a step that waits for something waits on; an error when it has waited for too long.
Result<bool> ScriptRunner::waits(const Status& status, const ScreenNotes& notes)
{
    constexpr int kMostFrames = 5000;
    const ScriptStep& step = steps_[next_];
    const bool not_loaded = step.kind == ScriptStep::Kind::wait_loaded && status.loading;
    const bool not_shown =
        step.kind == ScriptStep::Kind::wait_text && notes.text.find(step.text) == std::string::npos;
    waited_ = not_shown ? waited_ + 1 : 0;
    if (waited_ > kMostFrames) {
        return failed(step, fmt::format("the text '{}' did not appear in {} frames; the window "
                                        "says:\n{}",
                                        step.text, kMostFrames, notes.text));
    }
    return not_loaded || not_shown;
}

Result<bool> ScriptRunner::step(Window& window, const Status& status, const ScreenNotes& notes)
{
    if (wait_ > 0) {
        --wait_;
        return true;
    }
    while (queue_.empty() && wait_ == 0 && next_ < steps_.size()) {
        const auto waiting = waits(status, notes);
        if (!waiting || *waiting) {
            return waiting;
        }
        if (const auto begun = begin(steps_[next_], notes); !begun) {
            return begun.error();
        }
        ++next_;
    }
    if (!queue_.empty()) {
        for (const InputEvent& event : queue_.front()) {
            window.feed(event);
        }
        queue_.pop_front();
    }
    return true;
}

} // namespace occlude::tools::viewer
