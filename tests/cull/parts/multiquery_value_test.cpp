#include <occlude/cull/parts/multiquery_value.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace occlude {
namespace {

TEST(KeepProbability, AnalyticCurveHasThePublishedValues)
{
    EXPECT_NEAR(analytic_keep_probability(0), 0.29, 5e-4);
    EXPECT_NEAR(analytic_keep_probability(1), 0.732, 5e-4);
    EXPECT_NEAR(analytic_keep_probability(2), 0.895, 5e-4);
    EXPECT_NEAR(analytic_keep_probability(3), 0.955, 5e-4);
    EXPECT_NEAR(analytic_keep_probability(5), 0.985, 5e-4);
    EXPECT_NEAR(analytic_keep_probability(1000), 0.99, 1e-9);
}

TEST(Multiquery, AtNinetyNinePercentTheBestGroupHasElevenNodesOfValueFivePointOneOne)
{
    const std::vector<double> keep(100, 0.99);
    EXPECT_EQ(best_multiquery_size(keep), 11u);
    EXPECT_NEAR(multiquery_value(11, std::pow(0.99, 11)), 5.11, 0.005);
}

TEST(Multiquery, GroupSizesFollowTheProbability)
{
    EXPECT_EQ(best_multiquery_size(std::vector<double>(200, 0.999)), 32u);
    EXPECT_EQ(best_multiquery_size(std::vector<double>(200, 0.9999)), 101u);
    EXPECT_EQ(best_multiquery_size(std::vector<double>(200, 0.955)), 5u);
    EXPECT_EQ(best_multiquery_size(std::vector<double>(200, 0.9)), 4u);
}

TEST(Multiquery, GreedyTakesTheSizeOfHighestValue)
{
    // The first maximum of V over all prefixes, by brute force.
    const std::vector<double> keep{0.999, 0.999, 0.99, 0.985, 0.985, 0.955, 0.9, 0.73, 0.29};
    double all_keep = 1.0;
    double best = 0.0;
    size_t best_size = 0;
    for (size_t i = 0; i < keep.size(); ++i) {
        all_keep *= keep[i];
        const double value = multiquery_value(i + 1, all_keep);
        if (value > best) {
            best = value;
            best_size = i + 1;
        }
    }
    EXPECT_EQ(best_multiquery_size(keep), best_size);
    EXPECT_GT(best_size, 2u);
    EXPECT_LT(best_size, keep.size());
}

TEST(Multiquery, NodesThatAreLikelyToTurnVisibleAreTestedAlone)
{
    EXPECT_EQ(best_multiquery_size(std::vector<double>{0.29, 0.29, 0.29}), 1u);
    EXPECT_EQ(best_multiquery_size(std::vector<double>{0.0}), 1u);
}

TEST(Multiquery, AGroupThatIsHalvedWhereItFailsMayBeLarger)
{
    const std::vector<double> keep(200, 0.99);
    EXPECT_GT(best_multiquery_size(keep, 3), best_multiquery_size(keep));
    EXPECT_EQ(best_multiquery_size(keep, 200), best_multiquery_size(keep));
    // 64 nodes, then two tests for each of four halvings, and four nodes one by one.
    EXPECT_NEAR(multiquery_value(64, 0.5, 4), 64.0 / (1.0 + 0.5 * (2.0 * 4.0 + 4.0)), 1e-12);
    EXPECT_EQ(multiquery_value(64, 0.49, 4), 0.0);
}

// Halving a failed group with one visible node, of any size, finds that node.
TEST(Multiquery, TheHalvesOfAFailedGroupEndInSingleNodes)
{
    for (size_t count = 2; count < 100; ++count) {
        size_t left = count;
        int halvings = 0;
        while (left > 1) {
            const size_t part = failed_multiquery_part(left, 3);
            EXPECT_EQ(part == 1, left <= 3);
            EXPECT_LT(part, left);
            EXPECT_LE((left + part - 1) / part, part == 1 ? 3u : 2u);
            left = part;
            ++halvings;
        }
        EXPECT_LE(halvings, 7);
    }
    EXPECT_EQ(failed_multiquery_part(50, kNeverHalved), 1u);
}

TEST(KeepTable, WithoutMeasurementsItIsTheAnalyticCurve)
{
    const KeepTable table;
    for (const uint32_t i : {0u, 1u, 7u, 1000u}) {
        EXPECT_DOUBLE_EQ(table.keep_probability(i), analytic_keep_probability(i));
    }
}

TEST(KeepTable, MeasuredValuesSpreadToLongerPersistences)
{
    KeepTable table;
    for (int i = 0; i < 4000; ++i) {
        table.record(3, i % 10 != 0); // nine of ten stay hidden
    }
    EXPECT_NEAR(table.keep_probability(3), 0.9, 0.002);
    EXPECT_DOUBLE_EQ(table.keep_probability(4), table.keep_probability(3));
    EXPECT_DOUBLE_EQ(table.keep_probability(4000000000u), table.keep_probability(3));
    EXPECT_DOUBLE_EQ(table.keep_probability(2), analytic_keep_probability(2)); // not downward
}

TEST(KeepTable, FewTestsMoveTheValueALittle)
{
    KeepTable table;
    const double before = table.keep_probability(5);
    table.record(5, false);
    EXPECT_LT(table.keep_probability(5), before);
    EXPECT_GT(table.keep_probability(5), 0.9 * before);
    for (int i = 0; i < 1000; ++i) {
        table.record(5, false);
    }
    EXPECT_LT(table.keep_probability(5), 0.02);
}

TEST(KeepTable, AgesShareBinsFromEightFramesOn)
{
    KeepTable table;
    for (int i = 0; i < 1000; ++i) {
        table.record(8, false);
    }
    EXPECT_LT(table.keep_probability(9), 0.02);  // the same bin
    EXPECT_LT(table.keep_probability(10), 0.02); // a higher one: propagated
    EXPECT_DOUBLE_EQ(table.keep_probability(7), analytic_keep_probability(7));
    for (int i = 0; i < 1000; ++i) {
        table.record(10, true);
    }
    EXPECT_GT(table.keep_probability(10), 0.9);
    EXPECT_LT(table.keep_probability(9), 0.02);
}

TEST(KeepTable, NoHistoryMakesANodeCertain)
{
    KeepTable table;
    for (int i = 0; i < 1000000; ++i) {
        table.record(9, true);
    }
    EXPECT_DOUBLE_EQ(table.keep_probability(9), KeepTable::kMostCertain);
}

} // namespace
} // namespace occlude
