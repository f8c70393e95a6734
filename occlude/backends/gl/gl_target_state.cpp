#include <occlude/backends/gl/detail/gl_target_state.h>

#include <occlude/screen/projection.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude {

namespace {

constexpr int kClipControlVersion = 45;

} // namespace

GlTargetState GlTargetState::read(int gl_version)
{
    GlTargetState state;
    std::array<GLint, 4> viewport{};
    glGetIntegerv(GL_VIEWPORT, viewport.data());
    state.viewport = {viewport[0], viewport[1], viewport[2], viewport[3]};
    std::array<GLfloat, 2> range{};
    glGetFloatv(GL_DEPTH_RANGE, range.data());
    state.depth_near = range[0];
    state.depth_far = range[1];
    glGetIntegerv(GL_SAMPLES, &state.samples);
    if (gl_version >= kClipControlVersion) {
        GLint origin = GL_LOWER_LEFT;
        GLint depth_mode = GL_NEGATIVE_ONE_TO_ONE;
        glGetIntegerv(GL_CLIP_ORIGIN, &origin);
        glGetIntegerv(GL_CLIP_DEPTH_MODE, &depth_mode);
        state.y_down = origin == GL_UPPER_LEFT;
        state.zero_to_one = depth_mode == GL_ZERO_TO_ONE;
    }
    return state;
}

PixelRect GlTargetState::in_framebuffer(const PixelRect& rect) const
{
    const int from_below = y_down ? viewport.height - rect.y - rect.height : rect.y;
    return {viewport.x + rect.x, viewport.y + from_below, rect.width, rect.height};
}

float GlTargetState::depth_extent() const
{
    return std::abs(depth_far - depth_near);
}

void GlTargetState::to_view_depth(DepthOrder order, std::span<float> depths) const
{
    const bool reversed = order == DepthOrder::near_is_large;
    if (depth_near == 0.0f && depth_far == 1.0f) {
        if (reversed) {
            std::ranges::transform(depths, depths.begin(), [](float d) { return 1.0f - d; });
        }
        return;
    }
    // The comparison allows for kDepthMargin, a number of steps of the whole depth buffer.
    const float scale = 1.0f / (depth_far - depth_near);
    const float margin = ScreenBounds::kDepthMargin * std::max(std::abs(scale) - 1.0f, 0.0f);
    std::ranges::transform(depths, depths.begin(), [&](float d) {
        const float along = (d - depth_near) * scale;
        return std::clamp((reversed ? 1.0f - along : along) + margin, 0.0f, 1.0f);
    });
}

} // namespace occlude
