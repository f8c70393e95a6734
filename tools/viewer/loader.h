// Loads a scene beside the program, so that the window goes on living.
#pragma once

#include "options/options.h"
#include "session/session.h"

#include <occlude/core/clock.h>

#include <memory>
#include <optional>
#include <string>

namespace occlude::tools::viewer {

class Loader {
public:
    using Loaded = Result<std::unique_ptr<Session>>;

    /// Starts to load in a thread of its own; what was loading before is given up.
    void start(const std::string& scene, const StageOptions& options);
    /// Gives up: nothing will come. The thread ends by itself when it has done what it does.
    void cancel();

    bool loading() const { return job_ != nullptr; }
    const std::string& scene() const { return scene_; }
    /// What is being done: "reading", "building the tree".
    std::string phase() const;
    /// The share of the phase that is done; NaN where nobody knows it.
    double share() const;
    double seconds() const;

    /// What was loaded, once; without a renderer yet (Session::start).
    std::optional<Loaded> poll();

private:
    struct Job;

    std::shared_ptr<Job> job_;
    std::string scene_;
    double started_s_ = 0.0;
    SecondsClock clock_ = steady_seconds_clock();
};

} // namespace occlude::tools::viewer
