#include <occlude/cull/cut_culler.h>

#include <occlude/core/rng.h>

#include <algorithm>

namespace occlude {

namespace {

// Of so many nodes that could be closed again few are tried in a frame: each costs a test, unless
// all of it is outside the frustum.
constexpr uint32_t kNodes = 48;
constexpr uint32_t kTried = 3;
constexpr uint32_t kTriedOutside = 16;

} // namespace

bool CutCuller::visible(NodeId node) const
{
    const Node& n = hierarchy().node(node);
    return std::ranges::any_of(cut_.entries(), [&](const Entry& entry) {
        const uint32_t first =
            entry.is_item() ? entry.place : hierarchy().node(entry.node).first_item;
        return entry.state == State::visible && first >= n.first_item &&
               first < n.first_item + n.subtree_items;
    });
}

// --- entries -------------------------------------------------------------------------------------

bool CutCuller::visit(CullFrame& frame, Candidate& candidate) const
{
    const Entry& entry = candidate.entry;
    return entry.is_item() ? frame.visit_item(entry.node, entry.place, candidate.mask)
                           : frame.visit(entry.node, candidate.mask);
}

void CutCuller::draw(CullFrame& frame, const Candidate& candidate, Decision decision) const
{
    const Entry& entry = candidate.entry;
    if (all_drawn_) {
        return;
    }
    if (entry.is_item()) {
        frame.draw_item(entry.node, entry.place, candidate.mask, decision);
    } else {
        frame.draw_leaf(entry.node, candidate.mask, decision);
    }
}

void CutCuller::add_parts(const CullFrame& frame, const Candidate& candidate,
                          std::vector<Candidate>& out)
{
    const Node& node = hierarchy().node(candidate.entry.node);
    parts_.clear();
    for (uint32_t i = 0; i < node.child_count; ++i) {
        const NodeId child{node.first_child.value + i};
        parts_.push_back({frame.view().distance_key(hierarchy().node(child).box), child,
                          HierarchyCut::kSubtree});
    }
    for (uint32_t place = node.first_item; place < node.first_item + node.own_items; ++place) {
        parts_.push_back({frame.view().distance_key(hierarchy().item_bounds()[place].box),
                          candidate.entry.node, place});
    }
    std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) {
        return a.distance != b.distance ? a.distance > b.distance
               : a.node != b.node       ? a.node > b.node
                                        : a.place > b.place;
    });
    for (const Part& part : parts_) {
        out.push_back({Entry{part.node, part.place}, candidate.mask, part.distance});
    }
}

void CutCuller::keep_hidden(CullFrame& frame, Entry entry, Decision decision)
{
    if (decision == Decision::undecided) {
        entry.frames_hidden = 0;
        wasted(entry);
    } else {
        entry.frames_hidden = static_cast<uint16_t>(std::min(entry.frames_hidden + 1, 0xffff));
        spared(entry);
        if (all_drawn_) {
            // nothing is decided
        } else if (entry.is_item()) {
            frame.decide_item(entry.node, entry.place, decision);
        } else {
            frame.decide(entry.node, decision);
        }
    }
    entry.state = State::hidden;
    entry.tested = frame.stamp();
    cut_.keep(entry);
}

void CutCuller::keep_visible(Entry entry)
{
    entry.state = State::visible;
    entry.frames_hidden = 0;
    cut_.keep(entry);
}

void CutCuller::keep_outside(Entry entry)
{
    entry.state = State::outside;
    entry.frames_hidden = 0;
    cut_.keep(entry);
}

// --- one frame, in order -------------------------------------------------------------------------

void CutCuller::sort_out(CullFrame& frame)
{
    drawn_.clear();
    drawn_before_read_ = 0;
    candidates_.clear();
    tests_ = 0.0;
    if (cut_.empty()) {
        cut_.reset(hierarchy());
    }
    const std::span<const Entry> entries = cut_.entries();
    for (size_t i = 0; i < entries.size(); ++i) {
        HierarchyCut::fetch_ahead(hierarchy(), entries, i);
        Candidate candidate{entries[i]};
        Entry& entry = candidate.entry;
        if (!visit(frame, candidate)) {
            keep_outside(entry);
        } else if (entry.state == State::visible && still_visible(entry)) {
            // By their middle: the nearest point of what is large, and around the eye, says
            // nothing.
            const glm::vec3 middle = box_of(entry).center();
            candidate.distance = frame.view().distance_key({middle, middle});
            drawn_.push_back(candidate);
        } else {
            entry.state = entry.state == State::visible ? State::hidden : entry.state;
            candidates_.push_back(candidate);
        }
    }
}

void CutCuller::draw_expected(CullFrame& frame)
{
    order_.clear();
    for (uint32_t i = 0; i < drawn_.size(); ++i) {
        order_.emplace_back(drawn_[i].distance, i);
    }
    std::sort(order_.begin(), order_.end());
    stack_.clear();
    for (const auto& [distance, i] : order_) {
        stack_.push_back(drawn_[i]);
    }
    drawn_.swap(stack_);
    for (const Candidate& candidate : drawn_) {
        draw(frame, candidate, Decision::drawn_tested);
    }
}

bool CutCuller::read(CullFrame& frame)
{
    if (!depth_.read(frame)) {
        return false;
    }
    drawn_before_read_ = drawn_.size();
    return true;
}

// Of an item, or of the only one of a node. Null if there is none, or nobody asks for it.
const ItemShapes::Placed* CutCuller::shape_of(const Entry& entry) const
{
    if (!has_shapes() || items_of(entry) != 1) {
        return nullptr;
    }
    const uint32_t place = entry.is_item() ? entry.place : hierarchy().node(entry.node).first_item;
    return hierarchy().shapes()->find(hierarchy().items()[place]);
}

bool CutCuller::shape_hidden(const CullFrame& frame, const Entry& entry,
                             const ItemShapes::Placed* shape)
{
    if (shape == nullptr || !depth_.known() || !worth_shape(entry)) {
        return false;
    }
    const double from = shape_clock();
    const bool hidden = depth_.hides(frame.view(), *shape, most_texels(entry));
    shape_answered(hidden, shape_clock() - from);
    return hidden;
}

// Adds those candidates that `tests` does not have yet.
void CutCuller::prepare(const CullFrame& frame, std::span<const Candidate> candidates,
                        Tests& tests) const
{
    const size_t known = tests.boxes.size();
    for (const Candidate& candidate : candidates.subspan(known)) {
        tests.boxes.push_back(box_of(candidate.entry));
        tests.most_texels.push_back(most_texels(candidate.entry));
        if (has_shapes()) {
            tests.shapes.push_back(shape_of(candidate.entry));
        }
    }
    tests.bounds.resize(tests.boxes.size());
    depth_.project(frame.view(), std::span{tests.boxes}.subspan(known),
                   std::span{tests.bounds}.subspan(known));
}

void CutCuller::test(const CullFrame& frame, std::span<const Candidate> candidates, Tests& tests)
{
    tests.hidden.resize(tests.boxes.size());
    depth_.rectangles_hide(tests.bounds, tests.hidden);
    for (size_t i = 0; i < tests.boxes.size(); ++i) {
        if (tests.hidden[i] == 0) {
            tests.hidden[i] =
                depth_.closer(tests.boxes[i], tests.bounds[i], tests.most_texels[i]) ? 1 : 0;
        }
    }
    for (size_t i = 0; i < tests.shapes.size(); ++i) {
        if (tests.hidden[i] == 0 && shape_hidden(frame, candidates[i].entry, tests.shapes[i])) {
            tests.hidden[i] = 1;
        }
    }
}

void CutCuller::project_all(CullFrame& frame)
{
    for (Tests* tests : {&candidate_tests_, &drawn_tests_}) {
        tests->boxes.clear();
        tests->most_texels.clear();
        tests->shapes.clear();
    }
    prepare(frame, candidates_, candidate_tests_);
    prepare(frame, drawn_, drawn_tests_);
}

// Leaves on the stack what is not hidden, the nearest on top.
void CutCuller::test_candidates(CullFrame& frame)
{
    stack_.clear();
    test(frame, candidates_, candidate_tests_);
    for (size_t i = 0; i < candidates_.size(); ++i) {
        Candidate& candidate = candidates_[i];
        if (candidate_tests_.hidden[i] != 0) {
            keep_hidden(frame, candidate.entry, Decision::hidden);
        } else {
            candidate.distance = frame.view().distance_key(candidate_tests_.boxes[i]);
            stack_.push_back(candidate);
        }
    }
    std::sort(stack_.begin(), stack_.end(),
              [](const Candidate& a, const Candidate& b) { return a.distance > b.distance; });
}

// Draws what a candidate is, or puts what it consists of on the stack.
void CutCuller::open(CullFrame& frame, const Candidate& candidate, bool tested)
{
    if (opens(candidate.entry)) {
        add_parts(frame, candidate, stack_);
        return;
    }
    draw(frame, candidate, tested ? Decision::drawn_revealed : Decision::drawn);
    drawn_.push_back(candidate);
}

// Walks what is not known to be hidden near to far.
void CutCuller::reveal(CullFrame& frame)
{
    size_t untouched = stack_.size(); // at the bottom: in the frustum, and tested if depth is known
    bool tested_once = depth_.known();
    while (!stack_.empty()) {
        Candidate candidate = stack_.back();
        stack_.pop_back();
        bool tested = tested_once && stack_.size() < untouched;
        if (stack_.size() < untouched) {
            untouched = stack_.size();
        } else if (!visit(frame, candidate)) {
            keep_outside(candidate.entry);
            continue;
        }
        if (read_again(frame)) {
            tested_once = false;
            tested = false;
        }
        if (!tested && depth_.known() && worth_testing(candidate.entry)) {
            ++tests_;
            const bool found_hidden = hidden(frame, candidate.entry);
            answered(found_hidden);
            if (found_hidden) {
                keep_hidden(frame, candidate.entry, Decision::hidden);
                continue;
            }
            tested = true;
        }
        open(frame, candidate, tested);
    }
}

void CutCuller::retest(CullFrame& frame)
{
    const std::span tested = std::span{drawn_}.first(drawn_before_read_);
    if (!tested.empty()) { // depth was read
        prepare(frame, tested, drawn_tests_);
        test(frame, tested, drawn_tests_);
    }
    for (size_t i = 0; i < drawn_.size(); ++i) {
        Entry& entry = drawn_[i].entry;
        if (i >= tested.size()) {
            keep_visible(entry);
        } else if (drawn_tests_.hidden[i] != 0) {
            keep_hidden(frame, entry, Decision::undecided);
        } else {
            entry.tested = frame.stamp();
            keep_visible(entry);
        }
    }
}

bool CutCuller::merges(CullFrame& frame, NodeId node)
{
    ++tests_;
    return hidden(frame, Entry{node});
}

void CutCuller::finish_cut(CullFrame& frame, uint64_t seed)
{
    const uint64_t turn = hash64(seed, frame.stamp());
    const auto chosen = [&](NodeId node, State state) {
        return uniform_below(mix64(turn ^ node.value), kNodes) <
               (state == State::outside ? kTriedOutside : kTried);
    };
    cut_.finish(hierarchy(), chosen, [&](NodeId node, bool all_outside, Entry& replacement) {
        PlaneMask mask = Frustum::kAllPlanes;
        const bool outside = frame.view().frustum().classify(hierarchy().node(node).box, mask) ==
                             Containment::outside;
        replacement.state = all_outside || outside ? State::outside : State::hidden;
        return all_outside || outside ? outside : merges(frame, node);
    });
}

} // namespace occlude
