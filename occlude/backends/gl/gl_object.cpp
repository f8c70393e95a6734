#include <occlude/backends/gl/detail/gl_object.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace occlude {

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
{
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    renew(unit * capacity_units);
}

// Fresh storage. Reads back its size instead of the error state, whose error may be the engine's.
bool GlStreamBuffer::renew(size_t capacity)
{
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity), nullptr, GL_STREAM_DRAW);
    GLint64 size = 0;
    glGetBufferParameteri64v(GL_ARRAY_BUFFER, GL_BUFFER_SIZE, &size);
    const bool renewed = size == static_cast<GLint64>(capacity);
    capacity_ = renewed ? capacity : 0;
    used_ = 0;
    return renewed;
}

std::optional<size_t> GlStreamBuffer::write(std::span<const std::byte> bytes)
{
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    if (bytes.empty()) {
        return used_;
    }
    if (used_ + bytes.size() > capacity_) {
        size_t capacity = std::max(capacity_, bytes.size());
        while (capacity_ > 0 && capacity < 2 * bytes.size()) {
            capacity *= 2;
        }
        if (!renew(capacity)) {
            return std::nullopt;
        }
    }
    const size_t offset = used_;
    // Unsynchronised, because this range was not read since the storage was renewed.
    void* target = glMapBufferRange(
        GL_ARRAY_BUFFER, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes.size()),
        GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_RANGE_BIT | GL_MAP_UNSYNCHRONIZED_BIT);
    if (target == nullptr) {
        return std::nullopt;
    }
    std::memcpy(target, bytes.data(), bytes.size());
    if (glUnmapBuffer(GL_ARRAY_BUFFER) != GL_TRUE) { // the memory was lost while it was mapped
        glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(offset),
                        static_cast<GLsizeiptr>(bytes.size()), bytes.data());
    }
    used_ += bytes.size();
    return offset;
}

} // namespace occlude
