#include <occlude/cull/adaptive.h>

#include <occlude/core/rng.h>
#include <occlude/cull/near_to_far.h>

#include <algorithm>
#include <cmath>

namespace occlude {

namespace {

using State = HierarchyCut::State;
using Scope = HierarchyCut::Scope;

// While a frame reveals things, it reads depth again after drawing for so many read-backs, and after so
// many times more where that found little hidden.
constexpr double kFirstReadAfter = 8.0;
constexpr double kNextReadAfter = 4.0;

// In the middle of a frame a read-back costs more than it does at rest: the device stands still
// meanwhile. It should hide so many times its cost.
constexpr double kWellWorth = 8.0;

// Frames in which depth is read once more, from a device at rest, to learn what that costs; only the
// first of them if it costs far more than was thought.
constexpr size_t kCostReads = 3;
constexpr double kFarMore = 4.0;

// A probe that takes more than this part of a frame comes at most once in kRareProbe frames, so that
// it stays out of the 99th percentile.
constexpr double kNoticeable = 0.04;
constexpr uint32_t kRareProbe = 128;

// By tests on the device a probe takes many of them: not more often than this.
constexpr double kFramesPerDeviceProbe = 16.0;

// The depth of a probe: nodes of less than this part of the frame's work are not opened.
constexpr double kProbeGrain = 1.0 / 512.0;

// One in so many entries that could be merged is tried in a frame.
constexpr uint32_t kMergeOneIn = 3;

// The share of a view's history that one frame replaces.
constexpr double kForget = 0.25;

// How the chance of being hidden follows the answers, and how low it can fall.
constexpr double kShareStep = 1.0 / 64.0;
constexpr double kLeastShare = 0.02;

// Texels that the test of a box may look at, for each microsecond that drawing it costs: at some 10
// ns each, a quarter of that. At most so many, and not at all for fewer than the last.
constexpr double kTexelsPerUs = 25.0;
constexpr double kMostTexels = 16384.0;
constexpr double kLeastTexels = 16.0;

// Below this many tests a frame says nothing about what they cost.
constexpr size_t kLeastTests = 64;

FramePlan::Kind kind_of(TestMethod method)
{
    switch (method) {
    case TestMethod::queries:
        return FramePlan::Kind::queries;
    case TestMethod::raster:
        return FramePlan::Kind::raster;
    case TestMethod::pyramid:
        return FramePlan::Kind::pyramid;
    case TestMethod::automatic:
        break;
    }
    return FramePlan::Kind::draw_all;
}

} // namespace

Adaptive::Adaptive(const Hierarchy& hierarchy, AdaptiveOptions options, SecondsClock clock)
    : Culler(hierarchy)
    , options_(options)
    , clock_(options.measure ? std::move(clock) : SecondsClock{})
{
}

void Adaptive::reset_state()
{
    cut_.clear();
    late_.clear();
    keep_table_.clear();
    culling_ = true;
    first_look_ = true;
    frames_since_probe_ = kRareProbe; // none yet: one may come at once
    saved_per_spent_ = 0.0;
    hidden_share_ = 0.5;
}

// --- shared --------------------------------------------------------------------------------------

// Nothing below is tested apart: there is nothing, or drawing it costs less than two tests.
bool Adaptive::is_terminal(NodeId node) const
{
    const Node& n = hierarchy().node(node);
    return n.child_count == 0 || costs_.draw_us(n) < 2.0 * costs_.round(method_).us_per_test;
}

// QueryReasonable for what was not visible: what the test would hide is more than it costs.
bool Adaptive::worth_testing(NodeId node, double probability) const
{
    return probability * costs_.draw_us(hierarchy().node(node)) > costs_.round(method_).us_per_test;
}

// What was not known before the test: how much of that is hidden?
void Adaptive::note_first_answer(bool found_hidden)
{
    hidden_share_ += kShareStep * ((found_hidden ? 1.0 : kLeastShare) - hidden_share_);
}

void Adaptive::keep_hidden(CullFrame& frame, HierarchyCut::Entry entry, Decision decision)
{
    if (decision == Decision::undecided) {
        entry.frames_hidden = 0; // drawn in this frame
    } else {
        entry.frames_hidden = static_cast<uint16_t>(std::min(entry.frames_hidden + 1, 0xffff));
        hidden_units_ += costs_.units(hierarchy().node(entry.node));
    }
    if (decision != Decision::undecided && !probing_) {
        frame.decide(entry.node, decision,
                     entry.scope == Scope::own_items ? DecisionLog::Scope::own_items
                                                     : DecisionLog::Scope::subtree);
    }
    entry.state = State::hidden;
    entry.tested = frame.stamp();
    cut_.keep(entry);
}

void Adaptive::keep_visible(HierarchyCut::Entry entry)
{
    entry.state = State::visible;
    entry.frames_hidden = 0;
    cut_.keep(entry);
}

// In a probe everything is drawn already.
void Adaptive::draw_entry(CullFrame& frame, const Candidate& candidate, Decision decision)
{
    if (probing_) {
        return;
    }
    if (candidate.entry.scope == Scope::own_items) {
        frame.draw_own(candidate.entry.node, candidate.mask, decision);
    } else {
        frame.draw_leaf(candidate.entry.node, candidate.mask, decision);
    }
}

// What an opened node consists of: its own items and its children, the farthest first.
void Adaptive::add_children(CullFrame& frame, const Candidate& candidate,
                            std::vector<Candidate>& out)
{
    const NodeId node = candidate.entry.node;
    push_far_to_near(hierarchy(), frame.view(), node, children_, [&](NodeId child) {
        out.push_back({{child}, candidate.mask, 0.0f});
    });
    if (hierarchy().node(node).own_items > 0) {
        HierarchyCut::Entry own{node};
        own.scope = Scope::own_items;
        out.push_back({own, candidate.mask, 0.0f});
    }
}

// --- the plan ------------------------------------------------------------------------------------

TestMethod Adaptive::choose_method() const
{
    switch (options_.method) {
    case AdaptiveOptions::Method::queries:
        return TestMethod::queries;
    case AdaptiveOptions::Method::raster:
        return TestMethod::raster;
    case AdaptiveOptions::Method::pyramid:
        return TestMethod::pyramid;
    case AdaptiveOptions::Method::draw_all:
    case AdaptiveOptions::Method::automatic:
        break;
    }
    // What the tests of a frame would cost by each: as many as the last frame made, or a few.
    constexpr double kFewTests = 64.0;
    constexpr double kRounds = 1.5; // of tests on the device: some reveal others
    constexpr double kSwitch = 0.7; // a change of method starts from nothing
    const double tests = std::max(tests_last_frame_, kFewTests);
    TestMethod best = method_;
    double best_us = costs_.has(method_) ? kSwitch * costs_.round(method_).of(tests) : 0.0;
    for (const TestMethod method : {TestMethod::pyramid, TestMethod::raster, TestMethod::queries}) {
        if (!costs_.has(method) || (costs_.has(method_) && method == method_)) {
            continue;
        }
        const double rounds = method == TestMethod::pyramid ? 1.0 : kRounds;
        const RoundCost cost = costs_.round(method);
        const double us = rounds * cost.us_per_round + tests * cost.us_per_test;
        if (!costs_.has(best) || us < best_us) {
            best = method;
            best_us = us;
        }
    }
    return best;
}

void Adaptive::start_frame(CullFrame& frame)
{
    costs_.take_hints(frame.caps());
    tests_last_frame_ = tests_;
    const TestMethod method = choose_method();
    if (method != method_) {
        method_ = method;
        cut_.clear(); // its grain was that of the other method
        late_.clear();
        last_probe_us_ = 0.0;
        frames_since_probe_ = kRareProbe;
    }
    if (cut_.empty() && method_ != TestMethod::pyramid) {
        // Tests see nothing before something is drawn: draws all, then tests all of that.
        culling_ = false;
        frames_since_probe_ = first_look_ ? kRareProbe : frames_since_probe_;
    }
    can_test_ = costs_.has(method_) && options_.method != AdaptiveOptions::Method::draw_all;
    tests_ = 0.0;
    spent_us_ = 0.0;
    hidden_units_ = 0.0;
    depth_known_ = false;
    units_at_read_ = 0.0;
    read_after_us_ = kFirstReadAfter * costs_.round(TestMethod::pyramid).us_per_round;
    started_us_ = now();
}

// Frustum culling, as `frustum` does it.
void Adaptive::draw_all(CullFrame& frame)
{
    walk_.draw_all(frame);
    frame.flush_draws();
    const double drawn = costs_.units(frame.counters());
    const double drawn_us = costs_.us_per_unit() * drawn;
    ++frames_since_probe_;
    FramePlan& plan = frame.plan();
    plan.kind = FramePlan::Kind::draw_all;
    plan.reason = !can_test_ ? (options_.method == AdaptiveOptions::Method::draw_all
                                    ? FramePlan::Reason::chosen
                                    : FramePlan::Reason::no_tests)
                             : FramePlan::Reason::saves_too_little;
    plan.drawn_us = static_cast<float>(drawn_us);
    if (can_test_ && probe_due(drawn_us)) {
        probe(frame);
    }
}

bool Adaptive::probe_due(double frame_us) const
{
    const double probe_us = std::max(costs_.round(method_).us_per_round, last_probe_us_);
    const double interval = probe_us / std::max(frame_us * double{options_.probe_share}, 1e-6);
    const bool noticeable = probe_us > kNoticeable * frame_us;
    const double least = method_ == TestMethod::pyramid ? 1.0 : kFramesPerDeviceProbe;
    return frames_since_probe_ >= std::max(interval, noticeable ? double{kRareProbe} : least);
}

// Culling pays if what the tests hid costs more to draw than they did; decided for the next frame,
// with hysteresis.
void Adaptive::judge(CullFrame& frame)
{
    const double saved_us = costs_.us_per_unit() * hidden_units_;
    FramePlan& plan = frame.plan();
    plan.kind = kind_of(method_);
    plan.reason = options_.method != AdaptiveOptions::Method::automatic ? FramePlan::Reason::chosen
                  : first_look_ ? FramePlan::Reason::first_look
                                : FramePlan::Reason::saves;
    plan.drawn_us = static_cast<float>(costs_.us_per_unit() * costs_.units(frame.counters()));
    plan.saved_us = static_cast<float>(saved_us);
    plan.spent_us = static_cast<float>(spent_us_);
    const double ratio = saved_us / std::max(spent_us_, 1e-3);
    saved_per_spent_ =
        first_look_ ? ratio : (1.0 - kForget) * saved_per_spent_ + kForget * std::min(ratio, 16.0);
    first_look_ = false;
    const bool pays = spent_us_ > 0.0 && saved_per_spent_ >= double{options_.keep_margin};
    if (options_.method == AdaptiveOptions::Method::automatic && !pays) {
        stop_culling();
        frames_since_probe_ = depth_known_ || method_ != TestMethod::pyramid ? 0 : kRareProbe;
    }
}

void Adaptive::stop_culling()
{
    culling_ = false;
    cut_.clear();
    late_.clear();
}

// --- one frame of culling ------------------------------------------------------------------------

// Parts the cut into what is outside, what was visible and is drawn at once, and the rest.
void Adaptive::sort_out(CullFrame& frame)
{
    expected_.clear();
    candidates_.clear();
    if (cut_.empty()) {
        cut_.reset(hierarchy());
    }
    for (const HierarchyCut::Entry& entry : cut_.entries()) {
        Candidate candidate{entry};
        if (!frame.visit(entry.node, candidate.mask)) {
            candidate.entry.state = State::outside;
            candidate.entry.frames_hidden = 0;
            cut_.keep(candidate.entry);
            continue;
        }
        if (entry.state == State::visible) {
            const bool late_hidden =
                std::binary_search(found_hidden_.begin(), found_hidden_.end(), entry.node);
            if (!late_hidden) {
                candidate.distance = frame.view().distance_key(hierarchy().node(entry.node).box);
                expected_.push_back(candidate);
                continue;
            }
            candidate.entry.state = State::hidden;
        }
        candidates_.push_back(candidate);
    }
}

void Adaptive::draw_expected(CullFrame& frame)
{
    std::sort(expected_.begin(), expected_.end(),
              [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
    for (const Candidate& candidate : expected_) {
        draw_entry(frame, candidate, Decision::drawn_tested);
    }
    frame.start_draws();
}

// Entries below one node that are all hidden or outside become that node, if it is hidden as well.
// A few at a time: each costs a test, here or in the next frame.
void Adaptive::finish_cut(CullFrame& frame)
{
    const uint64_t turn = hash64(options_.seed, frame.stamp());
    cut_.finish(hierarchy(), [&](NodeId node, bool all_outside, HierarchyCut::Entry& replacement) {
        if (uniform_below(mix64(turn ^ node.value), kMergeOneIn) != 0) {
            return false;
        }
        PlaneMask mask = Frustum::kAllPlanes;
        const bool outside = frame.view().frustum().classify(hierarchy().node(node).box, mask) ==
                             Containment::outside;
        if (all_outside || outside) {
            replacement.state = State::outside;
            return outside;
        }
        replacement.state = State::hidden;
        return method_ != TestMethod::pyramid || hidden(frame, node);
    });
}

// --- against depth that was read back ------------------------------------------------------------

// Errs toward false. Invalid bounds are those of rule R1: visible.
bool Adaptive::hidden(const CullFrame& frame, NodeId node)
{
    if (!depth_known_) {
        return false;
    }
    ++tests_;
    const ScreenBounds bounds = project(frame.view(), hierarchy().node(node).box);
    return bounds.valid &&
           (pyramid_.hides(bounds.rect, bounds.near_depth) || hidden_by_faces(node, bounds));
}

// Compares the rectangles of many boxes at once.
void Adaptive::compare_all(std::span<const ScreenBounds> bounds)
{
    hidden_by_rectangle_.assign(bounds.size(), 0);
    if (depth_known_) {
        pyramid_.hides(bounds, DepthPyramid::Refinement::pixels, hidden_by_rectangle_);
    }
}

// Where its rectangle does not hide a box, the box itself may: as many texels are looked at as cost a
// part of what drawing would.
bool Adaptive::hidden_by_faces(NodeId node, const ScreenBounds& bounds) const
{
    if (!depth_known_ || !bounds.valid) {
        return false;
    }
    const Node& n = hierarchy().node(node);
    const double texels = std::min(kTexelsPerUs * costs_.draw_us(n), kMostTexels);
    return texels >= kLeastTexels &&
           pyramid_.hides(ScreenBox{screen_, n.box}, bounds.rect, static_cast<uint32_t>(texels));
}

// Reads the depth of all that is drawn so far, and learns from the time that took what drawing
// costs; a few times more, at rest, what reading costs.
bool Adaptive::read_depth(CullFrame& frame)
{
    const glm::ivec2 size = frame.view().size_px();
    frame.flush_draws();
    const double units = costs_.units(frame.counters());
    if (size.x <= 0 || size.y <= 0 || units == 0.0) {
        return false;
    }
    const PixelRect all{0, 0, size.x, size.y};
    depth_known_ = frame.read_depth(all, pyramid_.resize(size));
    if (!depth_known_) {
        return false;
    }
    pyramid_.build();
    const double read = now();
    measure_read(frame);
    const double read_us = costs_.round(TestMethod::pyramid).us_per_round;
    spent_us_ += read_us;
    if (clock_) {
        costs_.drew(units - units_at_read_, std::max(read - started_us_ - read_us, 0.0));
    }
    units_at_read_ = units;
    screen_ = ScreenSpace{frame.view(), frame.caps().samples_at_pixel_centers
                                            ? SamplePositions::center
                                            : SamplePositions::anywhere};
    started_us_ = now();
    return true;
}

// The device is at rest: what does reading all of the target cost?
void Adaptive::measure_read(CullFrame& frame)
{
    const size_t measured = costs_.rounds_measured(TestMethod::pyramid);
    const bool dear = measured > 0 && costs_.round(TestMethod::pyramid).us_per_round >
                                          kFarMore * costs_.hint(TestMethod::pyramid).us_per_round;
    if (!clock_ || measured >= kCostReads || dear) {
        return;
    }
    const glm::ivec2 size = frame.view().size_px();
    const double from = now();
    frame.read_depth({0, 0, size.x, size.y}, pyramid_.resize(size));
    pyramid_.build();
    costs_.tested(TestMethod::pyramid, 1, now() - from);
}

// Draws what a candidate is, or puts what it consists of on the stack.
void Adaptive::open(CullFrame& frame, const Candidate& candidate, bool tested)
{
    if (candidate.entry.scope == Scope::own_items || is_terminal(candidate.entry.node)) {
        draw_entry(frame, candidate, tested ? Decision::drawn_revealed : Decision::drawn);
        keep_visible(candidate.entry);
        return;
    }
    add_children(frame, candidate, stack_);
}

// Walks what is not known to be hidden near to far, and reads depth again when so much has been
// drawn that it could hide the rest.
void Adaptive::reveal(CullFrame& frame)
{
    double hidden_at_read = hidden_units_;
    size_t untouched = stack_.size(); // at the bottom: in the frustum, and tested if depth is known
    bool tested_once = depth_known_;
    while (!stack_.empty()) {
        Candidate candidate = stack_.back();
        stack_.pop_back();
        bool tested = tested_once && stack_.size() < untouched;
        if (stack_.size() < untouched) {
            untouched = stack_.size();
        } else if (!frame.visit(candidate.entry.node, candidate.mask)) {
            candidate.entry.state = State::outside;
            cut_.keep(candidate.entry);
            continue;
        }
        const double queued_us =
            costs_.us_per_unit() * costs_.units(frame.queued_triangles(), frame.queued_items());
        if (frame.caps().read_depth && queued_us > read_after_us_ && read_depth(frame)) {
            const double saved_us = costs_.us_per_unit() * (hidden_units_ - hidden_at_read);
            const double read_us = costs_.round(TestMethod::pyramid).us_per_round;
            if (saved_us < kWellWorth * read_us) {
                read_after_us_ *= kNextReadAfter;
            }
            hidden_at_read = hidden_units_;
            tested_once = false;
            tested = false;
        }
        if (!tested && depth_known_ && worth_testing(candidate.entry.node, hidden_share_)) {
            const bool found_hidden = hidden(frame, candidate.entry.node);
            note_first_answer(found_hidden);
            if (found_hidden) {
                keep_hidden(frame, candidate.entry, Decision::hidden);
                continue;
            }
            tested = true;
        }
        open(frame, candidate, tested);
    }
}

// Where the candidates and what is drawn already are on the screen: found while the device draws.
void Adaptive::project_all(CullFrame& frame)
{
    const auto project_into = [&](std::span<const Candidate> from, std::vector<ScreenBounds>& to) {
        boxes_.clear();
        for (const Candidate& candidate : from) {
            boxes_.push_back(hierarchy().node(candidate.entry.node).box);
        }
        to.resize(from.size());
        project_boxes(frame.view(), boxes_, to);
    };
    const double from = now();
    project_into(candidates_, candidate_bounds_);
    project_into(expected_, expected_bounds_);
    testing_us_ = now() - from;
}

void Adaptive::test_candidates(CullFrame& frame)
{
    const double from = now();
    stack_.clear();
    compare_all(candidate_bounds_);
    for (size_t i = 0; i < candidates_.size(); ++i) {
        Candidate& candidate = candidates_[i];
        if (hidden_by_rectangle_[i] != 0 ||
            hidden_by_faces(candidate.entry.node, candidate_bounds_[i])) {
            keep_hidden(frame, candidate.entry, Decision::hidden);
        } else {
            candidate.distance =
                frame.view().distance_key(hierarchy().node(candidate.entry.node).box);
            stack_.push_back(candidate);
        }
    }
    std::sort(stack_.begin(), stack_.end(),
              [](const Candidate& a, const Candidate& b) { return a.distance > b.distance; });
    testing_us_ += now() - from;
}

void Adaptive::retest_by_pyramid(CullFrame& frame)
{
    const double from = now();
    compare_all(expected_bounds_);
    for (size_t i = 0; i < expected_.size(); ++i) {
        HierarchyCut::Entry& entry = expected_[i].entry;
        if (hidden_by_rectangle_[i] != 0 || hidden_by_faces(entry.node, expected_bounds_[i])) {
            keep_hidden(frame, entry, Decision::undecided);
        } else {
            entry.tested = frame.stamp();
            keep_visible(entry);
        }
    }
    testing_us_ += now() - from;
}

void Adaptive::by_pyramid(CullFrame& frame)
{
    project_all(frame);
    if (!candidates_.empty() && read_depth(frame)) {
        measure_methods(frame, candidates_);
    }
    test_candidates(frame);
    reveal(frame);
    frame.flush_draws();
    retest_by_pyramid(frame);
    if (!depth_known_) {
        return;
    }
    const size_t tests = candidates_.size() + expected_.size();
    if (clock_ && tests >= kLeastTests) {
        costs_.tested(method_, tests + 1, costs_.round(method_).us_per_round + testing_us_);
    }
    tests_ += static_cast<double>(tests);
    spent_us_ += tests_ * costs_.round(method_).us_per_test;
}

// Where nothing is tested: what would tests hide? Asks of the finished frame, down to nodes that
// matter.
void Adaptive::probe(CullFrame& frame)
{
    frames_since_probe_ = 0;
    frame.plan().reason = FramePlan::Reason::probe;
    cut_.reset(hierarchy());
    if (method_ == TestMethod::pyramid) {
        probe_by_pyramid(frame);
    } else {
        probing_ = true;
        candidates_.assign(1, Candidate{cut_.entries()[0]});
        by_rounds(frame);
        probing_ = false;
        last_probe_us_ = spent_us_;
    }
    cut_.finish(hierarchy(), [](NodeId, bool, HierarchyCut::Entry&) { return false; });
    const double saved_us = costs_.us_per_unit() * hidden_units_;
    frame.plan().saved_us = static_cast<float>(saved_us);
    frame.plan().spent_us = static_cast<float>(spent_us_);
    culling_ = saved_us > double{options_.start_margin} * spent_us_;
    if (culling_) {
        saved_per_spent_ = saved_us / std::max(spent_us_, 1e-3);
        first_look_ = false;
    } else {
        cut_.clear();
    }
}

void Adaptive::probe_by_pyramid(CullFrame& frame)
{
    if (!read_depth(frame)) {
        return;
    }
    const double tested_from = now();
    const double grain = kProbeGrain * costs_.units(frame.counters());
    stack_.assign(1, Candidate{cut_.entries()[0]});
    while (!stack_.empty()) {
        Candidate candidate = stack_.back();
        stack_.pop_back();
        const Node& node = hierarchy().node(candidate.entry.node);
        if (frame.view().frustum().classify(node.box, candidate.mask) == Containment::outside) {
            candidate.entry.state = State::outside;
            cut_.keep(candidate.entry);
        } else if (hidden(frame, candidate.entry.node)) {
            hidden_units_ += costs_.units(node);
            candidate.entry.state = State::hidden;
            cut_.keep(candidate.entry);
        } else if (candidate.entry.scope == Scope::own_items || is_terminal(candidate.entry.node)) {
            keep_visible(candidate.entry);
        } else if (costs_.units(node) < grain) {
            candidate.entry.state = State::unknown;
            cut_.keep(candidate.entry);
        } else {
            add_children(frame, candidate, stack_);
        }
    }
    spent_us_ += clock_ ? now() - tested_from : tests_ * costs_.round(method_).us_per_test;
}

void Adaptive::cull_frame(CullFrame& frame)
{
    start_frame(frame);
    if (!can_test_ || !culling_) {
        draw_all(frame);
        return;
    }
    take_late_answers(frame);
    sort_out(frame);
    draw_expected(frame);
    if (method_ == TestMethod::pyramid) {
        by_pyramid(frame);
    } else {
        by_device(frame);
    }
    finish_cut(frame);
    judge(frame);
    if (!culling_ && method_ == TestMethod::pyramid && probe_due(double{frame.plan().drawn_us})) {
        probe(
            frame); // too little was drawn to be worth a look meanwhile: is anything hidden at all?
    }
}

} // namespace occlude
