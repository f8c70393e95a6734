// Multiqueries: one test for several nodes that will probably stay hidden together. If one of them
// is visible after all, the test is split.
//
// Implements  ShaderX7 8.4, "Multiqueries".
// Map         GetNextMultiQuery -> add_groups (its value: multiquery_value.h)
//             IssueQuery        -> add_test, submit
//             failed multiquery -> split
//
//   candidates ── add_groups ──► groups ── submit ──► one batch on the device
//   a group in which something is visible ── split ──► its halves, or its nodes one by one
//
// An algorithm calls a node by a number of its own, its *member*: a node id, or an index.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/multiquery_value.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace occlude {

class MultiqueryBatcher {
public:
    using Member = uint32_t;

    /// A node that may share a test.
    struct Candidate {
        Member member = 0;
        double keep = 0.0;  ///< p_keep: the probability that it stays hidden
        uint32_t order = 0; ///< of equally probable ones, the smallest comes first
    };
    struct Test {
        Ticket ticket = {};
        uint32_t first = 0; ///< into the members of this frame
        uint32_t count = 0;
        bool spans_nodes = false; ///< a multiquery, as the counters mean it: boxes of several nodes
    };

    /// A failed group of more than `most_singly` nodes is split into halves, a smaller one into
    /// single nodes.
    explicit MultiqueryBatcher(size_t most_singly = kNeverHalved)
        : most_singly_(most_singly)
    {
    }

    /// Changes `most_singly` from now on.
    void set_most_singly(size_t most_singly) { most_singly_ = most_singly; }

    /// Forgets all tests; called before each frame.
    void clear();
    /// True if no test was added since the last submit().
    bool empty() const { return batch_.empty(); }
    /// The number of tests added since the last submit(), and of their boxes.
    size_t test_count() const { return batch_.test_count(); }
    size_t box_count() const { return batch_.boxes().size(); }

    /// Adds one test. add_boxes(member, batch) adds the boxes of one member, at least one box.
    template <class AddBoxes>
    Test add_test(std::span<const Member> members, AddBoxes&& add_boxes);

    /// Adds a part that split() named: a test of members that were in a test before.
    template <class AddBoxes>
    Test add_part(const Test& part, AddBoxes&& add_boxes);

    /// Sorts `candidates` by descending p_keep, and greedily adds at most `most_tests` tests for
    /// groups of them. Returns how many candidates have a test now; these are the first ones. Calls
    /// added(test) for each test.
    template <class AddBoxes, class Added>
    size_t add_groups(std::span<Candidate> candidates, size_t most_tests, AddBoxes&& add_boxes,
                      Added&& added);

    /// Issues the tests added since the last call as one batch. Returns them in their order, with
    /// their tickets; valid until the next call.
    std::span<const Test> submit(CullFrame& frame, TestMethod method = TestMethod::automatic);

    std::span<const Member> members(const Test& test) const
    {
        return std::span{members_}.subspan(test.first, test.count);
    }

    /// Splits a failed test: something in the group is visible, but it is unknown which node. Calls
    /// each(part) for the tests that must follow. Precondition: the test has more than one member.
    template <class Each>
    void split(CullFrame& frame, const Test& failed, Each&& each);

private:
    void sort_by_falling_keep(std::span<Candidate> candidates);

    size_t most_singly_;
    std::vector<Member> members_; ///< the members of all tests of this frame, test by test
    TestBatch batch_;
    std::vector<Test> added_;  ///< the tests of `batch_`
    std::vector<Test> issued_; ///< tests of the last submit()
    std::vector<Ticket> tickets_;
    std::vector<double> keep_;  ///< probabilities of the sorted candidates
    std::vector<Member> group_; ///< scratch
};

template <class AddBoxes>
MultiqueryBatcher::Test MultiqueryBatcher::add_test(std::span<const Member> members,
                                                    AddBoxes&& add_boxes)
{
    const Test test{.first = static_cast<uint32_t>(members_.size()),
                    .count = static_cast<uint32_t>(members.size())};
    members_.insert(members_.end(), members.begin(), members.end());
    return add_part(test, add_boxes);
}

template <class AddBoxes>
MultiqueryBatcher::Test MultiqueryBatcher::add_part(const Test& part, AddBoxes&& add_boxes)
{
    OCCLUDE_ASSERT(part.first + part.count <= members_.size(), "the test belongs to another frame");
    const size_t first_box = batch_.boxes().size();
    for (const Member member : members(part)) {
        add_boxes(member, batch_);
    }
    batch_.end_test();
    const std::span<const QueryBox> boxes = batch_.boxes().subspan(first_box);
    const bool spans_nodes = std::ranges::any_of(
        boxes, [&](const QueryBox& box) { return box.subject != boxes.front().subject; });
    added_.push_back({Ticket{}, part.first, part.count, spans_nodes});
    return added_.back();
}

template <class AddBoxes, class Added>
size_t MultiqueryBatcher::add_groups(std::span<Candidate> candidates, size_t most_tests,
                                     AddBoxes&& add_boxes, Added&& added)
{
    sort_by_falling_keep(candidates);
    size_t done = 0;
    for (size_t test = 0; done < candidates.size() && test < most_tests; ++test) {
        const size_t size = best_multiquery_size(std::span{keep_}.subspan(done), most_singly_);
        group_.clear();
        for (const Candidate& candidate : candidates.subspan(done, size)) {
            group_.push_back(candidate.member);
        }
        added(add_test(group_, add_boxes));
        done += size;
    }
    return done;
}

template <class Each>
void MultiqueryBatcher::split(CullFrame& frame, const Test& failed, Each&& each)
{
    frame.counters().multiqueries_failed += failed.spans_nodes ? 1 : 0;
    OCCLUDE_ASSERT(failed.count > 1, "a test of one node cannot be split");
    const auto most = static_cast<uint32_t>(failed_multiquery_part(failed.count, most_singly_));
    for (uint32_t i = 0; i < failed.count; i += most) {
        each(Test{.first = failed.first + i, .count = std::min(most, failed.count - i)});
    }
}

} // namespace occlude
