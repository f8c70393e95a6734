#include <occlude/backends/gl/detail/gl_object.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace occlude::gl {

namespace {

std::string log_of(GLuint name, bool program)
{
    GLint length = 0;
    program ? glGetProgramiv(name, GL_INFO_LOG_LENGTH, &length)
            : glGetShaderiv(name, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
    GLsizei written = 0;
    program ? glGetProgramInfoLog(name, length, &written, log.data())
            : glGetShaderInfoLog(name, length, &written, log.data());
    log.resize(static_cast<size_t>(written));
    return log;
}

Result<GlShader> compile(std::string_view name, GLenum stage, std::string_view source)
{
    GlShader shader{glCreateShader(stage)};
    const char* text = source.data();
    const GLint length = static_cast<GLint>(source.size());
    glShaderSource(shader.name(), 1, &text, &length);
    glCompileShader(shader.name());
    GLint ok = GL_FALSE;
    glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &ok);
    if (ok != GL_TRUE) {
        const char* kind = stage == GL_VERTEX_SHADER ? "vertex" : "fragment";
        return Error{ErrorCode::device_failed,
                     "the OpenGL driver refused the " + std::string(kind) + " shader of '" +
                         std::string(name) + "': " + log_of(shader.name(), false)};
    }
    return shader;
}

} // namespace

Result<GlProgram> make_program(std::string_view name, std::string_view vertex_source,
                               std::string_view fragment_source)
{
    Result<GlShader> vertex = compile(name, GL_VERTEX_SHADER, vertex_source);
    if (!vertex) {
        return vertex.error();
    }
    Result<GlShader> fragment = compile(name, GL_FRAGMENT_SHADER, fragment_source);
    if (!fragment) {
        return fragment.error();
    }
    GlProgram program = GlProgram::make();
    glAttachShader(program.name(), vertex->name());
    glAttachShader(program.name(), fragment->name());
    glLinkProgram(program.name());
    GLint ok = GL_FALSE;
    glGetProgramiv(program.name(), GL_LINK_STATUS, &ok);
    if (ok != GL_TRUE) {
        return Error{ErrorCode::device_failed, "the OpenGL driver could not link the program '" +
                                                   std::string(name) +
                                                   "': " + log_of(program.name(), true)};
    }
    glDetachShader(program.name(), vertex->name());
    glDetachShader(program.name(), fragment->name());
    return program;
}

GlStreamBuffer::GlStreamBuffer(size_t unit, size_t capacity_units)
    : buffer_(GlBuffer::make())
    , capacity_(unit * capacity_units)
{
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity_), nullptr, GL_STREAM_DRAW);
}

size_t GlStreamBuffer::write(std::span<const std::byte> bytes)
{
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    if (bytes.empty()) {
        return used_;
    }
    if (used_ + bytes.size() > capacity_) {
        while (capacity_ < bytes.size()) {
            capacity_ *= 2;
        }
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity_), nullptr, GL_STREAM_DRAW);
        used_ = 0;
    }
    const size_t offset = used_;
    // Unsynchronised: this range was never read since the storage was renewed.
    void* target = glMapBufferRange(
        GL_ARRAY_BUFFER, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes.size()),
        GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_RANGE_BIT | GL_MAP_UNSYNCHRONIZED_BIT);
    bool written = false;
    if (target != nullptr) {
        std::memcpy(target, bytes.data(), bytes.size());
        written = glUnmapBuffer(GL_ARRAY_BUFFER) == GL_TRUE;
    }
    if (!written) {
        glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(offset),
                        static_cast<GLsizeiptr>(bytes.size()), bytes.data());
    }
    used_ += bytes.size();
    return offset;
}

} // namespace occlude::gl
