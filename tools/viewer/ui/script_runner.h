// Plays a script of inputs, one step of an input per frame.
#pragma once

#include "viewer/script.h"
#include "viewer/ui/widgets.h"
#include "viewer/ui/window.h"

#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace occlude::tools::viewer {

class ScriptRunner {
public:
    ScriptRunner(std::vector<ScriptStep> steps, std::string name)
        : steps_(std::move(steps))
        , name_(std::move(name))
    {
    }

    /// What the program must know before a frame.
    struct Status {
        bool loading = false;
    };
    /// Feeds the input of the next frame to the window. `notes` are those of the last frame. An
    /// error: an assertion that does not hold, or a label that is not there.
    Result<bool> step(Window& window, const Status& status, const ScreenNotes& notes);

    /// A picture to be written after the frame that comes; empty: none.
    std::string take_screenshot() { return std::exchange(screenshot_, {}); }

    /// Everything has been played.
    bool done() const { return next_ >= steps_.size() && queue_.empty() && wait_ == 0; }

private:
    Result<bool> begin(const ScriptStep& step, const ScreenNotes& notes);
    Result<bool> waits(const Status& status, const ScreenNotes& notes);
    void queue_input(const ScriptStep& step);
    void drag(const ScriptStep& step);
    void click(glm::vec2 at, int button);
    Error failed(const ScriptStep& step, const std::string& what) const;

    std::vector<ScriptStep> steps_;
    std::string name_;
    size_t next_ = 0;
    std::deque<std::vector<InputEvent>> queue_; ///< of the frames to come
    int wait_ = 0;
    int waited_ = 0; ///< frames, for a text to appear
    std::string screenshot_;
};

} // namespace occlude::tools::viewer
