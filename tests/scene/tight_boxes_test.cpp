#include <occlude/scene/tight_boxes.h>

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <limits>

namespace occlude {
namespace {

struct Soup {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;

    void triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
    {
        for (const glm::vec3& p : {a, b, c}) {
            indices.push_back(static_cast<uint32_t>(positions.size()));
            positions.push_back(p);
        }
    }
    // Small triangles all over the faces of a box.
    void faces(const glm::vec3& low, const glm::vec3& high)
    {
        constexpr int kSteps = 4;
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3;
            const int v = (axis + 2) % 3;
            for (int i = 0; i < 2 * kSteps * kSteps; ++i) {
                const auto at = [&](int x, int y) {
                    glm::vec3 p = i % 2 == 0 ? low : high;
                    p[u] = low[u] + (high[u] - low[u]) * static_cast<float>(x) / kSteps;
                    p[v] = low[v] + (high[v] - low[v]) * static_cast<float>(y) / kSteps;
                    return p;
                };
                const int x = i / 2 % kSteps;
                const int y = i / 2 / kSteps;
                triangle(at(x, y), at(x + 1, y), at(x, y + 1));
                triangle(at(x + 1, y + 1), at(x + 1, y), at(x, y + 1));
            }
        }
    }
    Shape boxes(uint32_t most) const { return tight_boxes(positions, indices, most); }
};

double volume(const Shape& shape)
{
    double sum = 0.0;
    for (const Aabb& box : shape) {
        const glm::vec3 e = box.extent();
        sum += double{e.x} * double{e.y} * double{e.z};
    }
    return sum;
}

TEST(TightBoxes, AnLIsTwoBoxes)
{
    Soup soup;
    soup.faces({0.0f, 0.0f, 0.0f}, {1.0f, 8.0f, 1.0f});
    soup.faces({1.0f, 0.0f, 0.0f}, {8.0f, 1.0f, 1.0f});
    const Shape shape = soup.boxes(16);
    ASSERT_EQ(shape.size(), 2u);
    EXPECT_NEAR(volume(shape), 8.0 + 7.0, 1e-3);
    EXPECT_GE(volume({shape[0]}), volume({shape[1]})) << "the largest comes first";
}

TEST(TightBoxes, WhatFillsItsBoxHasOne)
{
    Soup soup;
    soup.faces(glm::vec3{-1.0f}, glm::vec3{1.0f});
    // A box's six faces can be cut from its hollow inside; one face cannot be improved.
    Soup face;
    face.triangle({0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
    face.triangle({1.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
    EXPECT_EQ(face.boxes(16).size(), 1u);
    EXPECT_EQ(soup.boxes(1).size(), 1u);
    EXPECT_EQ(soup.boxes(1)[0], (Aabb{glm::vec3{-1.0f}, glm::vec3{1.0f}}));
}

TEST(TightBoxes, ThereAreNoMoreThanAskedForAndNoneForNothing)
{
    Soup soup;
    EXPECT_TRUE(soup.boxes(8).empty());
    Rng rng{3};
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 p{rng.range(-9.0f, 9.0f), rng.range(-9.0f, 9.0f), rng.range(-9.0f, 9.0f)};
        soup.triangle(p, p + glm::vec3{0.1f, 0.0f, 0.0f}, p + glm::vec3{0.0f, 0.1f, 0.1f});
    }
    EXPECT_TRUE(soup.boxes(0).empty());
    for (const uint32_t most : {1u, 2u, 5u, 16u, 64u}) {
        EXPECT_LE(soup.boxes(most).size(), most);
    }
    EXPECT_LT(volume(soup.boxes(64)), 0.5 * volume(soup.boxes(4)));
}

TEST(TightBoxes, EveryTriangleLiesInOneOfThem)
{
    Rng rng{7};
    for (int round = 0; round < 20; ++round) {
        Soup soup;
        for (int i = 0; i < 120; ++i) {
            const auto point = [&](float reach) {
                return glm::vec3{rng.range(-reach, reach), rng.range(-reach, reach),
                                 round % 3 == 0 ? 0.0f : rng.range(-reach, reach)};
            };
            const glm::vec3 p = point(20.0f);
            soup.triangle(p, p + point(2.0f), p + point(4.0f));
        }
        const Shape shape = soup.boxes(1 + rng.below(32));
        for (size_t i = 0; i < soup.indices.size(); i += 3) {
            const bool held = std::any_of(shape.begin(), shape.end(), [&](const Aabb& box) {
                return contains(box, {soup.positions[i], soup.positions[i]}) &&
                       contains(box, {soup.positions[i + 1], soup.positions[i + 1]}) &&
                       contains(box, {soup.positions[i + 2], soup.positions[i + 2]});
            });
            ASSERT_TRUE(held) << "round " << round << ", triangle " << i / 3;
        }
    }
}

TEST(TightBoxes, EqualCentersAndUnknownCornersAreNoTrouble)
{
    Soup soup;
    for (int i = 1; i < 40; ++i) {
        const auto r = static_cast<float>(i);
        soup.triangle({-r, -r, 0.0f}, {r, r, 0.0f}, {-r, r, 0.0f}); // all around the origin
    }
    EXPECT_EQ(soup.boxes(16).size(), 1u);
    soup.triangle({0.0f, std::numeric_limits<float>::quiet_NaN(), 0.0f}, {}, {});
    EXPECT_EQ(soup.boxes(16), Shape{Aabb::everything()});
}

} // namespace
} // namespace occlude
