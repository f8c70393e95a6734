#include <occlude/cull/parts/multiquery.h>

#include <occlude/core/assert.h>

#include <algorithm>

namespace occlude {

void MultiqueryBatcher::clear()
{
    members_.clear();
    batch_.clear();
    added_.clear();
}

// The greedy choice of groups relies on this order.
void MultiqueryBatcher::sort_by_falling_keep(std::span<Candidate> candidates)
{
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
        return a.keep != b.keep ? a.keep > b.keep : a.order < b.order;
    });
    keep_.clear();
    for (const Candidate& candidate : candidates) {
        OCCLUDE_ASSERT(candidate.keep >= 0.0 && candidate.keep <= 1.0, "p_keep is a probability");
        keep_.push_back(candidate.keep);
    }
}

std::span<const MultiqueryBatcher::Test> MultiqueryBatcher::submit(CullFrame& frame,
                                                                   TestMethod method)
{
    issued_.clear();
    if (batch_.empty()) {
        return issued_;
    }
    frame.query(batch_, tickets_, method);
    std::swap(issued_, added_);
    OCCLUDE_ASSERT(tickets_.size() == issued_.size(), "a batch has one ticket for each test");
    for (size_t i = 0; i < issued_.size(); ++i) {
        issued_[i].ticket = tickets_[i];
        frame.counters().multiqueries += issued_[i].spans_nodes ? 1 : 0;
    }
    batch_.clear();
    return issued_;
}

} // namespace occlude
