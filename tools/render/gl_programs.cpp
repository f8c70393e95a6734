#include "render/gl_programs.h"

#include "render/gl_shaders.h"

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <cmath>

namespace occlude::tools {

static constexpr float kSnapsPerPixel = 256.0f; // see kPosition in gl_shaders.h

// A light from above, oblique to the axes so that the faces of a box differ.
static glm::vec3 direction_toward_light(const glm::vec3& up)
{
    const glm::vec3 side = std::abs(up.x) < 0.5f ? glm::vec3{1, 0, 0} : glm::vec3{0, 0, 1};
    const glm::vec3 right = glm::normalize(glm::cross(side, up));
    const glm::vec3 forward = glm::cross(up, right);
    return glm::normalize(0.8f * glm::normalize(up) + 0.5f * right + 0.25f * forward);
}

Result<GlPrograms> make_programs(const glm::vec3& up)
{
    GlPrograms programs;
    struct Wanted {
        GlProgram& program;
        const char* name;
        const std::string& vertex;
        const std::string& fragment;
    };
    const std::array<Wanted, 4> all{
        {{programs.shade, "shade", shaders::kShadeVertex, shaders::kShadeFragment},
         {programs.depth, "depth", shaders::kDepthVertex, shaders::kDepthFragment},
         {programs.ids, "ids", shaders::kIdVertex, shaders::kIdFragment},
         {programs.lines, "lines", shaders::kLineVertex, shaders::kLineFragment}}};
    for (const Wanted& wanted : all) {
        Result<GlProgram> made = make_program(wanted.name, wanted.vertex, wanted.fragment);
        if (!made) {
            return made.error();
        }
        wanted.program = std::move(*made);
    }
    const glm::vec3 toward_light = direction_toward_light(up);
    glUseProgram(programs.shade.name());
    glUniform3fv(glGetUniformLocation(programs.shade.name(), "toward_light"), 1, &toward_light.x);
    return programs;
}

void use_camera(const GlProgram& program, const View& view)
{
    glUseProgram(program.name());
    const glm::mat4 clip_from_relative{view.clip_from_relative()};
    const glm::vec3 origin{view.origin()};
    const glm::vec3 origin_below{view.origin() - glm::dvec3{origin}};
    glUniformMatrix4fv(glGetUniformLocation(program.name(), "clip_from_relative"), 1, GL_FALSE,
                       glm::value_ptr(clip_from_relative));
    glUniform3fv(glGetUniformLocation(program.name(), "origin"), 1, &origin.x);
    glUniform3fv(glGetUniformLocation(program.name(), "origin_below"), 1, &origin_below.x);
    const glm::vec2 snaps = 0.5f * kSnapsPerPixel * glm::vec2{view.size_px()};
    glUniform2fv(glGetUniformLocation(program.name(), "snaps"), 1, &snaps.x);
}

} // namespace occlude::tools
