// How often the answer is "hidden": a running share of yes and no.
#pragma once

namespace occlude {

/// The running share of tests that found something hidden. Starts at one half and never falls below
/// `kMinShare`: if it reached 0, nothing would be tested and the share could never rise again.
class ShareEstimate {
public:
    double value() const { return share_; }
    void note(bool hidden) { share_ += kStep * ((hidden ? 1.0 : kMinShare) - share_); }

private:
    static constexpr double kStep = 1.0 / 64.0; ///< weight of one answer
    static constexpr double kMinShare = 0.02;

    double share_ = 0.5;
};

} // namespace occlude
