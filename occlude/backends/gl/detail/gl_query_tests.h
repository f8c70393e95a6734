// The test method `queries`: one occlusion query and one instanced draw per test.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/backends/gl/detail/gl_query_pool.h>
#include <occlude/core/query_device.h>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace occlude::gl {

/// Draws the boxes of tests as instances of a cube, both sides of all faces, writing nothing.
class GlQueryTests {
public:
    /// `base_instance`: glDrawElementsInstancedBaseInstance may be used (OpenGL 4.2).
    /// `depth_bias`: how much nearer than they are boxes are tested, in window depth.
    static Result<std::unique_ptr<GlQueryTests>> create(bool base_instance, float depth_bias);

    /// The camera of the tests from now on.
    void set_view(const View& view);

    /// Sets all state that run() needs: the one state change of a batch.
    void enter();

    /// Issues one query per test, in order. A test that the pool has no room for, that has no box
    /// or that has an unbounded one gets an invalid ticket: lost. Precondition: enter() was called
    /// after the last change of state by anybody else.
    void run(const QueryBatch& batch, GlQueryPool& pool, std::span<Ticket> tickets);

private:
    // One box as the vertex shader reads it: its corners, and an affine matrix row by row.
    struct BoxRow {
        glm::vec3 min;
        glm::vec3 max;
        std::array<glm::vec4, 3> world_from_box;
    };
    static_assert(sizeof(BoxRow) == 72);

    GlQueryTests(GlProgram program, bool base_instance, float depth_bias);
    void point_attributes_at(size_t offset);
    void draw(size_t first_offset, uint32_t first, uint32_t count);

    GlProgram program_;
    GlVertexArray vertex_array_;
    GlBuffer indices_;
    GlStreamBuffer stream_;
    std::vector<BoxRow> rows_;
    GLint clip_from_world_ = -1;
    GLint toward_viewer_ = -1;
    View view_;
    float depth_bias_ = 0.0f;
    bool base_instance_ = false;
    bool view_changed_ = true;
};

} // namespace occlude::gl
