// The OpenGL state that tests of a GlDevice need or change, beside osg::State, which knows nothing
// of it: read before, put back after.
#pragma once

#include <osg/GL>
#include <osg/State>

#include <array>

namespace occlude {

class SavedGlState {
public:
    /// Reads the state. Some thirty questions to the driver.
    void read(osg::State& state);

    /// Sets what tests need and the engine may have set otherwise (docs/devices.md), and what the
    /// fixed pipeline of a compatibility context adds: alpha test, polygon stipple.
    void set_for_tests(osg::State& state, const std::array<GLint, 4>& viewport) const;

    /// Sets everything again as it was read.
    void put_back(osg::State& state) const;

private:
    static constexpr size_t kModes = 18;

    std::array<GLboolean, kModes> modes_{};
    std::array<GLint, 2> polygon_mode_{};
    std::array<GLint, 4> scissor_{};
    std::array<GLint, 4> viewport_{};
    std::array<GLfloat, 2> depth_range_{};
    std::array<GLboolean, 4> color_mask_{};
    GLboolean depth_mask_ = GL_TRUE;
    GLint depth_function_ = GL_LESS;
    GLint program_ = 0;
    GLint vertex_array_ = 0;
    GLint array_buffer_ = 0;
    GLint storage_buffer_ = 0;
};

} // namespace occlude
