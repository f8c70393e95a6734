#include <occlude/cull/parts/multiquery.h>

#include "support/trees.h"

#include <occlude/cull/parts/frame_record.h>
#include <occlude/device/scripted_device.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace occlude {
namespace {

using Candidate = MultiqueryBatcher::Candidate;
using Query = MultiqueryBatcher::Test;

class MultiqueryTest : public testing::Test {
protected:
    // Member m is leaf m of a row of eight.
    auto boxes()
    {
        return [this](uint32_t member, TestBatch& batch) {
            const NodeId leaf{7 + member};
            batch.add_box(frame_.test_box(leaf), leaf);
        };
    }
    std::vector<uint32_t> members(const Query& test) const
    {
        const auto span = batcher_.members(test);
        return {span.begin(), span.end()};
    }
    std::vector<std::vector<uint32_t>> group(std::vector<Candidate> candidates, size_t most_tests)
    {
        std::vector<std::vector<uint32_t>> groups;
        batcher_.add_groups(candidates, most_tests, boxes(),
                            [&](const Query& test) { groups.push_back(members(test)); });
        return groups;
    }

    const Hierarchy tree_ = test::row_tree(3);
    FrameRecord record_;
    const View view_ = test::look_ahead();
    ScriptedDevice device_;
    FrameReport report_;
    CullFrame frame_{tree_, record_, view_, device_, report_};
    MultiqueryBatcher batcher_{3};
};

TEST_F(MultiqueryTest, TheNodesMostLikelyToStayHiddenAreGroupedFirst)
{
    const std::vector<Candidate> candidates{
        {0, 0.3, 0}, {1, 0.99, 1}, {2, 0.99, 2}, {3, 0.99, 3}, {4, 0.2, 4}};
    EXPECT_EQ(group(candidates, 9), (std::vector<std::vector<uint32_t>>{{1, 2, 3}, {0}, {4}}));
}

TEST_F(MultiqueryTest, EquallyLikelyNodesKeepTheirOrder)
{
    EXPECT_EQ(group({{5, 0.99, 2}, {6, 0.99, 0}, {7, 0.99, 1}}, 9),
              (std::vector<std::vector<uint32_t>>{{6, 7, 5}}));
}

TEST_F(MultiqueryTest, NoMoreTestsAreAddedThanTheDeviceTakes)
{
    std::vector<Candidate> candidates{{0, 0.1, 0}, {1, 0.1, 1}, {2, 0.1, 2}};
    const size_t tested = batcher_.add_groups(candidates, 2, boxes(), [](const Query&) {});
    EXPECT_EQ(tested, 2u);
    EXPECT_EQ(batcher_.submit(frame_).size(), 2u);
}

TEST_F(MultiqueryTest, OneBatchHasATicketForEachTestInOrder)
{
    const uint32_t alone = 4;
    batcher_.add_test({&alone, 1}, boxes());
    const std::vector<uint32_t> pair{5, 6};
    batcher_.add_test(pair, boxes());
    const auto issued = batcher_.submit(frame_);
    ASSERT_EQ(issued.size(), 2u);
    EXPECT_EQ(members(issued[0]), std::vector<uint32_t>{4});
    EXPECT_EQ(members(issued[1]), pair);
    EXPECT_NE(issued[0].ticket, issued[1].ticket);
    EXPECT_EQ(report_.counters.batches, 1u);
    EXPECT_EQ(report_.counters.queries, 2u);
    EXPECT_EQ(report_.counters.boxes, 3u);
    EXPECT_EQ(report_.counters.multiqueries, 1u);
    EXPECT_TRUE(batcher_.empty());
    EXPECT_TRUE(batcher_.submit(frame_).empty());
    EXPECT_EQ(report_.counters.batches, 1u); // nothing was added: nothing is issued
}

TEST_F(MultiqueryTest, AFailedGroupIsHalvedUntilItIsSmall)
{
    const std::vector<uint32_t> seven{0, 1, 2, 3, 4, 5, 6};
    const Query failed = batcher_.add_test(seven, boxes());
    std::vector<std::vector<uint32_t>> parts;
    std::vector<Query> halves;
    batcher_.split(frame_, failed, [&](const Query& part) {
        parts.push_back(members(part));
        halves.push_back(part);
    });
    EXPECT_EQ(parts, (std::vector<std::vector<uint32_t>>{{0, 1, 2, 3}, {4, 5, 6}}));
    parts.clear();
    const Query half = batcher_.add_part(halves[1], boxes());
    batcher_.split(frame_, half, [&](const Query& part) { parts.push_back(members(part)); });
    EXPECT_EQ(parts, (std::vector<std::vector<uint32_t>>{{4}, {5}, {6}}));
    EXPECT_EQ(report_.counters.multiqueries_failed, 2u);
}

TEST_F(MultiqueryTest, WithoutHalvingAFailedGroupIsTestedNodeByNode)
{
    batcher_ = MultiqueryBatcher{};
    const std::vector<uint32_t> five{0, 1, 2, 3, 4};
    const Query failed = batcher_.add_test(five, boxes());
    size_t parts = 0;
    batcher_.split(frame_, failed, [&](const Query& part) {
        EXPECT_EQ(part.count, 1u);
        ++parts;
    });
    EXPECT_EQ(parts, 5u);
}

} // namespace
} // namespace occlude
