// The test methods that draw boxes. `queries`: one occlusion query and one instanced draw per test.
// `raster`: one instanced draw for all boxes of a batch, whose fragments set the flag of their
// test.
#pragma once

#include <occlude/backends/gl/detail/gl_flag_batch.h>
#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/backends/gl/detail/gl_query_pool.h>
#include <occlude/backends/gl/detail/gl_target_state.h>
#include <occlude/core/query_device.h>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace occlude {

/// Draws the boxes of tests as instances of a cube, both sides of all faces, writing nothing.
class GlBoxTests {
public:
    /// `gl_version` (10 * major + minor) limits the features in use; `raster` needs kRasterVersion.
    /// `depth_bias`: how much nearer than they are boxes are tested, in window depth.
    static Result<std::unique_ptr<GlBoxTests>> create(int gl_version, float depth_bias);

    static constexpr int kBaseInstanceVersion = 42;
    static constexpr int kRasterVersion = 43;
    /// The index of GL_SHADER_STORAGE_BUFFER that raster() binds: the last one that always exists.
    static constexpr GLuint kFlagBinding = 7;

    bool can_raster() const { return raster_.program.name() != 0; }

    /// Sets the camera of the tests from now on, and its part of the target's depth.
    void set_view(const View& view, const GlTargetState& target);

    /// Sets all state that queries() or raster() needs: the one state change of a batch.
    void enter(TestMethod method);

    /// Issues one query per test, in order. A test gets an invalid ticket (lost) if the pool has no
    /// room for it, or if it has no box or an unbounded one. Returns false if the driver has no
    /// memory for the boxes; then all are lost. Precondition: enter() was called for this method
    /// after the last change of state by anybody else.
    bool queries(const QueryBatch& batch, GlQueryPool& pool, std::span<Ticket> tickets);

    /// The same with one draw. Answers count 1 sample or none. Precondition: can_raster().
    bool raster(const QueryBatch& batch, GlQueryPool& pool, std::span<Ticket> tickets);

private:
    // One box as the vertex shader reads it: its corners, and an affine matrix, row by row, to
    // positions relative to the view's origin.
    struct BoxRow {
        glm::vec3 min;
        glm::vec3 max;
        std::array<glm::vec4, 3> relative_from_box;
        float toward_viewer; // how much the box is moved nearer in clip z, for rounding
        uint32_t test;       // index of the flag that raster sets
    };
    static_assert(sizeof(BoxRow) == 80);

    // A program and the locations of its uniforms.
    struct Program {
        GlProgram program;
        GLint clip_from_relative = -1;
        GLint toward_viewer_per_w = -1;
        bool view_changed = true;

        explicit Program(GlProgram made);
        Program() = default;
    };

    GlBoxTests(Program queries, Program raster, bool base_instance, float depth_bias);
    float toward_viewer_sign() const;
    void add_row(const QueryBox& box, size_t test);
    std::optional<size_t> write_rows();
    void point_attributes_at(size_t offset);
    void draw(size_t first_offset, uint32_t first, uint32_t count);

    Program queries_;
    Program raster_; // no program if the OpenGL version is too old
    GlFlagBatches flags_;
    GlVertexArray vertex_array_;
    GlBuffer indices_;
    GlStreamBuffer stream_;
    std::vector<BoxRow> rows_;
    View view_;
    GlTargetState target_;
    float depth_bias_ = 0.0f;
    bool base_instance_ = false;
};

} // namespace occlude
