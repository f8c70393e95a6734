#include <occlude/cull/adaptive.h>

#include <algorithm>
#include <cmath>

namespace occlude {

namespace {

// While a frame reveals things, it reads depth again after drawing for so many read-backs, and
// after so many times more where that found little hidden.
constexpr double kFirstReadAfter = 4.0;
constexpr double kNextReadAfter = 2.0;

// In the middle of a frame a read-back costs more than it does at rest: the device stands still
// meanwhile. It should hide so many times its cost.
constexpr double kWellWorth = 4.0;

// What reading depth costs is known from two frames if it is so many times what was thought.
constexpr double kFarMore = 4.0;
constexpr size_t kNotByChance = 2;

// A probe that takes more than this part of a frame comes at most once in kRareProbe frames, so
// that it stays out of the 99th percentile; in kSoonProbe frames if what is in the frustum has
// become so many times more or less since the last one.
constexpr double kNoticeable = 0.05;
constexpr uint32_t kRareProbe = 128;
constexpr uint32_t kSoonProbe = 16;
constexpr double kOtherView = 1.25;

// Each probe that finds less than half of what it costs makes the next one wait so many times as
// long, and at most so many times, while what is in the frustum stays about the same.
constexpr double kLonger = 2.0;
constexpr double kLongest = 4.0;

// By tests on the device a probe takes many of them: not more often than this.
constexpr double kFramesPerDeviceProbe = 16.0;

// By tests on the device, so many of the first frames are probed at most: each kind of round is
// measured three times.
constexpr uint32_t kFirstProbes = 12;

// The depth of a probe: nodes of less than this part of the frame's work are not opened.
constexpr double kProbeGrain = 1.0 / 512.0;

// The share of a view's history that one frame replaces.
constexpr double kForget = 0.25;

// How the chance of being hidden follows the answers, and how low it can fall.
constexpr double kShareStep = 1.0 / 64.0;
constexpr double kLeastShare = 0.02;

// A test of a shape that took so many times what they take was disturbed.
constexpr double kDisturbed = 16.0;

// How many frames ahead a test may pay.
constexpr double kForesight = 16.0;

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
    : CutCuller(hierarchy, DepthTests{}, options.shapes)
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
    first_probes_ = 0;
    probe_patience_ = 1.0;
    frames_since_probe_ = kRareProbe; // none yet: one may come at once
    saved_per_spent_ = 0.0;
    hidden_share_ = 0.5;
    shape_share_ = 0.5;
    tests_per_kept_ = 0.2;
}

// --- shared --------------------------------------------------------------------------------------

// What a test of something of which nothing is known will save, in this frame and, by queries, as
// long as it probably stays hidden.
double Adaptive::hoped_us(const Entry& entry) const
{
    const double draw = draw_us(entry);
    const double stays = method_ == TestMethod::queries ? keep_table_.keep_probability(1) : 0.0;
    const double later_frames = std::min(stays / (1.0 - stays), kForesight);
    return hidden_share_ * (draw + later_frames * std::max(draw - kept_us(), 0.0));
}

// What is drawn for less than two tests cost, once its parts stay hidden, is not tested in parts.
bool Adaptive::opens(NodeId node) const
{
    return has_parts(node) && costs_.draw_us(hierarchy().node(node)) >= 2.0 * kept_us();
}

// As many as cost a part of what drawing would.
uint32_t Adaptive::most_texels(const Entry& entry) const
{
    const double texels = std::min(kTexelsPerUs * draw_us(entry), kMostTexels);
    return texels < kLeastTexels ? 0 : static_cast<uint32_t>(texels);
}

bool Adaptive::still_visible(const Entry& entry) const
{
    return !std::binary_search(found_hidden_.begin(), found_hidden_.end(), name_of(entry));
}

// What was not known before the test: how much of that is hidden?
void Adaptive::answered(bool hidden)
{
    hidden_share_ += kShareStep * ((hidden ? 1.0 : kLeastShare) - hidden_share_);
}

// Shapes are tested one by one and are few, so that each can be timed. Without a clock the test of
// one counts as what it took when this was written.
void Adaptive::shape_answered(bool hidden, double us)
{
    shape_share_ += kShareStep * ((hidden ? 1.0 : kLeastShare) - shape_share_);
    if (clock_) {
        shape_us_ += kShareStep * (std::min(us, kDisturbed * shape_us_) - shape_us_);
    }
    shapes_us_ += clock_ ? us : shape_us_;
}

bool Adaptive::merges(CullFrame& frame, NodeId node)
{
    return method_ != TestMethod::pyramid || CutCuller::merges(frame, node);
}

// --- the plan ------------------------------------------------------------------------------------

// What the tests of a frame would cost by a method: as many as the last frame made, or a few.
double Adaptive::expected_us(TestMethod method) const
{
    constexpr double kFewTests = 64.0;
    constexpr double kRounds = 1.5; // of tests on the device: some reveal others
    const RoundCost cost = costs_.round(method);
    return (method == TestMethod::pyramid ? 1.0 : kRounds) * cost.us_per_round +
           std::max(tests_last_frame_, kFewTests) * cost.us_per_test;
}

// Will measure_methods tell what it costs, or has it begun to?
bool Adaptive::unknown(TestMethod method) const
{
    const bool measures = clock_ && method_ == TestMethod::pyramid && !reads_are_dear();
    return costs_.half_known(method) || (measures && costs_.least_known(method).tests > 0);
}

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
    if (guessing()) {
        return method_;
    }
    constexpr double kSwitch = 0.7; // another method must be cheaper by this, or they take turns
    TestMethod best = method_;
    double best_us = costs_.has(method_) ? kSwitch * expected_us(method_) : 0.0;
    for (const TestMethod method : {TestMethod::pyramid, TestMethod::raster, TestMethod::queries}) {
        if (!costs_.has(method) ||
            (costs_.has(method_) && (method == method_ || unknown(method)))) {
            continue;
        }
        const double us = expected_us(method);
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
    shapes_us_ = 0.0;
    hidden_units_ = 0.0;
    wasted_units_ = 0.0;
    measured_ = false;
    depth_.start_frame(frame.samples());
    units_at_read_ = 0.0;
    hidden_at_read_ = 0.0;
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
    if (can_test_ && probe_due(drawn)) {
        probe(frame);
    }
}

bool Adaptive::probe_due(double drawn_units) const
{
    const double frame_us = costs_.whole_us(drawn_units);
    const double probe_us = std::max(costs_.round(method_).us_per_round, last_probe_us_);
    const bool other_view =
        std::max(drawn_units, units_at_look_) >= kOtherView * std::min(drawn_units, units_at_look_);
    const double interval = (other_view ? 1.0 : probe_patience_) * probe_us /
                            std::max(frame_us * double{options_.probe_share}, 1e-6);
    const double at_least = probe_us > kNoticeable * frame_us
                                ? (other_view ? kSoonProbe : kRareProbe)
                            : method_ == TestMethod::pyramid ? 1.0
                                                             : kFramesPerDeviceProbe;
    return frames_since_probe_ >= std::max(interval, at_least);
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
    // What a first look drew in vain the next frame need not.
    const double may_save_us =
        saved_us + (first_look_ ? costs_.us_per_unit() * wasted_units_ : 0.0);
    const double ratio = may_save_us / std::max(spent_us_, 1e-3);
    saved_per_spent_ =
        first_look_ ? ratio : (1.0 - kForget) * saved_per_spent_ + kForget * std::min(ratio, 16.0);
    first_look_ = false;
    const bool pays =
        spent_us_ > 0.0 && (saved_per_spent_ >= double{options_.keep_margin} || guessing());
    if (options_.method == AdaptiveOptions::Method::automatic && !pays) {
        stop_culling();
        frames_since_probe_ = depth_.known() || method_ != TestMethod::pyramid ? 0 : kRareProbe;
        units_at_look_ = costs_.units(frame.counters()) + hidden_units_;
    }
}

void Adaptive::stop_culling()
{
    culling_ = false;
    cut_.clear();
    late_.clear();
}

// --- against depth that was read back ------------------------------------------------------------

// Reads the depth of all that is drawn so far, and learns from the time that took what drawing
// costs; a few times, what reading costs.
bool Adaptive::read_depth(CullFrame& frame)
{
    frame.flush_draws();
    const bool measures = measures_read(frame);
    const double at_rest = measures ? come_to_rest(frame) : 0.0;
    if (!(measures ? measure_read(frame) : read(frame))) {
        return false;
    }
    const double units = costs_.units(frame.counters());
    const double read_us = costs_.round(TestMethod::pyramid).us_per_round;
    spent_us_ += read_us;
    if (clock_) {
        const double drawn = measures ? at_rest : now() - read_us;
        costs_.drew(units - units_at_read_, std::max(drawn - started_us_, 0.0));
    }
    units_at_read_ = units;
    hidden_at_read_ = hidden_units_;
    started_us_ = now();
    return true;
}

bool Adaptive::reads_are_dear() const
{
    return costs_.rounds_measured(TestMethod::pyramid) >= kNotByChance &&
           costs_.round(TestMethod::pyramid).us_per_round >
               kFarMore * costs_.hint(TestMethod::pyramid).us_per_round;
}

// Is what reading takes known from one frame or two, which may have been disturbed? Then nothing is
// decided by it, unless it would have to be wrong by far.
bool Adaptive::guessing() const
{
    return method_ == TestMethod::pyramid && costs_.half_known(method_) && !reads_are_dear();
}

// Is it worth a look at how long reading takes?
bool Adaptive::measures_read(const CullFrame& frame) const
{
    return clock_ && !measured_ && !reads_are_dear() && frame.counters().items_drawn > 0 &&
           costs_.least_known(TestMethod::pyramid).tests > 0;
}

// The device is at rest, and depth is wherever drawing left it: what does reading all of the target
// cost? A second time it would come from a cache.
bool Adaptive::measure_read(CullFrame& frame)
{
    measured_ = true;
    depth_.make_room(frame.view());
    const double from = now();
    const bool known = read(frame);
    costs_.tested(TestMethod::pyramid, 1, 1, now() - from);
    return known;
}

// One pixel comes when all is drawn. Gives the time when it was; a second pixel tells what the
// first took besides.
double Adaptive::come_to_rest(CullFrame& frame)
{
    float pixel = 0.0f;
    frame.read_depth({0, 0, 1, 1}, {&pixel, 1});
    const double first = now();
    frame.read_depth({0, 0, 1, 1}, {&pixel, 1});
    return first - (now() - first);
}

// While things are revealed: when so much waits to be drawn that it could hide the rest.
bool Adaptive::read_again(CullFrame& frame)
{
    const double queued_us =
        costs_.us_per_unit() * costs_.units(frame.queued_triangles(), frame.queued_items());
    const double hidden_before = hidden_at_read_;
    if (!frame.caps().read_depth || queued_us <= read_after_us_ || !read_depth(frame)) {
        return false;
    }
    const double saved_us = costs_.us_per_unit() * (hidden_units_ - hidden_before);
    if (saved_us < kWellWorth * costs_.round(TestMethod::pyramid).us_per_round) {
        read_after_us_ *= kNextReadAfter;
    }
    return true;
}

void Adaptive::by_pyramid(CullFrame& frame)
{
    // Shapes have a cost of their own.
    const auto box_clock = [&] { return now() - shapes_us_; };
    double testing_us = -box_clock();
    project_all(frame);
    testing_us += box_clock();
    if (!candidates_.empty() && read_depth(frame)) {
        measure_methods(frame, candidates_);
    }
    testing_us -= box_clock();
    test_candidates(frame);
    testing_us += box_clock();
    hidden_at_read_ = hidden_units_;
    reveal(frame);
    frame.flush_draws();
    if (first_look_) {
        read_depth(frame); // much was drawn before it could be known better
    }
    testing_us -= box_clock();
    retest(frame);
    testing_us += box_clock();
    if (!depth_.known()) {
        return;
    }
    const size_t tests = candidates_.size() + drawn_before_read_;
    if (clock_ && tests >= kLeastTests) {
        costs_.tested(method_, tests + 1, tests + 1,
                      costs_.round(method_).us_per_round + testing_us);
    }
    tests_ += static_cast<double>(tests);
    spent_us_ += tests_ * costs_.round(method_).us_per_test + shapes_us_;
}

// --- probes --------------------------------------------------------------------------------------

// Where nothing is tested: what would tests hide? Asks of the finished frame, down to nodes that
// matter.
void Adaptive::probe(CullFrame& frame)
{
    frames_since_probe_ = 0;
    units_at_look_ = costs_.units(frame.counters());
    frame.plan().reason = FramePlan::Reason::probe;
    cut_.reset(hierarchy());
    if (method_ == TestMethod::pyramid) {
        probe_by_pyramid(frame);
    } else {
        all_drawn_ = true;
        candidates_.assign(1, Candidate{cut_.entries()[0]});
        by_rounds(frame);
        all_drawn_ = false;
    }
    last_probe_us_ = spent_us_;
    cut_.finish(
        hierarchy(), [](NodeId, State) { return false; },
        [](NodeId, bool, Entry&) { return false; });
    const double saved_us = costs_.us_per_unit() * hidden_units_;
    frame.plan().saved_us = static_cast<float>(saved_us);
    frame.plan().spent_us = static_cast<float>(spent_us_);
    culling_ = saved_us > double{options_.start_margin} * spent_us_;
    const bool in_vain = saved_us < 0.5 * spent_us_;
    probe_patience_ = in_vain ? std::min(kLonger * probe_patience_, kLongest) : 1.0;
    if (culling_) {
        saved_per_spent_ = saved_us / std::max(spent_us_, 1e-3);
    } else {
        cut_.clear();
    }
    // The first probes come one after the other, because they teach what tests cost.
    ++first_probes_;
    first_look_ = first_look_ && !culling_ && first_probes_ < kFirstProbes &&
                  costs_.least_known(method_).tests > 0;
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
        Entry& entry = candidate.entry;
        ++tests_;
        if (frame.view().frustum().classify(box_of(entry), candidate.mask) ==
            Containment::outside) {
            keep_outside(entry);
        } else if (hidden(frame, entry)) {
            spared(entry);
            entry.state = State::hidden;
            cut_.keep(entry);
        } else if (!opens(entry)) {
            keep_visible(entry);
        } else if (units(entry) < grain) {
            entry.state = State::unknown;
            cut_.keep(entry);
        } else {
            add_parts(frame, candidate, stack_);
        }
    }
    spent_us_ +=
        clock_ ? now() - tested_from : tests_ * costs_.round(method_).us_per_test + shapes_us_;
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
    frame.start_draws();
    if (method_ == TestMethod::pyramid) {
        by_pyramid(frame);
    } else {
        by_device(frame);
    }
    finish_cut(frame, options_.seed);
    judge(frame);
    if (!culling_ && method_ == TestMethod::pyramid && probe_due(costs_.units(frame.counters()))) {
        // Too little was drawn to be worth a look meanwhile: is anything hidden at all?
        probe(frame);
    }
}

} // namespace occlude
