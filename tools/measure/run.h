// The results of walking one algorithm along one path: figures per frame and their summary. Filled
// by measure.h (times) and verify.h (differences); read by everything in report/.
#pragma once

#include "measure/statistics.h"

#include <occlude/core/frame_report.h>
#include <occlude/core/ids.h>
#include <occlude/cull/parts/decision_log.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace occlude::tools {

/// The value of a figure that was not measured; JSON writes null, tables a dash.
inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// An item that owns pixels of the reference and was not drawn, and the node that hid it.
struct MissingItem {
    ItemId item;
    uint64_t pixels = 0; ///< differing pixels that the item owns in the reference
    NodeId node;         ///< the lowest node above the item with a decision; invalid: there is none
    Decision decision = Decision::undecided; ///< the decision about that node
};

/// Two items with surfaces at exactly the same depth in some pixels, where the one that is drawn
/// first shows.
struct CoincidentItems {
    ItemId first;        ///< the visible one if items are drawn in ascending order
    ItemId last;         ///< the visible one if they are drawn in descending order
    uint64_t pixels = 0; ///< number of tied pixels that show one of them
};

/// How the image of one culled frame compares with the reference: colour and depth, bit by bit.
struct Verdict {
    uint64_t differing_pixels = 0;
    /// Pixels that differ only because surfaces of equal depth were drawn in another order. The
    /// same items in the order of the reference give the reference, so nothing was culled wrongly.
    uint64_t tied_pixels = 0;
    glm::ivec2 first_pixel{-1};            ///< the first differing one; row 0 is the bottom row
    std::vector<MissingItem> missing = {}; ///< most pixels first
    std::vector<CoincidentItems> coincident = {}; ///< in tied pixels; most pixels first
};

struct FrameFigures {
    size_t frame = 0; ///< index of the frame in the path
    double frame_ms = kNotMeasured;
    double wait_ms = kNotMeasured;     ///< in wait()
    double read_ms = kNotMeasured;     ///< in read_depth()
    double cull_cpu_ms = kNotMeasured; ///< in the culler itself: cull() minus all device verbs
    double speedup_vs_frustum = kNotMeasured;
    double ratio_to_opt = kNotMeasured;
    double ratio_to_ideal = kNotMeasured;
    /// The number of drawn items that own no pixel, per item that owns one.
    double overdraw_items_vs_exact = kNotMeasured;
    FrameCounters counters;
    uint64_t decision_hash = 0;
    FramePlan plan;                 ///< of algorithms that choose a method in each frame
    std::optional<Verdict> verdict; ///< empty: not compared
    uint64_t items_in_frustum = 0;  ///< number of items that frustum culling would draw
    bool shows_nothing = false;     ///< no item owns a pixel of the image
};

struct AlgorithmRun {
    std::string algorithm;
    Guarantee guarantee;              ///< the weakest guarantee of all frames
    std::vector<FrameFigures> frames; ///< the measured frames, in order
    std::string hierarchy = {};       ///< the hierarchy, as in --hierarchy; empty: unknown
    /// It has polled for answers, so its decisions may depend on when they arrive.
    bool polled = false;
    bool asked_time = false; ///< it has read a clock, so its decisions may depend on time
};

/// True if the runs are on more than one hierarchy, so that reports must tell them apart.
bool on_several_hierarchies(std::span<const AlgorithmRun> runs);
/// "chc on bsp" if `with_hierarchy` and there is one, else "chc".
std::string run_label(const AlgorithmRun& run, bool with_hierarchy);

/// The weaker of two guarantees.
Guarantee weaker(const Guarantee& a, const Guarantee& b);

/// How much evidence the frames are. Frames that show nothing, and frames in which everything was
/// drawn, prove nothing about culling.
struct Evidence {
    size_t frames = 0;
    size_t empty_frames = 0;  ///< number of frames that show nothing
    size_t hiding_frames = 0; ///< number of frames in which some run drew less than the items in
                              ///< the frustum
};
Evidence evidence_of(std::span<const AlgorithmRun> runs);

struct Summary {
    Distribution frame_ms;
    double speedup_vs_frustum = kNotMeasured; ///< medians of the ratios computed per frame
    double ratio_to_opt = kNotMeasured;
    double ratio_to_ideal = kNotMeasured;
    double overdraw_items_vs_exact = kNotMeasured; ///< means from here on
    double wait_ms = kNotMeasured;
    double read_ms = kNotMeasured;
    double cull_cpu_ms = kNotMeasured;
    double slowest_vs_frustum = kNotMeasured; ///< the smallest speedup_vs_frustum
    FrameCounters total;                      ///< over all frames
    size_t frame_count = 0;
    uint64_t decision_hash = 0; ///< of all frames in order
    size_t compared_frames = 0;
    bool verified = false; ///< some frame was compared; the counts below are about these frames
    uint64_t differing_pixels = 0;
    uint64_t differing_frames = 0;
    uint64_t tied_pixels = 0;

    /// `count` frames out of `total`.
    double per_frame(uint64_t count) const;
};
Summary summarise(const AlgorithmRun& run);

} // namespace occlude::tools
