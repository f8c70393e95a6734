#include <occlude/core/ids.h>

#include <gtest/gtest.h>

#include <type_traits>
#include <unordered_set>

namespace occlude {
namespace {

TEST(Ids, DefaultIdIsInvalid)
{
    EXPECT_FALSE(ItemId{}.valid());
    EXPECT_FALSE(NodeId{}.valid());
    EXPECT_FALSE(ObjectId{}.valid());
    EXPECT_FALSE(Ticket{}.valid());
}

TEST(Ids, ZeroIsAValidIndexButNotAValidGeneration)
{
    EXPECT_TRUE(NodeId{0u}.valid());
    EXPECT_FALSE((Ticket{0, 0}).valid());
    EXPECT_TRUE((Ticket{0, 1}).valid());
}

TEST(Ids, OrderIsThatOfTheIndex)
{
    EXPECT_LT(ItemId{1u}, ItemId{2u});
    EXPECT_EQ(ItemId{7u}, ItemId{size_t{7}});
    EXPECT_LT(ItemId{7u}, ItemId{});
}

TEST(Ids, RecycledSlotIsAnotherHandle)
{
    EXPECT_NE((ObjectId{3, 1}), (ObjectId{3, 2}));
}

TEST(Ids, KindsDoNotMix)
{
    static_assert(!std::is_convertible_v<ItemId, NodeId>);
    static_assert(!std::is_convertible_v<uint32_t, NodeId>);
    static_assert(!std::is_convertible_v<ObjectId, Ticket>);
    static_assert(!std::is_constructible_v<NodeId, ItemId>);
    std::unordered_set<NodeId> set{NodeId{1u}, NodeId{2u}, NodeId{1u}};
    EXPECT_EQ(set.size(), 2u);
}

} // namespace
} // namespace occlude
