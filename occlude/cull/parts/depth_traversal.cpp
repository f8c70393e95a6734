#include <occlude/cull/parts/depth_traversal.h>

#include <algorithm>
#include <utility>

namespace occlude {

void DepthTraversal::start_frame(const CullFrame& frame)
{
    depth_.start_frame(frame.samples());
    drawn_before_read_ = 0;
    single_tests_ = 0;
    shapes_us_ = 0.0;
    to_reveal_.stack.clear();
    to_reveal_.paused.reset();
}

bool DepthTraversal::read(CullFrame& frame)
{
    if (!depth_.read(frame)) {
        return false;
    }
    drawn_before_read_ = cut_.drawn().size();
    to_reveal_.candidates_tested = false;
    return true;
}

// --- one box, one shape --------------------------------------------------------------------------

uint32_t DepthTraversal::max_texels(const Entry& entry) const
{
    const double texels = std::min(budget_.texels_per_us * cut_.draw_us(entry), budget_.max_texels);
    return texels < budget_.min_texels ? budget_.texels_below_min : static_cast<uint32_t>(texels);
}

bool DepthTraversal::has_shapes() const
{
    const ItemShapes* shapes = cut_.hierarchy().shapes();
    return use_shapes_ && shapes != nullptr && !shapes->empty();
}

// The shape of an item, or of the only item of a node. Null if there is none or shapes are off.
const ItemShapes::Placed* DepthTraversal::shape_of(const Entry& entry) const
{
    if (!has_shapes() || cut_.items_of(entry) != 1) {
        return nullptr;
    }
    const Hierarchy& hierarchy = cut_.hierarchy();
    const ItemPosition place =
        entry.is_item() ? entry.place : ItemPosition{hierarchy.node(entry.node).first_item};
    return hierarchy.shapes()->find(hierarchy.item(place));
}

// Tests of shapes are few and far apart, so that each one can be timed.
bool DepthTraversal::shape_hidden(const CullFrame& frame, const Entry& entry,
                                  const ItemShapes::Placed* shape)
{
    // Clamps a timing to this multiple of the running average: a longer one means that the thread
    // was preempted.
    constexpr double kOutlierRatio = 16.0;
    constexpr double kStep = 1.0 / 64.0; // weight of one timing in the running average

    if (shape == nullptr || !depth_.known() ||
        !(shape_hidden_share_.value() * cut_.draw_us(entry) > shape_us_)) {
        return false;
    }
    const double from = clock_ != nullptr ? (*clock_)() : 0.0;
    const bool hidden = depth_.hides(frame.view(), *shape, max_texels(entry));
    shape_hidden_share_.note(hidden);
    if (clock_ != nullptr) {
        constexpr double kUsPerSecond = 1e6;
        const double us = kUsPerSecond * ((*clock_)() - from);
        shape_us_ += kStep * (std::min(us, kOutlierRatio * shape_us_) - shape_us_);
        shapes_us_ += us;
    } else {
        shapes_us_ += shape_us_;
    }
    return hidden;
}

bool DepthTraversal::hidden(const CullFrame& frame, const Entry& entry)
{
    return depth_.hides(frame.view(), cut_.box_of(entry), max_texels(entry)) ||
           shape_hidden(frame, entry, shape_of(entry));
}

bool DepthTraversal::node_hidden(const CullFrame& frame, NodeId node)
{
    ++single_tests_;
    return hidden(frame, Entry{node});
}

// --- many at once --------------------------------------------------------------------------------

// Prepares the candidates that `tests` does not hold yet.
void DepthTraversal::prepare(const CullFrame& frame, std::span<const CutCandidate> candidates,
                             Tests& tests) const
{
    const size_t known = tests.boxes.size();
    for (const CutCandidate& candidate : candidates.subspan(known)) {
        tests.boxes.push_back(cut_.box_of(candidate.entry));
        tests.max_texels.push_back(max_texels(candidate.entry));
        if (has_shapes()) {
            tests.shapes.push_back(shape_of(candidate.entry));
        }
    }
    tests.bounds.resize(tests.boxes.size());
    depth_.project(frame.view(), std::span{tests.boxes}.subspan(known),
                   std::span{tests.bounds}.subspan(known));
}

void DepthTraversal::test(const CullFrame& frame, std::span<const CutCandidate> candidates,
                          Tests& tests)
{
    tests.hidden.resize(tests.boxes.size());
    depth_.rectangles_hide(tests.bounds, tests.hidden);
    for (size_t i = 0; i < tests.boxes.size(); ++i) {
        if (tests.hidden[i] == 0) {
            const bool hides =
                depth_.refined_hides(tests.boxes[i], tests.bounds[i], tests.max_texels[i]);
            tests.hidden[i] = hides ? 1 : 0;
        }
    }
    for (size_t i = 0; i < tests.shapes.size(); ++i) {
        if (tests.hidden[i] == 0 && shape_hidden(frame, candidates[i].entry, tests.shapes[i])) {
            tests.hidden[i] = 1;
        }
    }
}

void DepthTraversal::project_all(CullFrame& frame)
{
    for (Tests* tests : {&candidate_tests_, &drawn_tests_}) {
        tests->boxes.clear();
        tests->max_texels.clear();
        tests->shapes.clear();
    }
    prepare(frame, cut_.candidates(), candidate_tests_);
    prepare(frame, cut_.drawn(), drawn_tests_);
}

void DepthTraversal::test_candidates(CullFrame& frame)
{
    std::vector<CutCandidate>& stack = to_reveal_.stack;
    stack.clear();
    test(frame, cut_.candidates(), candidate_tests_);
    for (size_t i = 0; i < cut_.candidates().size(); ++i) {
        CutCandidate& candidate = cut_.candidates()[i];
        if (candidate_tests_.hidden[i] != 0) {
            cut_.keep_hidden(frame, candidate.entry, Decision::hidden);
        } else {
            candidate.distance = frame.view().distance_key(candidate_tests_.boxes[i]);
            stack.push_back(candidate);
        }
    }
    std::sort(stack.begin(), stack.end(),
              [](const CutCandidate& a, const CutCandidate& b) { return a.distance > b.distance; });
    to_reveal_.candidates = stack.size();
    to_reveal_.candidates_tested = depth_.known();
}

// --- near to far ---------------------------------------------------------------------------------

// Takes the nearest candidate or part in the frustum. Candidates are known to be inside; parts of
// opened nodes may be outside.
bool DepthTraversal::next_to_reveal(CullFrame& frame)
{
    while (!to_reveal_.stack.empty()) {
        CutCandidate candidate = to_reveal_.stack.back();
        to_reveal_.stack.pop_back();
        to_reveal_.is_candidate = to_reveal_.stack.size() < to_reveal_.candidates;
        if (to_reveal_.is_candidate) {
            to_reveal_.candidates = to_reveal_.stack.size();
        } else if (!cut_.visit(frame, candidate)) {
            cut_.keep_outside(candidate.entry);
            continue;
        }
        to_reveal_.paused = candidate;
        return true;
    }
    return false;
}

// Draws a candidate, or pushes its parts.
void DepthTraversal::open(CullFrame& frame, const CutCandidate& candidate, bool tested)
{
    if (cut_.opens(candidate.entry)) {
        cut_.add_parts(frame, candidate, to_reveal_.stack);
        return;
    }
    cut_.draw(frame, candidate, tested ? Decision::drawn_revealed : Decision::drawn);
    cut_.drawn().push_back(candidate);
}

bool DepthTraversal::reveal(CullFrame& frame, double max_waiting_us)
{
    bool resumes = to_reveal_.paused.has_value();
    while (resumes || next_to_reveal(frame)) {
        if (!resumes && frame.caps().read_depth && cut_.queued_us(frame) > max_waiting_us) {
            return true;
        }
        resumes = false;
        const CutCandidate candidate = *std::exchange(to_reveal_.paused, std::nullopt);
        const Entry& entry = candidate.entry;
        bool tested = to_reveal_.is_candidate && to_reveal_.candidates_tested;
        if (!tested && depth_.known() &&
            cut_.hidden_share.value() * cut_.draw_us(entry) > budget_.test_us) {
            ++single_tests_;
            const bool found_hidden = hidden(frame, entry);
            cut_.hidden_share.note(found_hidden);
            if (found_hidden) {
                cut_.keep_hidden(frame, entry, Decision::hidden);
                continue;
            }
            tested = true;
        }
        open(frame, candidate, tested);
    }
    return false;
}

void DepthTraversal::retest(CullFrame& frame)
{
    std::vector<CutCandidate>& drawn = cut_.drawn();
    const std::span tested = std::span{drawn}.first(drawn_before_read_);
    if (!tested.empty()) { // depth was read since the last call
        prepare(frame, tested, drawn_tests_);
        test(frame, tested, drawn_tests_);
    }
    for (size_t i = 0; i < drawn.size(); ++i) {
        Entry entry = drawn[i].entry;
        if (i >= tested.size()) {
            cut_.keep_visible(entry);
        } else if (drawn_tests_.hidden[i] != 0) {
            cut_.keep_drawn_in_vain(frame, entry);
        } else {
            entry.tested = frame.stamp();
            cut_.keep_visible(entry);
        }
    }
}

} // namespace occlude
