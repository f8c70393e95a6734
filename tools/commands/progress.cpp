#include "commands/progress.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ostream>

namespace occlude::tools {

static constexpr double kSecondsBetweenBars = 0.1;
static constexpr double kSecondsBetweenLines = 10.0;
static constexpr size_t kBarWidth = 30;

Progress::Progress(std::ostream& err, Watcher watcher, std::string label, SecondsClock clock)
    : err_(err)
    , watcher_(watcher)
    , label_(std::move(label))
    , clock_(std::move(clock))
    , start_(clock_())
    , last_shown_(start_)
{
    show_at_once();
}

Progress::~Progress()
{
    if (width_ > 0) {
        err_ << '\r' << std::string(width_, ' ') << '\r' << std::flush;
    }
}

static std::string duration_text(double seconds)
{
    const auto whole = static_cast<long>(std::max(seconds, 0.0) + 0.5);
    return whole < 60 ? fmt::format("{} s", whole)
                      : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

static std::string bar(double share)
{
    const auto filled = static_cast<size_t>(share * static_cast<double>(kBarWidth));
    return fmt::format(" [{}{}]", std::string(filled, '#'), std::string(kBarWidth - filled, '.'));
}

// " [###......]  25%, about 10 s left", without the bar in a log.
static std::string state_text(Watcher watcher, double share, double seconds)
{
    if (std::isnan(share)) {
        return ", " + duration_text(seconds);
    }
    share = std::clamp(share, 0.0, 1.0);
    std::string text = watcher == Watcher::terminal ? bar(share) : "";
    text += fmt::format(" {:3.0f}%", 100.0 * share);
    if (share > 0.0) {
        text += ", about " + duration_text(seconds * (1.0 - share) / share) + " left";
    }
    return text;
}

void Progress::show(const std::string& phase, double share)
{
    if (const std::string text = ": " + phase; text != phase_) {
        phase_ = text;
        start_ = clock_();
        show_at_once();
    }
    show(share);
}

// A bar appears with the first show(). A log gets a line only of work that takes long.
void Progress::show_at_once()
{
    if (watcher_ == Watcher::terminal) {
        last_shown_ = start_ - 2.0 * kSecondsBetweenBars;
    }
}

void Progress::show(double share)
{
    const double now = clock_();
    const double pause = watcher_ == Watcher::terminal ? kSecondsBetweenBars : kSecondsBetweenLines;
    if (watcher_ == Watcher::none || now - last_shown_ < pause) {
        return;
    }
    last_shown_ = now;
    const std::string line = label_ + phase_ + state_text(watcher_, share, now - start_);
    if (watcher_ == Watcher::log) {
        err_ << line << std::endl;
        return;
    }
    const size_t padding = width_ > line.size() ? width_ - line.size() : 0;
    err_ << '\r' << line << std::string(padding, ' ') << std::flush;
    width_ = std::max(width_, line.size());
}

} // namespace occlude::tools
