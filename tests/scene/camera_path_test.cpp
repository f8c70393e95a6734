#include <occlude/scene/camera_path.h>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace occlude {
namespace {

Keyframe key(float time, const glm::vec3& eye, bool cut = false)
{
    Keyframe result;
    result.time = time;
    result.camera.eye = eye;
    result.camera.target = eye + glm::vec3{0.0f, 0.0f, -1.0f};
    result.cut = cut;
    return result;
}

TEST(CameraPath, BeginsAndEndsAtTheFirstAndLastKey)
{
    const std::vector<Keyframe> keys{key(0.0f, {0.0f, 0.0f, 0.0f}), key(1.0f, {3.0f, 1.0f, 0.0f}),
                                     key(4.0f, {5.0f, 0.0f, 2.0f})};
    const std::vector<Camera> frames = interpolate(keys, 9);
    ASSERT_EQ(frames.size(), 9u);
    EXPECT_EQ(frames.front().eye, keys.front().camera.eye);
    EXPECT_EQ(frames.back().eye, keys.back().camera.eye);
}

TEST(CameraPath, PassesThroughEveryKey)
{
    const std::vector<Keyframe> keys{key(0.0f, {0.0f, 0.0f, 0.0f}), key(1.0f, {3.0f, 1.0f, 0.0f}),
                                     key(2.0f, {5.0f, 0.0f, 2.0f}), key(4.0f, {9.0f, 0.0f, 0.0f})};
    const std::vector<Camera> frames = interpolate(keys, 5); // at 0, 1, 2, 3, 4
    EXPECT_LT(glm::distance(frames[1].eye, keys[1].camera.eye), 1e-5f);
    EXPECT_LT(glm::distance(frames[2].target, keys[2].camera.target), 1e-5f);
}

TEST(CameraPath, EvenlySpacedKeysOnALineGiveEvenMotion)
{
    std::vector<Keyframe> keys;
    for (int i = 0; i < 6; ++i) {
        keys.push_back(key(static_cast<float>(i), {2.0f * static_cast<float>(i), 0.0f, 0.0f}));
    }
    const std::vector<Camera> frames = interpolate(keys, 51);
    for (size_t i = 0; i < frames.size(); ++i) {
        EXPECT_NEAR(frames[i].eye.x, 0.2f * static_cast<float>(i), 1e-4f);
    }
}

TEST(CameraPath, IsSmoothAcrossKeys)
{
    const std::vector<Keyframe> keys{key(0.0f, {0.0f, 0.0f, 0.0f}), key(1.0f, {4.0f, 0.0f, 0.0f}),
                                     key(3.0f, {4.0f, 0.0f, 6.0f}), key(4.0f, {0.0f, 0.0f, 6.0f})};
    const std::vector<Camera> frames = interpolate(keys, 4001);
    float largest_change = 0.0f; // of the step from frame to frame
    for (size_t i = 2; i < frames.size(); ++i) {
        const glm::vec3 now = frames[i].eye - frames[i - 1].eye;
        const glm::vec3 before = frames[i - 1].eye - frames[i - 2].eye;
        largest_change = std::max(largest_change, glm::length(now - before));
    }
    EXPECT_LT(largest_change, 1e-4f) << "the velocity should not jump";
}

TEST(CameraPath, FramesBeforeACutStayWithTheKeyBefore)
{
    const std::vector<Keyframe> keys{key(0.0f, {0.0f, 0.0f, 0.0f}), key(1.0f, {1.0f, 0.0f, 0.0f}),
                                     key(2.0f, {100.0f, 0.0f, 0.0f}, true),
                                     key(3.0f, {101.0f, 0.0f, 0.0f})};
    const std::vector<Camera> frames = interpolate(keys, 31); // a tenth of a second apart
    for (size_t i = 0; i < 31; ++i) {
        if (i < 20) {
            EXPECT_LE(frames[i].eye.x, 1.0001f) << i;
        } else {
            EXPECT_GE(frames[i].eye.x, 99.9999f) << i;
        }
    }
    EXPECT_EQ(frames[15].eye, keys[1].camera.eye);
    EXPECT_EQ(frames[20].eye, keys[2].camera.eye);
}

TEST(CameraPath, OneKeyStandsStill)
{
    const std::vector<Keyframe> keys{key(7.0f, {1.0f, 2.0f, 3.0f})};
    for (const Camera& camera : interpolate(keys, 4)) {
        EXPECT_EQ(camera.eye, keys[0].camera.eye);
    }
    EXPECT_EQ(interpolate(keys, 4).size(), 4u);
    EXPECT_EQ(interpolate(keys, 1).size(), 1u);
    EXPECT_TRUE(interpolate(keys, 0).empty());
}

TEST(CameraPath, ADepthRangeThatIsLeftOpenStaysOpen)
{
    std::vector<Keyframe> keys{key(0.0f, {0.0f, 0.0f, 0.0f}), key(1.0f, {1.0f, 0.0f, 0.0f})};
    for (const Camera& camera : interpolate(keys, 5)) {
        EXPECT_EQ(camera.near, 0.0f);
        EXPECT_EQ(camera.far, 0.0f);
    }
}

Camera looking_down_z()
{
    Camera camera;
    camera.eye = {1.0f, 2.0f, 3.0f};
    camera.target = {1.0f, 2.0f, -10.0f};
    camera.near = 0.5f;
    camera.far = 100.0f;
    return camera;
}

float depth_at(const View& view, float z)
{
    const glm::vec4 clip = view.clip_from_world() * glm::vec4{1.0f, 2.0f, z, 1.0f};
    return clip.z / clip.w;
}

TEST(MakeView, DepthRunsFromNearToFarInEveryConvention)
{
    const Camera camera = looking_down_z();
    const glm::ivec2 size{640, 360};
    const View gl = make_view(camera, size, {});
    EXPECT_NEAR(depth_at(gl, 2.5f), -1.0f, 1e-4f);
    EXPECT_NEAR(depth_at(gl, -97.0f), 1.0f, 1e-4f);
    const View d3d = make_view(camera, size, {DepthRange::zero_to_one, DepthOrder::near_is_small});
    EXPECT_NEAR(depth_at(d3d, 2.5f), 0.0f, 1e-4f);
    EXPECT_NEAR(depth_at(d3d, -97.0f), 1.0f, 1e-4f);
    const View reversed =
        make_view(camera, size, {DepthRange::zero_to_one, DepthOrder::near_is_large});
    EXPECT_NEAR(depth_at(reversed, 2.5f), 1.0f, 1e-4f);
    EXPECT_NEAR(depth_at(reversed, -97.0f), 0.0f, 1e-4f);
}

TEST(MakeView, KeepsEyeSizeAndConvention)
{
    const ClipConvention convention{DepthRange::zero_to_one, DepthOrder::near_is_large};
    const View view = make_view(looking_down_z(), {641, 359}, convention);
    EXPECT_LT(glm::distance(view.eye(), glm::vec3{1.0f, 2.0f, 3.0f}), 1e-3f);
    EXPECT_EQ(view.size_px(), glm::ivec2(641, 359));
    EXPECT_EQ(view.convention(), convention);
}

TEST(MakeView, RightIsRightAndUpIsUp)
{
    const View view = make_view(looking_down_z(), {640, 360});
    const glm::vec4 right = view.clip_from_world() * glm::vec4{2.0f, 2.0f, -5.0f, 1.0f};
    const glm::vec4 above = view.clip_from_world() * glm::vec4{1.0f, 3.0f, -5.0f, 1.0f};
    EXPECT_GT(right.x, 0.0f);
    EXPECT_NEAR(right.y, 0.0f, 1e-4f);
    EXPECT_GT(above.y, 0.0f);
    EXPECT_NEAR(above.x, 0.0f, 1e-4f);
}

// 1e6 units away, float cannot place a point one unit before the eye precisely enough.
TEST(MakeView, LooksWhereItShouldFarFromTheOrigin)
{
    Camera camera = looking_down_z();
    camera.eye = {1e6f, -2e6f, 5e6f};
    camera.target = camera.eye + glm::vec3{300.0f, 100.0f, -700.0f};
    const glm::dvec3 along = glm::normalize(glm::dvec3{camera.target} - glm::dvec3{camera.eye});
    const View view = make_view(camera, {640, 360});
    EXPECT_EQ(view.origin(), glm::dvec3{camera.eye});
    const glm::dvec4 clip = view.clip_from_relative() * glm::dvec4{10.0 * along, 1.0};
    EXPECT_NEAR(clip.x / clip.w, 0.0, 1e-6);
    EXPECT_NEAR(clip.y / clip.w, 0.0, 1e-6);
    EXPECT_NEAR(clip.w, 10.0, 1e-5);
}

TEST(MakeView, AnUpVectorAlongTheViewIsReplaced)
{
    const glm::vec3 axes[]{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
    for (const glm::vec3& axis : axes) {
        for (float sign : {-1.0f, 1.0f}) {
            Camera camera = looking_down_z();
            camera.target = camera.eye + sign * axis;
            camera.up = axis;
            const View view = make_view(camera, {640, 360});
            EXPECT_FALSE(view.orthographic());
            const glm::vec3 ahead = camera.eye + 10.0f * sign * axis;
            const Aabb in_view{ahead - 0.1f, ahead + 0.1f};
            const Aabb behind{ahead - 20.0f * sign * axis - 0.1f,
                              ahead - 20.0f * sign * axis + 0.1f};
            EXPECT_EQ(view.frustum().classify(in_view), Containment::inside);
            EXPECT_EQ(view.frustum().classify(behind), Containment::outside);
        }
    }
}

} // namespace
} // namespace occlude
