// How far the reading of a file is: from counts of what is done to shares of the whole.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>

namespace occlude::tools {

// The parts of loading and where each ends, by what they take for large files: the bytes are read
// and decoded, meshes are cleaned and cut into items, and their shapes are made.
inline constexpr double kReadShare = 0.5;
inline constexpr double kCleanShare = 0.9;

/// Calls `callback` with shares from `begin` to `end` while `all` units are done, at most a hundred
/// times and never backwards. advance() may be called from several threads; the callback is called
/// by one at a time.
class LoadProgress {
public:
    LoadProgress(const std::function<void(double)>& callback, double begin, double end,
                 uint64_t all)
        : callback_(callback)
        , begin_(begin)
        , end_(end)
        , all_(std::max<uint64_t>(all, 1))
    {
    }

    void advance(uint64_t units)
    {
        const uint64_t done = done_.fetch_add(units) + units;
        const std::unique_lock lock{calling_, std::try_to_lock};
        const double share = static_cast<double>(std::min(done, all_)) / static_cast<double>(all_);
        if (!callback_ || !lock.owns_lock() || share < next_) {
            return;
        }
        next_ = share + kStep;
        callback_(begin_ + (end_ - begin_) * share);
    }

private:
    static constexpr double kStep = 0.01;

    const std::function<void(double)>& callback_;
    double begin_;
    double end_;
    uint64_t all_;
    std::atomic<uint64_t> done_{0};
    std::mutex calling_;
    double next_ = 0.0; ///< the share at which to call again
};

} // namespace occlude::tools
