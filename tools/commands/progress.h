// A progress bar with an estimate, for a person at a terminal; silent for everyone else.
#pragma once

#include "measure/timing_device.h"

#include <iosfwd>
#include <string>

namespace occlude::tools {

/// Whether someone watches the error stream.
enum class Watcher { terminal, none };

/// A line of progress on a stream that someone may watch.
class Progress {
public:
    Progress(std::ostream& err, Watcher watcher, std::string label,
             SecondsClock clock = steady_seconds_clock());
    /// Wipes the bar away.
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Shows that `share` (0 to 1) of the work is done; redraws at most ten times a second. NaN:
    /// nobody knows how much; the time that has passed is shown instead.
    void show(double share);
    /// The same for work in phases, each with a name and an estimate of its own.
    void show(const std::string& phase, double share);

private:
    std::ostream& err_;
    Watcher watcher_;
    std::string label_;
    std::string phase_;
    SecondsClock clock_;
    double start_;
    double last_shown_;
    size_t width_ = 0; ///< of the line on the screen
};

} // namespace occlude::tools
