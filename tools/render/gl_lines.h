// Lines in the world, streamed to the graphics card.
#pragma once

#include "render/gl_geometry.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <span>

namespace occlude::tools {

class GlLines {
public:
    /// Needs a current context.
    GlLines();

    /// Draws a line between points 0 and 1, 2 and 3, and so on. Precondition: `program` is bound,
    /// its camera is set, and depth tests are as the caller wants them. Binds a vertex array.
    void draw(const GlProgram& program, std::span<const glm::vec3> points, const glm::vec4& color);

private:
    GlVertexArray vertices_;
    GlStreamBuffer points_;
};

} // namespace occlude::tools
