#include "renderer.h"

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace gl_engine {

namespace {

constexpr int kSlices = 16; // of a sphere, and half as many stacks
constexpr int kCubeVertices = 36;
constexpr int kSphereVertices = 6 * kSlices * (kSlices / 2);

constexpr std::array<glm::vec3, Town::kMaterials> kColors{
    {{0.80f, 0.74f, 0.62f}, {0.62f, 0.66f, 0.72f}, {0.85f, 0.30f, 0.22f}, {0.34f, 0.38f, 0.34f}}};

constexpr const char* kVertexShader = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 0) uniform mat4 clip_from_world;
layout(location = 1) uniform mat4 clip_from_light;
layout(location = 2) uniform mat4 world_from_mesh;
invariant gl_Position;
out vec3 world;
out vec4 light;
void main()
{
    world = (world_from_mesh * vec4(position, 1.0)).xyz;
    gl_Position = clip_from_world * vec4(world, 1.0);
    light = clip_from_light * vec4(world, 1.0);
})";

constexpr const char* kFragmentShader = R"(#version 450 core
layout(location = 3) uniform vec3 color;
layout(binding = 0) uniform sampler2DShadow shadow_map;
in vec3 world;
in vec4 light;
layout(location = 0) out vec4 result;
void main()
{
    vec3 normal = normalize(cross(dFdx(world), dFdy(world)));
    vec3 at = light.xyz / light.w;
    float lit = texture(shadow_map, vec3(at.xy * 0.5 + 0.5, at.z + 0.004));
    float diffuse = max(dot(normal, normalize(vec3(0.4, 0.8, 0.3))), 0.0) * lit;
    result = vec4(color * (0.35 + 0.65 * diffuse), 1.0);
})";

GLuint compile(GLenum stage, const char* source)
{
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_FALSE) {
        std::array<char, 1024> log{};
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
        std::fprintf(stderr, "gl_engine: %s\n", log.data());
    }
    return shader;
}

GLuint link(const char* vertex, const char* fragment)
{
    const GLuint program = glCreateProgram();
    glAttachShader(program, compile(GL_VERTEX_SHADER, vertex));
    glAttachShader(program, compile(GL_FRAGMENT_SHADER, fragment));
    glLinkProgram(program);
    return program;
}

void add_cube(std::vector<glm::vec3>& vertices)
{
    constexpr std::array<int, kCubeVertices> kCorners{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6,
                                                      0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7,
                                                      0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    for (const int corner : kCorners) {
        vertices.push_back(glm::vec3{corner & 1, (corner >> 1) & 1, corner >> 2} - glm::vec3{0.5f});
    }
}

void add_sphere(std::vector<glm::vec3>& vertices)
{
    constexpr float kPi = 3.14159265f;
    const auto point = [](int slice, int stack) {
        const float around = 2.0f * kPi * static_cast<float>(slice) / kSlices;
        const float down = kPi * static_cast<float>(stack) / (kSlices / 2);
        return 0.499f * glm::vec3{std::sin(down) * std::cos(around), std::cos(down),
                                  std::sin(down) * std::sin(around)};
    };
    for (int stack = 0; stack < kSlices / 2; ++stack) {
        for (int slice = 0; slice < kSlices; ++slice) {
            const glm::vec3 a = point(slice, stack);
            const glm::vec3 b = point(slice + 1, stack);
            const glm::vec3 c = point(slice, stack + 1);
            const glm::vec3 d = point(slice + 1, stack + 1);
            vertices.insert(vertices.end(), {a, b, c, b, d, c});
        }
    }
}

} // namespace

uint32_t triangle_count(Draw::Mesh mesh)
{
    return (mesh == Draw::Mesh::cube ? kCubeVertices : kSphereVertices) / 3;
}

Renderer::Renderer(const Town& town, glm::ivec2 size_px)
    : town_(town)
    , size_px_(size_px)
{
    create_objects();
}

void Renderer::create_objects()
{
    program_ = link(kVertexShader, kFragmentShader);
    std::vector<glm::vec3> vertices;
    add_cube(vertices);
    add_sphere(vertices);
    GLuint buffer = 0;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, static_cast<GLsizeiptr>(vertices.size() * sizeof(glm::vec3)),
                         vertices.data(), 0);
    glCreateVertexArrays(1, &vertex_array_);
    glVertexArrayVertexBuffer(vertex_array_, 0, buffer, 0, sizeof(glm::vec3));
    glVertexArrayAttribFormat(vertex_array_, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glEnableVertexArrayAttrib(vertex_array_, 0);

    std::array<GLuint, 2> attachments{};
    glCreateRenderbuffers(2, attachments.data());
    glNamedRenderbufferStorageMultisample(attachments[0], kSamples, GL_RGBA8, size_px_.x,
                                          size_px_.y);
    glNamedRenderbufferStorageMultisample(attachments[1], kSamples, GL_DEPTH_COMPONENT32F,
                                          size_px_.x, size_px_.y);
    glCreateFramebuffers(1, &target_);
    glNamedFramebufferRenderbuffer(target_, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, attachments[0]);
    glNamedFramebufferRenderbuffer(target_, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, attachments[1]);

    glCreateTextures(GL_TEXTURE_2D, 1, &shadow_map_);
    glTextureStorage2D(shadow_map_, 1, GL_DEPTH_COMPONENT32F, kShadowSize, kShadowSize);
    glTextureParameteri(shadow_map_, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTextureParameteri(shadow_map_, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL); // reversed Z
    glCreateFramebuffers(1, &shadow_target_);
    glNamedFramebufferTexture(shadow_target_, GL_DEPTH_ATTACHMENT, shadow_map_, 0);
    glNamedFramebufferDrawBuffer(shadow_target_, GL_NONE);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glClearDepth(0.0);
}

void Renderer::set_camera(const glm::mat4& clip_from_world, const glm::mat4& clip_from_light) const
{
    glUseProgram(program_);
    glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(clip_from_world));
    glUniformMatrix4fv(1, 1, GL_FALSE, glm::value_ptr(clip_from_light));
    glBindVertexArray(vertex_array_);
}

// Keeps the engine's own order by state: the library passes a batch without an order.
void Renderer::draw_sorted(std::span<const occlude::ItemId> items)
{
    order_.clear();
    for (const occlude::ItemId item : items) {
        const Draw& draw = town_.draws()[item.value];
        order_.push_back(uint64_t{draw.material} << 40 |
                         uint64_t{static_cast<uint8_t>(draw.mesh)} << 32 | item.value);
    }
    std::ranges::sort(order_);
    uint32_t material = Town::kMaterials;
    for (const uint64_t key : order_) {
        const Draw& draw = town_.draws()[key & 0xffffffffu];
        if (draw.material != material) {
            material = draw.material;
            glUniform3fv(3, 1, glm::value_ptr(kColors[material]));
        }
        glUniformMatrix4fv(2, 1, GL_FALSE, glm::value_ptr(draw.world_from_mesh));
        const bool cube = draw.mesh == Draw::Mesh::cube;
        glDrawArrays(GL_TRIANGLES, cube ? 0 : kCubeVertices,
                     cube ? kCubeVertices : kSphereVertices);
    }
}

void Renderer::present(GLuint framebuffer)
{
    glBlitNamedFramebuffer(target_, framebuffer, 0, 0, size_px_.x, size_px_.y, 0, 0, size_px_.x,
                           size_px_.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void CameraPass::begin_frame(const occlude::View&)
{
    glBindFramebuffer(GL_FRAMEBUFFER, renderer_.target_);
    const glm::ivec2 size = renderer_.size_px_;
    const bool smaller = bug_ == Bug::dynamic_resolution && frame >= 2;
    glViewport(0, 0, smaller ? 2 * size.x / 3 : size.x, smaller ? 2 * size.y / 3 : size.y);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_POLYGON_OFFSET_FILL); // the shadow pass leaves it on
    glBindTextureUnit(0, renderer_.shadow_map_);
    restore_state();
    glClearColor(0.55f, 0.68f, 0.82f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void CameraPass::draw(std::span<const occlude::ItemId> items, occlude::DrawPass)
{
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glDisable(GL_SCISSOR_TEST);
    renderer_.draw_sorted(items);
    leave_something_on();
}

// docs/devices.md, "State that tests change", lists what restore_state() must set.
void CameraPass::restore_state()
{
    renderer_.set_camera(clip_from_world, clip_from_light);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDisable(GL_DEPTH_CLAMP);
    glEnable(GL_CULL_FACE);
}

void CameraPass::leave_something_on()
{
    const glm::ivec2 size = renderer_.size_px_;
    switch (bug_) {
    case Bug::query_left_open:
        if (query_ == 0) {
            glGenQueries(1, &query_);
            glBeginQuery(GL_SAMPLES_PASSED, query_);
        }
        break;
    case Bug::conditional_rendering:
        if (query_ == 0) {
            glGenQueries(1, &query_);
            glBeginQuery(GL_SAMPLES_PASSED, query_); // nothing is drawn in it: hidden
            glEndQuery(GL_SAMPLES_PASSED);
            glBeginConditionalRender(query_, GL_QUERY_WAIT);
        }
        break;
    case Bug::scissor:
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, 0, size.x / 2, size.y);
        break;
    case Bug::polygon_mode:
        glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        break;
    default:
        break;
    }
}

void ShadowPass::begin_frame(const occlude::View& view)
{
    clip_from_world_ = view.clip_from_world();
    glBindFramebuffer(GL_FRAMEBUFFER, renderer_.shadow_target_);
    glViewport(0, 0, Renderer::kShadowSize, Renderer::kShadowSize);
    glDisable(GL_SCISSOR_TEST);
    glBindTextureUnit(0, 0); // the pass draws into this texture
    restore_state();
    glClear(GL_DEPTH_BUFFER_BIT);
}

void ShadowPass::draw(std::span<const occlude::ItemId> items, occlude::DrawPass)
{
    renderer_.draw_sorted(items);
}

void ShadowPass::restore_state()
{
    renderer_.set_camera(clip_from_world_, clip_from_world_);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDisable(GL_DEPTH_CLAMP);
    glEnable(GL_CULL_FACE);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(-1.5f, -2.0f); // reversed Z: away from the light is smaller
}

} // namespace gl_engine
