// The place of a frame's view in the bound framebuffer, as the engine has set it.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/query_device.h>

#include <span>

namespace occlude {

struct GlTargetState {
    PixelRect viewport;      ///< in the framebuffer, from its lower left
    float depth_near = 0.0f; ///< glDepthRange
    float depth_far = 1.0f;
    int samples = 0; ///< 0 or 1: not multisampled
    bool y_down =
        false; ///< glClipControl(GL_UPPER_LEFT): the view's bottom row is the top one here
    bool zero_to_one = false; ///< glClipControl(..., GL_ZERO_TO_ONE)

    /// Queries OpenGL. `gl_version` is 10 * major + minor.
    static GlTargetState read(int gl_version);

    /// The place of a rectangle of the view in the framebuffer. If y_down, its rows are in reverse
    /// order there.
    PixelRect in_framebuffer(const PixelRect& rect) const;

    /// True if nearer fragments have greater values in the depth buffer.
    bool near_is_large(DepthOrder order) const
    {
        return (order == DepthOrder::near_is_large) != (depth_near > depth_far);
    }

    /// The part of the values of the depth buffer that the view uses.
    float depth_extent() const;

    /// Converts values of the depth buffer to window depth of the view, 0 near to 1 far. If the
    /// view has only a part of the depth buffer, the buffer's steps are larger for the view; then
    /// rounds toward far by one such step. Precondition: depth_extent() > 0.
    void to_view_depth(DepthOrder order, std::span<float> depths) const;
};

} // namespace occlude
