#include "saved_gl_state.h"

#include <epoxy/gl.h>

namespace occlude {

namespace {

struct Mode {
    GLenum name;
    bool fixed_pipeline; ///< not in a core context
    bool for_tests;      ///< must be off in tests; the others are the device's to set
};

constexpr std::array<Mode, 18> kModeTable{{
    {GL_DEPTH_TEST, false, false},
    {GL_DEPTH_CLAMP, false, false},
    {GL_CULL_FACE, false, false},
    {GL_SCISSOR_TEST, false, false},
    {GL_STENCIL_TEST, false, true},
    {GL_POLYGON_OFFSET_FILL, false, true},
    {GL_SAMPLE_ALPHA_TO_COVERAGE, false, true},
    {GL_SAMPLE_COVERAGE, false, true},
    {GL_COLOR_LOGIC_OP, false, true},
    {GL_PRIMITIVE_RESTART, false, true},
    {GL_CLIP_DISTANCE0, false, true}, // the number of GL_CLIP_PLANE0, and so on
    {GL_CLIP_DISTANCE1, false, true},
    {GL_CLIP_DISTANCE2, false, true},
    {GL_CLIP_DISTANCE3, false, true},
    {GL_CLIP_DISTANCE4, false, true},
    {GL_CLIP_DISTANCE5, false, true},
    {GL_ALPHA_TEST, true, true},
    {GL_POLYGON_STIPPLE, true, true},
}};

constexpr int kStorageBufferVersion = 43;

bool is_core_context()
{
    GLint mask = 0;
    glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &mask);
    return (mask & GL_CONTEXT_CORE_PROFILE_BIT) != 0;
}

void set_mode(GLenum mode, bool on)
{
    on ? glEnable(mode) : glDisable(mode);
}

} // namespace

void SavedGlState::read()
{
    const bool core = is_core_context();
    for (size_t i = 0; i < kModes; ++i) {
        const bool there = !(core && kModeTable[i].fixed_pipeline);
        modes_[i] = there && glIsEnabled(kModeTable[i].name) == GL_TRUE;
    }
    glGetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
    if (polygon_mode_[1] == 0) {
        polygon_mode_[1] = polygon_mode_[0]; // some core drivers return one
    }
    glGetIntegerv(GL_SCISSOR_BOX, scissor_.data());
    glGetIntegerv(GL_VIEWPORT, viewport_.data());
    glGetFloatv(GL_DEPTH_RANGE, depth_range_.data());
    glGetBooleanv(GL_COLOR_WRITEMASK, color_mask_.data());
    glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
    glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
    glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
    glGetIntegerv(GL_ARRAY_BUFFER_BINDING, &array_buffer_);
    has_storage_buffers_ = epoxy_gl_version() >= kStorageBufferVersion;
    if (has_storage_buffers_) {
        glGetIntegerv(GL_SHADER_STORAGE_BUFFER_BINDING, &storage_buffer_);
    }
}

void SavedGlState::set_for_tests(const std::array<int, 4>& viewport) const
{
    for (size_t i = 0; i < kModes; ++i) {
        if (kModeTable[i].for_tests && modes_[i]) {
            glDisable(kModeTable[i].name);
        }
    }
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glDepthRange(0.0, 1.0);
    glViewport(viewport[0], viewport[1], viewport[2], viewport[3]);
    glScissor(viewport[0], viewport[1], viewport[2], viewport[3]);
}

void SavedGlState::put_back() const
{
    for (size_t i = 0; i < kModes; ++i) {
        if (!kModeTable[i].for_tests || modes_[i]) {
            set_mode(kModeTable[i].name, modes_[i]);
        }
    }
    if (polygon_mode_[0] == polygon_mode_[1]) {
        glPolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygon_mode_[0]));
    } else {
        glPolygonMode(GL_FRONT, static_cast<GLenum>(polygon_mode_[0]));
        glPolygonMode(GL_BACK, static_cast<GLenum>(polygon_mode_[1]));
    }
    glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    glDepthRange(static_cast<double>(depth_range_[0]), static_cast<double>(depth_range_[1]));
    glColorMask(color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
    glDepthMask(depth_mask_);
    glDepthFunc(static_cast<GLenum>(depth_function_));
    glUseProgram(static_cast<GLuint>(program_));
    glBindVertexArray(static_cast<GLuint>(vertex_array_));
    glBindBuffer(GL_ARRAY_BUFFER, static_cast<GLuint>(array_buffer_));
    if (has_storage_buffers_) {
        glBindBuffer(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(storage_buffer_));
    }
}

} // namespace occlude
