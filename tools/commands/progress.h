// Progress with an estimate: a bar for a person at a terminal, a line now and then in a log.
#pragma once

#include "measure/timing_device.h"

#include <iosfwd>
#include <string>

namespace occlude::tools {

/// Who reads the error stream: a person at a terminal, a log (a file or a pipe), or nobody.
enum class Watcher { terminal, log, none };

/// A line of progress on a stream that a person may watch.
class Progress {
public:
    Progress(std::ostream& err, Watcher watcher, std::string label,
             SecondsClock clock = steady_seconds_clock());
    /// Erases the bar.
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Shows that `share` (0 to 1) of the work is done. Draws a bar at most ten times a second, and
    /// writes a line to a log at most every ten seconds. If `share` is NaN, the total is unknown,
    /// and the elapsed time is shown instead.
    void show(double share);
    /// The same for work in phases, each with its own name and estimate.
    void show(const std::string& phase, double share);

private:
    void show_at_once();

    std::ostream& err_;
    Watcher watcher_;
    std::string label_;
    std::string phase_;
    SecondsClock clock_;
    double start_;
    double last_shown_;
    size_t width_ = 0; ///< width of the line on the screen
};

} // namespace occlude::tools
