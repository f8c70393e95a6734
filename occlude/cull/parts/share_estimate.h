// How often the answer is "hidden": a running share of yes and no.
#pragma once

namespace occlude {

/// Follows the share of tests that found something hidden. Starts at one half, never falls below
/// `kMinShare`: something that is never tried again could never be found to pay again.
class ShareEstimate {
public:
    double value() const { return share_; }
    void note(bool hidden) { share_ += kStep * ((hidden ? 1.0 : kMinShare) - share_); }

private:
    static constexpr double kStep =
        1.0 / 64.0; ///< the part of the estimate that one answer replaces
    static constexpr double kMinShare = 0.02;

    double share_ = 0.5;
};

} // namespace occlude
