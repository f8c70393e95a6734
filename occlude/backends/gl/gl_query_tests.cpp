#include <occlude/backends/gl/detail/gl_query_tests.h>

#include <occlude/core/assert.h>

#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cstddef>

namespace occlude::gl {

namespace {

constexpr size_t kFirstCapacity = 4096; // boxes, 288 KiB

// Corner i of the cube is at (i & 1, i >> 1 & 1, i >> 2). Both sides are drawn, so winding is free.
constexpr std::array<uint16_t, 36> kCubeIndices{0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6,
                                                0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6,
                                                0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};

// World space first, then clip space: the order in which geometry is transformed, too.
constexpr const char* kVertexShader = R"(#version 330 core
layout(location = 0) in vec3 box_min;
layout(location = 1) in vec3 box_max;
layout(location = 2) in vec4 world_row_0;
layout(location = 3) in vec4 world_row_1;
layout(location = 4) in vec4 world_row_2;
uniform mat4 clip_from_world;
uniform float toward_viewer; // added to normalised depth
invariant gl_Position;

void main()
{
    bvec3 upper = bvec3((gl_VertexID & 1) != 0, (gl_VertexID & 2) != 0, (gl_VertexID & 4) != 0);
    vec4 corner = vec4(mix(box_min, box_max, upper), 1.0);
    vec3 world = vec3(dot(world_row_0, corner), dot(world_row_1, corner), dot(world_row_2, corner));
    gl_Position = clip_from_world * vec4(world, 1.0);
    gl_Position.z += toward_viewer * gl_Position.w;
}
)";

constexpr const char* kFragmentShader = R"(#version 330 core
void main() {}
)";

bool can_be_tested(std::span<const QueryBox> boxes)
{
    return !boxes.empty() && std::all_of(boxes.begin(), boxes.end(),
                                         [](const QueryBox& box) { return box.box.is_bounded(); });
}

} // namespace

Result<std::unique_ptr<GlQueryTests>> GlQueryTests::create(bool base_instance, float depth_bias)
{
    Result<GlProgram> program = make_program("occlude box tests", kVertexShader, kFragmentShader);
    if (!program) {
        return program.error();
    }
    return std::unique_ptr<GlQueryTests>(
        new GlQueryTests(std::move(*program), base_instance, depth_bias));
}

GlQueryTests::GlQueryTests(GlProgram program, bool base_instance, float depth_bias)
    : program_(std::move(program))
    , vertex_array_(GlVertexArray::make())
    , indices_(GlBuffer::make())
    , stream_(sizeof(BoxRow), kFirstCapacity)
    , clip_from_world_(glGetUniformLocation(program_.name(), "clip_from_world"))
    , toward_viewer_(glGetUniformLocation(program_.name(), "toward_viewer"))
    , depth_bias_(depth_bias)
    , base_instance_(base_instance)
{
    glBindVertexArray(vertex_array_.name());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof(kCubeIndices), kCubeIndices.data(),
                 GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, stream_.name());
    point_attributes_at(0);
    for (GLuint location = 0; location < 5; ++location) {
        glEnableVertexAttribArray(location);
        glVertexAttribDivisor(location, 1);
    }
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
}

// Box rows from byte `offset` of the stream on. Precondition: vertex array and stream are bound.
void GlQueryTests::point_attributes_at(size_t offset)
{
    const auto point = [offset](GLuint location, GLint size, size_t member) {
        glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(BoxRow),
                              reinterpret_cast<const void*>(offset + member));
    };
    point(0, 3, offsetof(BoxRow, min));
    point(1, 3, offsetof(BoxRow, max));
    for (GLuint row = 0; row < 3; ++row) {
        point(2 + row, 4, offsetof(BoxRow, world_from_box) + row * sizeof(glm::vec4));
    }
}

void GlQueryTests::set_view(const View& view)
{
    view_ = view;
    view_changed_ = true;
}

void GlQueryTests::enter()
{
    const ClipConvention convention = view_.convention();
    const bool reversed = convention.order == DepthOrder::near_is_large;
    glUseProgram(program_.name());
    if (view_changed_) {
        const float range = convention.range == DepthRange::minus_one_to_one ? 2.0f : 1.0f;
        glUniformMatrix4fv(clip_from_world_, 1, GL_FALSE, glm::value_ptr(view_.clip_from_world()));
        glUniform1f(toward_viewer_, (reversed ? 1.0f : -1.0f) * range * depth_bias_);
        view_changed_ = false;
    }
    glBindVertexArray(vertex_array_.name());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDepthMask(GL_FALSE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(reversed ? GL_GEQUAL : GL_LEQUAL);
    glEnable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
}

void GlQueryTests::run(const QueryBatch& batch, GlQueryPool& pool, std::span<Ticket> tickets)
{
    rows_.clear();
    for (const QueryBox& box : batch.boxes) {
        const glm::mat4 world = box.world_from_box ? *box.world_from_box : glm::mat4{1.0f};
        rows_.push_back({box.box.min,
                         box.box.max,
                         {glm::row(world, 0), glm::row(world, 1), glm::row(world, 2)}});
    }
    const size_t offset = stream_.write(std::as_bytes(std::span<const BoxRow>(rows_)));

    uint32_t begin = 0;
    for (size_t test = 0; test < batch.test_ends.size(); ++test) {
        const uint32_t end = batch.test_ends[test];
        OCCLUDE_ASSERT(begin < end && end <= batch.boxes.size(), "C6: a test has no box");
        tickets[test] = Ticket{};
        if (can_be_tested(batch.boxes.subspan(begin, end - begin))) {
            tickets[test] = pool.begin();
        }
        if (tickets[test].valid()) {
            draw(offset, begin, end - begin);
            pool.end();
        }
        begin = end;
    }
}

// Draws boxes [first, first + count) of the rows at byte `first_offset` of the stream.
void GlQueryTests::draw(size_t first_offset, uint32_t first, uint32_t count)
{
    constexpr GLsizei kIndexCount = static_cast<GLsizei>(kCubeIndices.size());
    if (base_instance_) {
        const auto base = static_cast<GLuint>(first_offset / sizeof(BoxRow)) + first;
        glDrawElementsInstancedBaseInstance(GL_TRIANGLES, kIndexCount, GL_UNSIGNED_SHORT, nullptr,
                                            static_cast<GLsizei>(count), base);
        return;
    }
    point_attributes_at(first_offset + first * sizeof(BoxRow));
    glDrawElementsInstanced(GL_TRIANGLES, kIndexCount, GL_UNSIGNED_SHORT, nullptr,
                            static_cast<GLsizei>(count));
}

} // namespace occlude::gl
