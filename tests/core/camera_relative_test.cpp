// Views whose eye is kept in double, apart from the matrix.
#include <occlude/core/view.h>

#include "screen/projections.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::Projection;

constexpr glm::ivec2 kSize{1280, 720};

// The same camera, passed in both ways, gives the same frustum, keys and answers.
TEST(View, CameraRelativeIsTheSameCamera)
{
    Rng rng(71);
    for (const Projection& projection : test::all_projections()) {
        const glm::mat4 eye_from_world = test::random_eye_from_world(rng, 20.0f);
        const glm::dvec3 eye{glm::inverse(glm::dmat4{eye_from_world})[3]};
        const glm::mat4 turned{glm::mat3{eye_from_world}};
        const View absolute = View::from_clip(projection.clip_from_eye * eye_from_world, kSize,
                                              projection.convention);
        const View relative = View::camera_relative(projection.clip_from_eye * turned, eye, kSize,
                                                    projection.convention);
        EXPECT_EQ(relative.orthographic(), absolute.orthographic());
        for (int i = 0; i < 300; ++i) {
            const Aabb box = test::random_box(rng, 40.0f, 10.0f);
            const float key = absolute.distance_key(box);
            EXPECT_NEAR(relative.distance_key(box), key, 1e-3f * (1.0f + std::abs(key)));
            EXPECT_EQ(relative.frustum().classify(box), absolute.frustum().classify(box));
            EXPECT_EQ(relative.touches_near(box), absolute.touches_near(box));
            // Positions drawn in world coordinates round more.
            EXPECT_LE(relative.inflation().margin(box), absolute.inflation().margin(box) * 1.0001f);
        }
    }
}

// 1e7 units away, floats are 1 apart and the matrix to world coordinates moves the camera by as
// much. Relative to the eye, only the rounding of the boxes is left.
TEST(View, CameraRelativeKeepsItsPrecisionFarFromTheOrigin)
{
    const glm::dvec3 eye{1e7 + 0.25, -3e6 + 0.5, 2e6 - 0.125};
    const View view =
        View::camera_relative(glm::perspectiveRH_NO(1.0f, 1.5f, 0.1f, 100.0f), eye, kSize);
    const glm::vec3 ahead{eye + glm::dvec3{0.0, 0.0, -20.0}};
    const Aabb box{ahead - 1.0f, ahead + 1.0f};
    EXPECT_EQ(view.frustum().classify(box), Containment::inside);
    EXPECT_FALSE(view.touches_near(view.inflated_for_test(box)));
    EXPECT_LT(view.inflation().margin(box), 0.01f);
    const glm::vec3 beside{eye + glm::dvec3{40.0, 0.0, -20.0}};
    EXPECT_EQ(view.frustum().classify({beside - 1.0f, beside + 1.0f}), Containment::outside);
    // In world coordinates the same box would have to grow by more than its size.
    glm::dmat4 world{view.clip_from_relative()};
    world[3] = world * glm::dvec4{-eye, 1.0};
    EXPECT_GT(View::from_clip(glm::mat4{world}, kSize).inflation().margin(box), 10.0f);
}

// The eye lies between two floats there. Whether a box touches the near rectangle must not depend
// on the distance from zero. The same boxes and the same eye, 1e7 units nearer to zero, give the
// expected answer.
TEST(View, CameraRelativeKnowsTheNearRectangleFarFromTheOrigin)
{
    Rng rng(88);
    const glm::mat4 clip = glm::perspectiveRH_NO(1.0f, 1.5f, 2.0f, 100.0f);
    const glm::dvec3 far_away{1e7, -3e6, 2e6};
    int touching = 0;
    int free = 0;
    for (int i = 0; i < 4000; ++i) {
        const glm::dvec3 eye{rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f), rng.range(0.0f, 1.0f)};
        const glm::vec3 low{static_cast<float>(rng.below(7)) - 3.0f,
                            static_cast<float>(rng.below(7)) - 3.0f,
                            static_cast<float>(rng.below(7)) - 6.0f};
        const Aabb box{low, low + 1.0f};
        const Aabb far_box{glm::vec3{glm::dvec3{box.min} + far_away},
                           glm::vec3{glm::dvec3{box.max} + far_away}};
        const bool touches = View::camera_relative(clip, eye, kSize)
                                 .touches_near({box.min + 1e-3f, box.max - 1e-3f});
        const View far_view = View::camera_relative(clip, eye + far_away, kSize);
        touching += touches ? 1 : 0;
        free += far_view.touches_near(far_box) ? 0 : 1;
        ASSERT_TRUE(!touches || far_view.touches_near(far_box)) << "box " << i;
    }
    EXPECT_GT(touching, 100);
    EXPECT_GT(free, 1000);
}

} // namespace
} // namespace occlude
