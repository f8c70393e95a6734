// Saves the engine's state that reading depth changes, and restores it in the destructor.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>

#include <array>
#include <cstddef>

namespace occlude {

class GlSavedState {
public:
    /// Saves the state, and sets the defaults of pixel transfers.
    GlSavedState();
    ~GlSavedState();
    GlSavedState(const GlSavedState&) = delete;
    GlSavedState& operator=(const GlSavedState&) = delete;

    /// The framebuffer that was bound to GL_DRAW_FRAMEBUFFER.
    GLuint draw_framebuffer() const { return binding(0); }

private:
    static constexpr size_t kBindings = 9;
    static constexpr size_t kSwitches = 4;
    static constexpr size_t kPackParameters = 6;

    GLuint binding(size_t i) const { return static_cast<GLuint>(bindings_[i]); }

    std::array<GLint, kBindings> bindings_{};
    std::array<GLboolean, kSwitches> switches_{};
    std::array<GLint, kPackParameters> pack_{};
    std::array<GLint, 4> viewport_{};
    std::array<GLboolean, 4> color_mask_{};
    GLboolean depth_mask_ = GL_TRUE;
    GLboolean blend_ = GL_FALSE;
    GLint active_texture_ = GL_TEXTURE0;
};

} // namespace occlude
