#include <occlude/cull/adaptive.h>

#include <utility>

namespace occlude {

Adaptive::Adaptive(HierarchyRef hierarchy, AdaptiveOptions options, SecondsClock clock)
    : Culler(hierarchy)
    , options_(options)
    , shared_(hierarchy, options, options.measure ? std::move(clock) : SecondsClock{})
    , trials_(shared_, options.method == AdaptiveOptions::Method::automatic)
    , by_depth_(shared_, trials_)
    , by_device_(shared_, trials_)
{
}

void Adaptive::reset_state()
{
    drop_late_tests();
    shared_.meter.trust_clock();
    shared_.planner.reset();
    shared_.cut.forget();
    shared_.depth.forget();
    drawn_units_ = 0.0;
    by_device_.forget();
}

// Their answers are not needed any more, but their tickets must be spent.
void Adaptive::drop_late_tests()
{
    by_device_.drop_late_tests(dropped_);
    for (const Ticket ticket : dropped_) {
        abandon(ticket);
    }
    dropped_.clear();
}

AdaptivePlanner::Outcome Adaptive::outcome(const CullFrame& frame) const
{
    return {.drawn_units = shared_.drawn_units(frame),
            .hidden_units = shared_.cut.hidden_units(),
            .wasted_units = shared_.cut.wasted_units(),
            .spent_us = shared_.meter.spent_us(),
            .tested = shared_.depth.known() || shared_.planner.method() != TestMethod::pyramid};
}

void Adaptive::start_frame(CullFrame& frame)
{
    const AdaptivePlanner::Start start{.cut_is_empty = shared_.cut.cut().empty(),
                                       .measures = shared_.meter.has_clock(),
                                       .tests_last_frame = shared_.meter.tests()};
    shared_.meter.start_frame(frame.caps(), frame.view().size_px(), drawn_units_);
    shared_.depth.set_tile_px(shared_.costs().tile_px());
    if (shared_.planner.start_frame(shared_.costs(), start)) {
        drop_late_tests();
    }
    shared_.cut.start_frame();
    shared_.depth.start_frame(frame);
    shared_.depth.set_clock(shared_.meter.clock());
    shared_.update_prices();
    by_depth_.start_frame();
    frame_since_us_ = shared_.meter.now_us();
}

// Frustum culling, exactly as `frustum` does it.
void Adaptive::draw_all(CullFrame& frame)
{
    walk_.draw_all(frame);
    frame.flush_draws();
    const double drawn_units = shared_.drawn_units(frame);
    frame.plan() = shared_.planner.drew_all(shared_.costs(), drawn_units);
    if (shared_.planner.probe_due(shared_.costs(), drawn_units)) {
        probe(frame);
    }
}

// Tests the finished frame to learn what tests would have hidden.
void Adaptive::probe(CullFrame& frame)
{
    shared_.cut.restart();
    shared_.cut.assume_all_drawn();
    if (shared_.planner.method() == TestMethod::pyramid) {
        by_depth_.probe(frame, kPlannerConstants.probe_grain * shared_.drawn_units(frame));
    } else {
        by_device_.probe(frame, frame_since_us_);
    }
    shared_.cut.finish_without_merging();
    shared_.planner.judge_probe(shared_.costs(), outcome(frame), frame.plan());
    if (!shared_.planner.culls()) {
        shared_.cut.clear();
    }
}

// Siblings below which nothing is visible are merged into their parent. Tests on the device merge
// whenever all of them were found hidden, tests by depth only if the parent's own box is hidden.
void Adaptive::finish_cut(CullFrame& frame)
{
    const size_t tests_before = shared_.depth.single_tests();
    const bool by_depth = shared_.planner.method() == TestMethod::pyramid;
    shared_.cut.finish(frame, options_.seed, [&](NodeId node) {
        return !by_depth || shared_.depth.node_hidden(frame, node);
    });
    const size_t tests = shared_.depth.single_tests() - tests_before;
    shared_.meter.spend(0.0, static_cast<double>(tests));
}

void Adaptive::cull_view(CullFrame& frame)
{
    by_device_.take_late_answers(frame);
    shared_.cut.sort_out(frame, by_device_.turned_hidden());
    shared_.cut.draw_visible(frame);
    frame.start_draws();
    if (shared_.planner.method() == TestMethod::pyramid) {
        by_depth_.test(frame);
    } else {
        by_device_.test(frame, frame_since_us_);
    }
    finish_cut(frame);
    frame.plan() = shared_.planner.judge(shared_.costs(), outcome(frame));
    if (shared_.planner.culls()) {
        return;
    }
    drop_late_tests();
    shared_.cut.clear();
    // A probe may be due even here: where little was drawn, it costs next to nothing.
    if (shared_.planner.method() == TestMethod::pyramid &&
        shared_.planner.probe_due(shared_.costs(), shared_.drawn_units(frame))) {
        probe(frame);
    }
}

void Adaptive::cull_frame(CullFrame& frame)
{
    start_frame(frame);
    if (shared_.planner.culls()) {
        cull_view(frame);
    } else {
        draw_all(frame);
    }
    drawn_units_ = shared_.drawn_units(frame);
    if (shared_.meter.clock_is_useless()) {
        frame.plan().reason = FramePlan::Reason::useless_clock;
    }
}

} // namespace occlude
