#include <occlude/backends/gl/detail/gl_saved_state.h>

namespace occlude {

namespace {

// In the order of GlSavedState::bindings_.
constexpr std::array<GLenum, 9> kBindingNames{
    GL_DRAW_FRAMEBUFFER_BINDING,  GL_READ_FRAMEBUFFER_BINDING,
    GL_CURRENT_PROGRAM,           GL_VERTEX_ARRAY_BINDING,
    GL_TEXTURE_BINDING_2D,        GL_TEXTURE_BINDING_2D_MULTISAMPLE, // of unit 0
    GL_SAMPLER_BINDING,                                              // likewise
    GL_PIXEL_PACK_BUFFER_BINDING, GL_PIXEL_UNPACK_BUFFER_BINDING};

constexpr std::array<GLenum, 4> kSwitchNames{GL_DEPTH_TEST, GL_STENCIL_TEST, GL_CULL_FACE,
                                             GL_SCISSOR_TEST};

constexpr std::array<GLenum, 6> kPackNames{GL_PACK_SWAP_BYTES,  GL_PACK_LSB_FIRST,
                                           GL_PACK_ROW_LENGTH,  GL_PACK_SKIP_ROWS,
                                           GL_PACK_SKIP_PIXELS, GL_PACK_ALIGNMENT};
constexpr std::array<GLint, 6> kPackDefaults{0, 0, 0, 0, 0, 4};

} // namespace

GlSavedState::GlSavedState()
{
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active_texture_);
    glActiveTexture(GL_TEXTURE0);
    for (size_t i = 0; i < kBindings; ++i) {
        glGetIntegerv(kBindingNames[i], &bindings_[i]);
    }
    for (size_t i = 0; i < kSwitches; ++i) {
        switches_[i] = glIsEnabled(kSwitchNames[i]);
    }
    for (size_t i = 0; i < kPackParameters; ++i) {
        glGetIntegerv(kPackNames[i], &pack_[i]);
        glPixelStorei(kPackNames[i], kPackDefaults[i]);
    }
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glGetIntegerv(GL_VIEWPORT, viewport_.data());
    glGetBooleani_v(GL_COLOR_WRITEMASK, 0, color_mask_.data());
    glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
    blend_ = glIsEnabledi(GL_BLEND, 0);
}

GlSavedState::~GlSavedState()
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, binding(0));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, binding(1));
    glUseProgram(binding(2));
    glBindVertexArray(binding(3));
    glBindTexture(GL_TEXTURE_2D, binding(4));
    glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, binding(5));
    glBindSampler(0, binding(6));
    glBindBuffer(GL_PIXEL_PACK_BUFFER, binding(7));
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, binding(8));
    for (size_t i = 0; i < kSwitches; ++i) {
        switches_[i] ? glEnable(kSwitchNames[i]) : glDisable(kSwitchNames[i]);
    }
    for (size_t i = 0; i < kPackParameters; ++i) {
        glPixelStorei(kPackNames[i], pack_[i]);
    }
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    glColorMaski(0, color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
    glDepthMask(depth_mask_);
    blend_ ? glEnablei(GL_BLEND, 0) : glDisablei(GL_BLEND, 0);
    glActiveTexture(static_cast<GLenum>(active_texture_));
}

} // namespace occlude
