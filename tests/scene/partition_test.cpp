#include <occlude/scene/partition.h>

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace occlude {
namespace {

struct Soup {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
};

Soup random_soup(uint64_t seed, uint32_t triangles)
{
    Soup soup;
    Rng rng(seed);
    for (uint32_t i = 0; i < triangles; ++i) {
        const glm::vec3 at{rng.range(-50.0f, 50.0f), rng.range(0.0f, 10.0f),
                           rng.range(-20.0f, 20.0f)};
        for (int corner = 0; corner < 3; ++corner) {
            soup.indices.push_back(static_cast<uint32_t>(soup.positions.size()));
            soup.positions.push_back(at + glm::vec3{rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f),
                                                    rng.range(0.0f, 1.0f)});
        }
    }
    return soup;
}

using Corners = std::array<uint32_t, 3>;
std::vector<Corners> sorted_triangles(const std::vector<uint32_t>& indices)
{
    std::vector<Corners> triangles;
    for (size_t i = 0; i < indices.size(); i += 3) {
        triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

TEST(Partition, KeepsExactlyTheTrianglesGivenWithTheirCornersInOrder)
{
    const Soup soup = random_soup(11, 5000);
    const Partition partition = partition_triangles(soup.positions, soup.indices, 100);
    EXPECT_EQ(sorted_triangles(partition.indices), sorted_triangles(soup.indices));
}

TEST(Partition, PartsCoverAllIndicesInOrderAndHoldAtMostTheLimit)
{
    const Soup soup = random_soup(12, 4321);
    const Partition partition = partition_triangles(soup.positions, soup.indices, 128);
    uint32_t next = 0;
    for (const PartitionPart& part : partition.parts) {
        EXPECT_EQ(part.first_index, next);
        EXPECT_GT(part.index_count, 0u);
        EXPECT_LE(part.index_count, 3u * 128u);
        next += part.index_count;
    }
    EXPECT_EQ(next, soup.indices.size());
    // Cuts leave a quarter or more on either side, so that no part is tiny.
    EXPECT_LE(partition.parts.size(), 4u * 4321u / 128u);
}

TEST(Partition, BoxesAreTightAroundTheirTriangles)
{
    const Soup soup = random_soup(13, 2000);
    const Partition partition = partition_triangles(soup.positions, soup.indices, 64);
    ASSERT_GT(partition.parts.size(), 20u);
    for (const PartitionPart& part : partition.parts) {
        Aabb box;
        for (uint32_t i = part.first_index; i < part.first_index + part.index_count; ++i) {
            const glm::vec3& p = soup.positions[partition.indices[i]];
            box = merge(box, {p, p});
        }
        EXPECT_EQ(part.box, box);
    }
}

TEST(Partition, SeparatesInSpace)
{
    const Soup soup = random_soup(14, 8192);
    const Partition partition = partition_triangles(soup.positions, soup.indices, 256);
    Aabb all;
    float area = 0.0f;
    for (const PartitionPart& part : partition.parts) {
        all = merge(all, part.box);
        area += surface_area(part.box);
    }
    const float mean = area / static_cast<float>(partition.parts.size());
    EXPECT_LT(mean, 0.2f * surface_area(all));
}

TEST(Partition, ASmallMeshStaysOnePartInItsOwnOrder)
{
    const Soup soup = random_soup(15, 100);
    const Partition partition = partition_triangles(soup.positions, soup.indices, 100);
    ASSERT_EQ(partition.parts.size(), 1u);
    EXPECT_EQ(partition.indices, soup.indices);
}

TEST(Partition, OfNothingIsNothing)
{
    const Partition partition = partition_triangles({}, {}, 100);
    EXPECT_TRUE(partition.indices.empty());
    EXPECT_TRUE(partition.parts.empty());
}

TEST(Partition, SplitsTrianglesThatAllLieInOnePlace)
{
    Soup soup;
    soup.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
    for (uint32_t i = 0; i < 1000; ++i) {
        soup.indices.insert(soup.indices.end(), {0, 1, 2});
    }
    const Partition partition = partition_triangles(soup.positions, soup.indices, 10);
    EXPECT_EQ(partition.indices.size(), soup.indices.size());
    for (const PartitionPart& part : partition.parts) {
        EXPECT_LE(part.index_count, 30u);
    }
}

TEST(Partition, OneTrianglePerPartIsTheFinest)
{
    const Soup soup = random_soup(16, 77);
    EXPECT_EQ(partition_triangles(soup.positions, soup.indices, 1).parts.size(), 77u);
}

TEST(Partition, IsTheSameEveryTime)
{
    const Soup soup = random_soup(17, 3000);
    const Partition first = partition_triangles(soup.positions, soup.indices, 100);
    const Partition second = partition_triangles(soup.positions, soup.indices, 100);
    EXPECT_EQ(first.indices, second.indices);
    uint64_t hash = 0;
    for (uint32_t index : first.indices) {
        hash = hash64(hash, index);
    }
    // Changes only with the algorithm: the result must not differ between compilers.
    EXPECT_EQ(hash, 7248543249782207257u);
}

TEST(Partition, ATriangleWithNanMakesItsPartUnbounded)
{
    Soup soup = random_soup(18, 300);
    soup.positions[5].y = std::numeric_limits<float>::quiet_NaN();
    const Partition partition = partition_triangles(soup.positions, soup.indices, 50);
    size_t unbounded = 0;
    for (const PartitionPart& part : partition.parts) {
        unbounded += part.box == Aabb::everything() || part.box.has_nan();
    }
    EXPECT_EQ(unbounded, 1u);
    EXPECT_EQ(sorted_triangles(partition.indices), sorted_triangles(soup.indices));
}

} // namespace
} // namespace occlude
