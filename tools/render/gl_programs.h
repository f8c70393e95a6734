// The renderer's shader programs, and the camera that they share.
#pragma once

#include <occlude/backends/gl/detail/gl_object.h>
#include <occlude/core/result.h>
#include <occlude/core/view.h>

#include <glm/vec3.hpp>

namespace occlude::tools {

struct GlPrograms {
    GlProgram shade;
    GlProgram depth;
    GlProgram ids;
    GlProgram lines;
};

/// The programs for a scene whose upward direction is `up`, which is where its light comes from.
/// Errors of the shader compiler name the program. Needs a current context.
Result<GlPrograms> make_programs(const glm::vec3& up);

/// Binds `program` and sets its camera.
void use_camera(const GlProgram& program, const View& view);

} // namespace occlude::tools
