#include "render/gl_lines.h"

namespace occlude::tools {

static constexpr size_t kFirstPoints = 4096; // initial capacity, in vertices

GlLines::GlLines()
    : vertices_(GlVertexArray::make())
    , points_(sizeof(glm::vec3), kFirstPoints)
{
    glBindVertexArray(vertices_.name());
    glBindBuffer(GL_ARRAY_BUFFER, points_.name());
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(glm::vec3), nullptr);
    glBindVertexArray(0);
}

void GlLines::draw(const GlProgram& program, std::span<const glm::vec3> points,
                   const glm::vec4& color)
{
    glUniform4fv(glGetUniformLocation(program.name(), "line_color"), 1, &color.x);
    glBindVertexArray(vertices_.name());
    const size_t offset = write_or_throw(points_, std::as_bytes(points));
    glDrawArrays(GL_LINES, static_cast<GLint>(offset / sizeof(glm::vec3)),
                 static_cast<GLsizei>(points.size()));
}

} // namespace occlude::tools
