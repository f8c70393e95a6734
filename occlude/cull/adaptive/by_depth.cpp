#include <occlude/cull/adaptive/by_depth.h>

#include <algorithm>

namespace occlude {

void TestingByDepth::start_frame()
{
    units_at_read_ = 0.0;
    hidden_at_read_ = 0.0;
    drawing_since_us_ = shared_.meter.now_us();
}

// --- reading -------------------------------------------------------------------------------------

// Reads one pixel, which waits until everything is drawn, and returns the time at which that
// happened. A second read takes only the time of reading, which is subtracted. Precondition: the
// target has a pixel.
double TestingByDepth::idle_since_us(CullFrame& frame) const
{
    float pixel = 0.0f;
    frame.read_depth({0, 0, 1, 1}, {&pixel, 1});
    const double first = shared_.meter.now_us();
    frame.read_depth({0, 0, 1, 1}, {&pixel, 1});
    return first - (shared_.meter.now_us() - first);
}

// Reads depth and records how long drawing took: the time of the read beyond its known cost. While
// that cost is unknown, it waits for the device first, so that the read can be timed alone.
bool TestingByDepth::time_drawing_and_read(CullFrame& frame)
{
    if (trials_.read_is_due(frame)) {
        const double idle_since = idle_since_us(frame);
        if (!trials_.read_and_measure(frame)) {
            return false;
        }
        shared_.meter.note_drawing(shared_.drawn_units(frame) - units_at_read_,
                                   idle_since - drawing_since_us_);
        return true;
    }
    if (!shared_.depth.read(frame)) {
        return false;
    }
    const double now = shared_.meter.now_us();
    shared_.meter.check_clock(drawing_since_us_, now);
    const double read_us = shared_.costs().round(TestMethod::pyramid).us_per_round;
    shared_.meter.note_drawing(shared_.drawn_units(frame) - units_at_read_,
                               now - read_us - drawing_since_us_);
    return true;
}

bool TestingByDepth::read(CullFrame& frame)
{
    frame.flush_draws();
    if (!time_drawing_and_read(frame)) {
        return false;
    }
    shared_.meter.spend(shared_.costs().round(TestMethod::pyramid).us_per_round, 0.0);
    units_at_read_ = shared_.drawn_units(frame);
    hidden_at_read_ = shared_.cut.hidden_units();
    drawing_since_us_ = shared_.meter.now_us();
    shared_.update_prices();
    return true;
}

// --- a frame -------------------------------------------------------------------------------------

// Reads depth again whenever the queued drawing costs several read-backs.
void TestingByDepth::reveal(CullFrame& frame)
{
    const PlannerConstants& k = kPlannerConstants;
    const auto read_us = [&] { return shared_.costs().round(TestMethod::pyramid).us_per_round; };
    double reread_at_us = k.first_reread_cost * read_us();
    while (shared_.depth.reveal(frame, reread_at_us)) {
        const double hidden_before = hidden_at_read_;
        if (!read(frame)) {
            continue;
        }
        const double saved_us =
            shared_.costs().us_per_unit() * (shared_.cut.hidden_units() - hidden_before);
        if (saved_us < k.worthwhile_read_ratio * read_us()) {
            reread_at_us *= k.reread_growth;
        }
    }
}

void TestingByDepth::test(CullFrame& frame)
{
    DepthTraversal& depth = shared_.depth;
    const CostMeter& meter = shared_.meter;
    // Tests of shapes are timed by `depth` itself.
    const auto box_clock = [&] { return meter.now_us() - depth.shapes_us(); };
    double testing_us = -box_clock();
    depth.project_all(frame);
    testing_us += box_clock();
    if (!shared_.cut.candidates().empty() && read(frame)) {
        trials_.try_one(frame, shared_.cut.candidates(), frame.free_tickets(0));
        shared_.update_prices();
    }
    testing_us -= box_clock();
    depth.test_candidates(frame);
    testing_us += box_clock();
    hidden_at_read_ = shared_.cut.hidden_units();
    reveal(frame);
    frame.flush_draws();
    if (shared_.planner.is_first_look()) {
        read(frame); // the first draws had no depth to be tested against
    }
    testing_us -= box_clock();
    depth.retest(frame);
    testing_us += box_clock();
    if (depth.known()) {
        account(testing_us);
    }
}

void TestingByDepth::account(double testing_us)
{
    // Rounds with fewer tests do not show what one test costs.
    constexpr size_t kMinTests = 64;

    const size_t tests = shared_.cut.candidates().size() + shared_.depth.drawn_before_read();
    const RoundCost cost = shared_.costs().round(TestMethod::pyramid);
    if (tests >= kMinTests) {
        shared_.meter.note_round(TestMethod::pyramid, tests + 1, tests + 1,
                                 cost.us_per_round + testing_us);
    }
    const double all_tests = static_cast<double>(tests + shared_.depth.single_tests());
    shared_.meter.spend(all_tests * shared_.costs().round(TestMethod::pyramid).us_per_test +
                            shared_.depth.shapes_us(),
                        all_tests);
}

// --- probes --------------------------------------------------------------------------------------

void TestingByDepth::probe(CullFrame& frame, double min_units)
{
    if (!read(frame)) {
        return;
    }
    CutTraversal& cut = shared_.cut;
    const double shapes_before_us = shared_.depth.shapes_us();
    const double from = shared_.meter.now_us();
    double tests = 0.0;
    to_probe_.assign(1, CutCandidate{cut.cut().entries().front()});
    while (!to_probe_.empty()) {
        CutCandidate candidate = to_probe_.back();
        to_probe_.pop_back();
        const HierarchyCut::Entry& entry = candidate.entry;
        tests += 1.0;
        if (frame.view().frustum().classify(cut.box_of(entry), candidate.mask) ==
            Containment::outside) {
            cut.keep_outside(entry);
        } else if (shared_.depth.hidden(frame, entry)) {
            cut.keep_hidden(frame, entry, Decision::hidden);
        } else if (!cut.opens(entry)) {
            cut.keep_visible(entry);
        } else if (cut.units_of(entry) < min_units) {
            cut.keep_unknown(entry);
        } else {
            cut.add_parts(frame, candidate, to_probe_);
        }
    }
    const double us = shared_.meter.has_clock()
                          ? shared_.meter.now_us() - from
                          : tests * shared_.costs().round(TestMethod::pyramid).us_per_test +
                                shared_.depth.shapes_us() - shapes_before_us;
    shared_.meter.spend(us, tests);
}

} // namespace occlude
