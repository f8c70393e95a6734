#include <occlude/cull/adaptive/method_trials.h>

namespace occlude {

// A method that costs at least this many times the method in use, by the hints, is never tried.
constexpr double kHopelessRatio = 4.0;

void MethodTrials::try_one(CullFrame& frame, std::span<const CutCandidate> candidates,
                           size_t free_tickets)
{
    if (!shared_.meter.may_try() || candidates.empty() || !chooses_) {
        return;
    }
    const AdaptivePlanner& planner = shared_.planner;
    const double used_us = planner.expected_us(shared_.costs(), planner.method());
    for (const TestMethod method : {TestMethod::pyramid, TestMethod::raster, TestMethod::queries}) {
        const CostModel::RoundSize size = shared_.costs().least_known(method);
        const bool tried_before = shared_.costs().rounds_measured(method) > 0 && size.boxes == 1;
        const double max_us = (tried_before ? 1.0 : kHopelessRatio) * used_us;
        if (!shared_.meter.may_try() || size.tests == 0 ||
            planner.expected_us(shared_.costs(), method) > max_us) {
            continue;
        }
        if (method == TestMethod::pyramid) {
            if (read_is_due(frame)) {
                read_and_measure(frame);
            }
        } else if (size.tests <= free_tickets) {
            try_round(frame, method, size, candidates);
        }
    }
}

bool MethodTrials::read_is_due(const CullFrame& frame) const
{
    return shared_.meter.may_try() && !shared_.planner.reads_are_expensive(shared_.costs()) &&
           frame.counters().items_drawn > 0 && frame.view().size_px().x > 0 &&
           frame.view().size_px().y > 0 && shared_.costs().has(TestMethod::pyramid) &&
           shared_.costs().unmeasured_tile_px() > 0;
}

bool MethodTrials::read_and_measure(CullFrame& frame)
{
    shared_.meter.note_trial();
    const int tile_px = shared_.costs().unmeasured_tile_px();
    shared_.depth.set_tile_px(tile_px);
    shared_.depth.make_room(frame.view());
    const double from = shared_.meter.now_us();
    const bool known = shared_.depth.read(frame);
    const double to = shared_.meter.now_us();
    shared_.meter.check_clock(from, to);
    shared_.meter.note_read(tile_px, to - from);
    shared_.depth.set_tile_px(shared_.costs().tile_px());
    return known;
}

// Tests boxes that the near plane does not touch; tests nothing if there are too few of them.
void MethodTrials::try_round(CullFrame& frame, TestMethod method, CostModel::RoundSize size,
                             std::span<const CutCandidate> candidates)
{
    const size_t boxes_per_test = size.boxes / size.tests;
    batch_.clear();
    for (size_t i = 0; i < candidates.size() && batch_.boxes().size() < size.boxes; ++i) {
        const HierarchyCut::Entry& entry = candidates[i].entry;
        if (!shared_.touches_near(frame, entry)) {
            batch_.add_box(shared_.test_box(frame, entry), entry.node);
            if (batch_.boxes().size() % boxes_per_test == 0) {
                batch_.end_test();
            }
        }
    }
    if (batch_.boxes().size() < size.boxes) {
        return;
    }
    shared_.meter.note_trial();
    const double from = shared_.meter.now_us();
    frame.query(batch_, tickets_, method);
    for (const Ticket ticket : tickets_) {
        frame.wait(ticket);
    }
    const double to = shared_.meter.now_us();
    shared_.meter.check_clock(from, to);
    shared_.meter.note_round(method, size.tests, size.boxes, to - from);
}

} // namespace occlude
