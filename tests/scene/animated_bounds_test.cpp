#include <occlude/scene/animated_bounds.h>

#include <occlude/core/rng.h>

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace occlude {
namespace {

Aabb box_at(const glm::vec3& center)
{
    return {center - 1.0f, center + 1.0f};
}

// A figure that flies 10 units along x in 11 frames, rising and falling.
std::vector<glm::vec3> flight()
{
    std::vector<glm::vec3> roots;
    for (int frame = 0; frame <= 10; ++frame) {
        const auto t = static_cast<float>(frame);
        roots.push_back({t, 0.2f * t * (10.0f - t), 0.0f});
    }
    return roots;
}

TEST(AnimatedBounds, OneBoxBoundsAllFramesOfAnAnimation)
{
    const std::array frames{box_at({0.0f, 0.0f, 0.0f}), box_at({3.0f, 0.0f, 0.0f})};
    const AnimationBounds bounds = make_animation_bounds(frames);
    EXPECT_EQ(bounds.in_place, (Aabb{{-1.0f, -1.0f, -1.0f}, {4.0f, 1.0f, 1.0f}}));
}

TEST(AnimatedBounds, InPlaceAFlightHasTheBoxOfTheFigure)
{
    const std::vector<glm::vec3> roots = flight();
    std::vector<Aabb> frames;
    for (const glm::vec3& root : roots) {
        frames.push_back(box_at(root));
    }
    EXPECT_EQ(make_animation_bounds(frames).in_place.extent().x, 12.0f);
    const AnimationBounds in_place = make_animation_bounds(frames, roots);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(in_place.in_place.extent()[axis], 2.0f, 1e-5f);
    }
    // The root translation of the current frame moves the box to the figure.
    const std::array playing{PlayingAnimation{in_place, roots[4]}};
    EXPECT_NEAR(blended_bounds(playing).center().x, 4.0f, 1e-5f);
    EXPECT_NEAR(blended_bounds(playing).center().y, 4.8f, 1e-5f);
}

TEST(AnimatedBounds, WhileBlendingTheUnionCounts)
{
    const std::array playing{
        PlayingAnimation{{box_at({0.0f, 0.0f, 0.0f})}, {0.0f, 0.0f, 0.0f}, 0.25f},
        PlayingAnimation{{box_at({0.0f, 2.0f, 0.0f})}, {8.0f, 0.0f, 0.0f}, 0.75f},
        PlayingAnimation{{box_at({99.0f, 0.0f, 0.0f})}, {50.0f, 0.0f, 0.0f}, 0.0f}};
    EXPECT_EQ(blended_root_translation(playing), (glm::vec3{6.0f, 0.0f, 0.0f}));
    EXPECT_EQ(blended_bounds(playing), (Aabb{{5.0f, -1.0f, -1.0f}, {7.0f, 3.0f, 1.0f}}));
    EXPECT_EQ(blended_bounds(playing, 0.5f), (Aabb{{4.5f, -1.5f, -1.5f}, {7.5f, 3.5f, 1.5f}}));
}

TEST(AnimatedBounds, EveryLinearBlendOfTwoPosesIsInTheBox)
{
    Rng rng{17};
    std::vector<glm::vec3> walk;
    std::vector<glm::vec3> jump;
    Aabb walk_box;
    Aabb jump_box;
    for (int i = 0; i < 50; ++i) {
        walk.push_back({rng.range(-1.0f, 1.0f), rng.range(0.0f, 2.0f), rng.range(-0.5f, 0.5f)});
        jump.push_back({rng.range(-2.0f, 0.5f), rng.range(1.0f, 3.0f), rng.range(-0.5f, 0.9f)});
        walk_box = merge(walk_box, {walk.back(), walk.back()});
        jump_box = merge(jump_box, {jump.back(), jump.back()});
    }
    for (const float share : {0.1f, 0.5f, 0.9f}) {
        const std::array playing{PlayingAnimation{{walk_box}, {1.0f, 0.0f, 0.0f}, 1.0f - share},
                                 PlayingAnimation{{jump_box}, {3.0f, 1.0f, 0.0f}, share}};
        const Aabb box = blended_bounds(playing, 1e-5f);
        for (size_t i = 0; i < walk.size(); ++i) {
            const glm::vec3 point = (1.0f - share) * (walk[i] + glm::vec3{1.0f, 0.0f, 0.0f}) +
                                    share * (jump[i] + glm::vec3{3.0f, 1.0f, 0.0f});
            ASSERT_TRUE(contains(box, {point, point}));
        }
    }
}

TEST(AnimatedBounds, NothingPlayingBoundsNothingAndTheUnknownStaysUnknown)
{
    EXPECT_TRUE(blended_bounds({}).is_empty());
    EXPECT_TRUE(make_animation_bounds({}).in_place.is_empty());
    const std::array unknown{PlayingAnimation{{Aabb::everything()}, {1.0f, 0.0f, 0.0f}}};
    EXPECT_EQ(blended_bounds(unknown), Aabb::everything());
}

} // namespace
} // namespace occlude
