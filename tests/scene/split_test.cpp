#include <occlude/scene/split.h>

#include <occlude/core/rng.h>

#include <glm/geometric.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace occlude {
namespace {

struct Soup {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<uint32_t> indices;
};

// A closed ball with bumps: no two coordinates agree, so planes cut it everywhere.
Soup bumpy_ball(uint32_t rings, uint32_t segments, uint64_t seed)
{
    Soup soup;
    Rng rng{seed};
    const auto add = [&](const glm::vec3& direction) {
        soup.positions.push_back(direction * rng.range(0.9f, 1.1f));
        soup.normals.push_back(direction);
        return static_cast<uint32_t>(soup.positions.size() - 1);
    };
    const uint32_t top = add({0.0f, 1.0f, 0.0f});
    for (uint32_t r = 1; r < rings; ++r) {
        const float up = 3.14159f * static_cast<float>(r) / static_cast<float>(rings);
        for (uint32_t s = 0; s < segments; ++s) {
            const float around = 6.28318f * static_cast<float>(s) / static_cast<float>(segments);
            add({std::sin(up) * std::cos(around), std::cos(up), std::sin(up) * std::sin(around)});
        }
    }
    const uint32_t bottom = add({0.0f, -1.0f, 0.0f});
    const auto at = [&](uint32_t ring, uint32_t segment) {
        return ring == 0       ? top
               : ring == rings ? bottom
                               : 1 + (ring - 1) * segments + segment % segments;
    };
    for (uint32_t r = 0; r < rings; ++r) {
        for (uint32_t s = 0; s < segments; ++s) {
            const std::array<uint32_t, 4> c{at(r, s), at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)};
            if (c[0] != c[1]) {
                soup.indices.insert(soup.indices.end(), {c[0], c[1], c[3]});
            }
            if (c[2] != c[3]) {
                soup.indices.insert(soup.indices.end(), {c[1], c[2], c[3]});
            }
        }
    }
    return soup;
}

double area_of(std::span<const glm::vec3> positions, std::span<const uint32_t> indices)
{
    double area = 0.0;
    for (size_t i = 0; i < indices.size(); i += 3) {
        const glm::dvec3 a{positions[indices[i]]};
        const glm::dvec3 b{positions[indices[i + 1]]};
        const glm::dvec3 c{positions[indices[i + 2]]};
        area += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return area;
}

using Point = std::array<float, 3>;

// Directed edges that no triangle has in the other direction, by exact position: the border, and
// every crack and T-junction.
size_t open_edges(std::span<const glm::vec3> positions, std::span<const uint32_t> indices)
{
    std::map<std::pair<Point, Point>, int> edges;
    const auto point = [&](uint32_t index) {
        const glm::vec3& p = positions[index];
        return Point{p.x, p.y, p.z};
    };
    for (size_t i = 0; i < indices.size(); ++i) {
        const Point a = point(indices[i]);
        const Point b = point(indices[i % 3 == 2 ? i - 2 : i + 1]);
        ++edges[{a, b}];
        --edges[{b, a}];
    }
    size_t open = 0;
    for (const auto& [edge, balance] : edges) {
        open += balance > 0 ? static_cast<size_t>(balance) : 0;
    }
    return open;
}

SplitMesh split(const Soup& soup, uint32_t max_triangles)
{
    return split_triangles(soup.positions, soup.normals, soup.indices, max_triangles);
}

TEST(Split, ATriangleIsCutWhereThePlaneCrossesIt)
{
    // Two squares side by side along x, and one long triangle before both.
    Soup soup;
    soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0},
                      {2, 1, 0}, {0, 0, 1}, {2, 0, 1}, {2, 1, 1}};
    soup.normals.assign(9, {0, 0, 1});
    soup.normals[6] = {1, 0, 0};
    soup.indices = {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2, 6, 7, 8};
    const SplitMesh mesh = split(soup, 4);
    ASSERT_EQ(mesh.parts.size(), 2u);
    // Whatever the best plane is, the pieces fit together along it.
    EXPECT_DOUBLE_EQ(area_of(mesh.positions, mesh.indices), 3.0);
    EXPECT_EQ(mesh.tree.nodes.size(), 3u);
    for (const glm::vec3& normal : mesh.normals) {
        EXPECT_NEAR(glm::length(normal), 1.0f, 1e-6f);
    }
}

TEST(Split, CutsInterpolateNormalsAlongTheEdge)
{
    Soup soup;
    for (int i = 0; i < 8; ++i) { // a strip of thin triangles, all crossing x = 1
        const float y = static_cast<float>(i);
        soup.positions.insert(soup.positions.end(),
                              {{0.0f, y, 0.0f}, {4.0f, y + 0.5f, 0.0f}, {4.0f, y + 1.0f, 0.0f}});
        soup.normals.insert(soup.normals.end(), {{1, 0, 0}, {0, 1, 0}, {0, 1, 0}});
        const auto first = static_cast<uint32_t>(3 * i);
        soup.indices.insert(soup.indices.end(), {first, first + 1, first + 2});
    }
    const SplitMesh mesh = split(soup, 3);
    ASSERT_GT(mesh.parts.size(), 2u);
    for (size_t i = soup.positions.size(); i < mesh.positions.size(); ++i) {
        const float share = mesh.positions[i].x / 4.0f;
        const glm::vec3 expected =
            glm::normalize(glm::mix(glm::vec3{1, 0, 0}, glm::vec3{0, 1, 0}, share));
        EXPECT_NEAR(glm::distance(mesh.normals[i], expected), 0.0f, 1e-5f);
    }
}

TEST(Split, AClosedMeshStaysClosedBitByBitAndKeepsItsArea)
{
    const Soup ball = bumpy_ball(40, 60, 3);
    ASSERT_EQ(open_edges(ball.positions, ball.indices), 0u);
    for (const uint32_t max_triangles : {2000u, 300u, 40u}) {
        const SplitMesh mesh = split(ball, max_triangles);
        EXPECT_GT(mesh.parts.size(), ball.indices.size() / 3 / max_triangles);
        EXPECT_GT(mesh.cut_triangles, 0u);
        EXPECT_EQ(open_edges(mesh.positions, mesh.indices), 0u) << max_triangles;
        const double before = area_of(ball.positions, ball.indices);
        EXPECT_NEAR(area_of(mesh.positions, mesh.indices), before, 1e-5 * before);
    }
}

TEST(Split, WithoutSharingACutThereWouldBeCracks)
{
    // The measure works: one vertex moved by one bit opens edges.
    const Soup ball = bumpy_ball(20, 30, 4);
    SplitMesh mesh = split(ball, 200);
    const uint32_t used = mesh.indices[0];
    mesh.positions[used].x = std::nextafter(mesh.positions[used].x, 10.0f);
    std::vector<glm::vec3> own = mesh.positions;
    mesh.indices[0] = static_cast<uint32_t>(own.size());
    own.push_back(mesh.positions[used] + glm::vec3{1e-6f, 0.0f, 0.0f});
    EXPECT_GT(open_edges(own, mesh.indices), 0u);
}

TEST(Split, HardEdgesAreCutAtOnePointToo)
{
    // The same ball, every triangle with vertices and normals of its own.
    const Soup ball = bumpy_ball(20, 30, 5);
    Soup flat;
    for (size_t i = 0; i < ball.indices.size(); ++i) {
        flat.positions.push_back(ball.positions[ball.indices[i]]);
        flat.normals.push_back({0.0f, 0.0f, i % 2 == 0 ? 1.0f : -1.0f});
        flat.indices.push_back(static_cast<uint32_t>(i));
    }
    const SplitMesh mesh = split(flat, 50);
    EXPECT_GT(mesh.cut_triangles, 0u);
    EXPECT_EQ(open_edges(mesh.positions, mesh.indices), 0u);
}

TEST(Split, PartsAndTreeCoverTheMeshAndPartsDoNotOverlap)
{
    const Soup ball = bumpy_ball(30, 40, 6);
    const SplitMesh mesh = split(ball, 100);
    uint32_t next = 0;
    for (const PartitionPart& part : mesh.parts) {
        EXPECT_EQ(part.first_index, next);
        EXPECT_LE(part.index_count, 3 * 130u); // a few more than required, from cuts of neighbours
        next += part.index_count;
        for (uint32_t i = part.first_index; i < next; ++i) {
            const glm::vec3& p = mesh.positions[mesh.indices[i]];
            ASSERT_TRUE(contains(part.box, {p, p}));
        }
    }
    EXPECT_EQ(next, mesh.indices.size());
    // Cutting makes the sides of every inner node meet in a plane at most.
    for (const LocalTree::Node& node : mesh.tree.nodes) {
        if (node.first_child == LocalTree::kNone) {
            EXPECT_EQ(node.box, mesh.parts[node.part].box);
            continue;
        }
        const Aabb& a = mesh.tree.nodes[node.first_child].box;
        const Aabb& b = mesh.tree.nodes[node.first_child + 1].box;
        EXPECT_EQ(node.box, merge(a, b));
        EXPECT_TRUE(a.max.x <= b.min.x || a.max.y <= b.min.y || a.max.z <= b.min.z);
    }
}

TEST(Split, BuildingALocalTreeFromThePartsFindsThePlanesAgain)
{
    const SplitMesh mesh = split(bumpy_ball(30, 40, 6), 100);
    std::vector<Aabb> boxes;
    for (const PartitionPart& part : mesh.parts) {
        boxes.push_back(part.box);
    }
    size_t overlapping = 0;
    const LocalTree tree = build_local_tree(boxes);
    for (const LocalTree::Node& node : tree.nodes) {
        if (node.first_child != LocalTree::kNone) {
            const Aabb& a = tree.nodes[node.first_child].box;
            const Aabb& b = tree.nodes[node.first_child + 1].box;
            overlapping += a.max.x > b.min.x && a.max.y > b.min.y && a.max.z > b.min.z ? 1 : 0;
        }
    }
    EXPECT_EQ(overlapping, 0u);
    EXPECT_EQ(tree.nodes.size(), 2 * boxes.size() - 1);
}

TEST(Split, AxisAlignedBoxesAreNotCutAtAll)
{
    Soup soup;
    for (int i = 0; i < 50; ++i) {
        const auto first = static_cast<uint32_t>(soup.positions.size());
        const glm::vec3 low{static_cast<float>(2 * i), 0.0f, 0.0f};
        for (uint32_t c = 0; c < 8; ++c) {
            soup.positions.push_back(low + glm::vec3{c & 1, c >> 1 & 1, c >> 2});
            soup.normals.push_back({0, 1, 0});
        }
        for (const uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u, 4u, 6u, 5u, 5u, 6u, 7u}) {
            soup.indices.push_back(first + corner);
        }
    }
    const SplitMesh mesh = split(soup, 16);
    EXPECT_GT(mesh.parts.size(), 10u);
    EXPECT_EQ(mesh.cut_triangles, 0u);
    EXPECT_EQ(mesh.positions.size(), soup.positions.size());
}

TEST(Split, AMeshThatIsSmallEnoughStaysWhatItIs)
{
    const Soup ball = bumpy_ball(8, 8, 7);
    const SplitMesh mesh = split(ball, 1000);
    EXPECT_EQ(mesh.indices, ball.indices);
    EXPECT_EQ(mesh.parts.size(), 1u);
    EXPECT_TRUE(split({}, 10).parts.empty());
}

TEST(Split, TheUnknownIsNotCutAndTheHopelessIsLeft)
{
    Soup soup = bumpy_ball(10, 10, 8);
    soup.positions[5].x = std::numeric_limits<float>::quiet_NaN();
    const SplitMesh odd = split(soup, 20);
    size_t unbounded = 0;
    for (const PartitionPart& part : odd.parts) {
        unbounded += part.box.is_bounded() ? 0 : 1;
    }
    EXPECT_GE(unbounded, 1u);
    EXPECT_LT(unbounded, odd.parts.size());

    Soup stack; // a hundred times the same triangle: no plane helps
    stack.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    stack.normals.assign(3, {0, 0, 1});
    for (int i = 0; i < 100; ++i) {
        stack.indices.insert(stack.indices.end(), {0, 1, 2});
    }
    EXPECT_EQ(split(stack, 10).parts.size(), 1u);
}

// Triangles that pass through one another: however small the parts, a plane cuts most triangles
// that it meets.
Soup crossing_triangles(uint32_t count, uint64_t seed)
{
    Soup soup;
    Rng rng{seed};
    for (uint32_t i = 0; i < 3 * count; ++i) {
        soup.positions.push_back(
            {rng.range(-1.0f, 1.0f), rng.range(-1.0f, 1.0f), rng.range(-1.0f, 1.0f)});
        soup.normals.push_back({0.0f, 0.0f, 1.0f});
        soup.indices.push_back(i);
    }
    return soup;
}

TEST(Split, CrossingTrianglesEndWithinTheLimitAndSayThatPartsStayedLarge)
{
    constexpr uint32_t kCount = 200;
    const Soup soup = crossing_triangles(kCount, 5);
    const SplitMesh mesh = split(soup, 1);
    EXPECT_GT(mesh.unsplit_parts, 0u);
    EXPECT_LE(mesh.indices.size() / 3, 2 * kMaxSplitGrowth * kCount)
        << "with the corners of T-junctions";
    EXPECT_GT(mesh.indices.size() / 3, 2 * kCount) << "planes do cut them";
    EXPECT_NEAR(area_of(mesh.positions, mesh.indices), area_of(soup.positions, soup.indices), 1e-2);
}

TEST(Split, AnOrdinaryMeshIsFarFromTheLimit)
{
    EXPECT_EQ(split(bumpy_ball(24, 48, 3), 64).unsplit_parts, 0u);
}

TEST(Split, IsTheSameEveryTime)
{
    const Soup ball = bumpy_ball(20, 30, 9);
    const SplitMesh a = split(ball, 64);
    const SplitMesh b = split(ball, 64);
    EXPECT_EQ(a.indices, b.indices);
    EXPECT_EQ(a.positions, b.positions);
}

} // namespace
} // namespace occlude
