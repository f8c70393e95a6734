// One algorithm at work: its culler with its options, and what it did in the last frames.
#pragma once

#include "measure/stage.h"
#include "measure/timing_device.h"
#include "viewer/frame_trace.h"

#include <occlude/core/frame_report.h>
#include <occlude/core/option_text.h>
#include <occlude/core/result.h>
#include <occlude/cull/culler.h>

#include <array>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace occlude::tools::viewer {

/// What the decisions of a frame were, kept for a while.
struct FrameMemory {
    uint64_t frame = 0; ///< of the viewer
    std::vector<DecisionLog::Entry> decisions;
    FrameTrace trace;
};

/// The last values of one figure, oldest first, for a rolling plot.
class Rolling {
public:
    static constexpr size_t kCapacity = 240;

    void add(float value);
    void clear() { values_.clear(); }
    std::span<const float> values() const { return values_; }
    float last() const { return values_.empty() ? 0.0f : values_.back(); }
    float largest() const;
    /// Of the last 60 values.
    float median() const;

private:
    std::vector<float> values_;
};

struct PaneFigures {
    Rolling frame_ms;
    Rolling cull_cpu_ms;
    Rolling queries;
    Rolling batches;
    Rolling waits;
    Rolling triangles;
    void clear() { *this = {}; }
};

/// Options of algorithms that differ from the defaults, by algorithm.
using OptionSets = std::map<std::string, std::map<std::string, std::string>>;

class Pane {
public:
    static constexpr size_t kRememberedFrames = 60;

    Pane(std::string algorithm, SecondsClock clock);

    const std::string& algorithm() const { return algorithm_; }
    /// Makes another culler for the next frame.
    void choose_algorithm(const std::string& algorithm);
    /// Sets an option of the pane's algorithm to a value; the default's text takes it back.
    void set_option(const std::string& name, const std::string& value);
    /// The value of an option as it will be used.
    std::string option(const OptionInfo& info) const;
    const OptionSets& option_sets() const { return options_; }
    void set_option_sets(OptionSets sets);

    /// The stage is another one, or its tree: the culler is made again.
    void forget_tree();
    /// The algorithm forgets what it saw; figures stay.
    void cut();

    /// Culls and draws one frame on the stage's renderer and waits for it. `device` is the one to
    /// talk to: that of the renderer, or a decorator of it. False if the algorithm cannot be made;
    /// problem() says why.
    bool cull(const Stage& stage, const View& view, QueryDevice& device, uint64_t frame);

    /// Null before the first frame.
    const Culler* culler() const { return culler_.get(); }
    const std::string& problem() const { return problem_; }
    const FrameReport& report() const { return report_; }
    const PaneFigures& figures() const { return figures_; }
    /// The last frames, the newest last. Never more than kRememberedFrames.
    const std::deque<FrameMemory>& memory() const { return memory_; }
    /// The trace of the last frame; empty before it.
    const FrameTrace& trace() const;
    double frame_ms() const { return figures_.frame_ms.last(); }

private:
    bool make_culler(const Hierarchy& tree);

    std::string algorithm_;
    OptionSets options_;
    SecondsClock clock_;
    std::unique_ptr<Culler> culler_;
    std::string problem_;
    FrameReport report_;
    PaneFigures figures_;
    std::deque<FrameMemory> memory_;
    TraceDevice tracer_;
};

} // namespace occlude::tools::viewer
