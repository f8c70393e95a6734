// Owners of OpenGL names, and two helpers that every part of the backend needs: programs, and
// buffers that are written many times per frame.
#pragma once

#include <occlude/backends/gl/detail/gl_context.h>
#include <occlude/core/result.h>

#include <epoxy/gl.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

namespace occlude {

/// Owns one OpenGL name. The context that made it must be current when it is made and destroyed.
template <class Kind>
class GlObject {
public:
    GlObject() = default;
    explicit GlObject(GLuint name)
        : name_(name)
    {
    }
    GlObject(GlObject&& other) noexcept
        : name_(std::exchange(other.name_, 0))
    {
    }
    GlObject& operator=(GlObject&& other) noexcept
    {
        std::swap(name_, other.name_);
        return *this;
    }
    ~GlObject()
    {
        if (name_ != 0 && !GlNamesAreForeign::now()) {
            Kind::destroy(name_);
        }
    }

    static GlObject make()
    {
        GLuint name = 0;
        Kind::generate(&name);
        return GlObject{name};
    }

    GLuint name() const { return name_; }

private:
    GLuint name_ = 0;
};

struct BufferKind {
    static void generate(GLuint* name) { glGenBuffers(1, name); }
    static void destroy(GLuint name) { glDeleteBuffers(1, &name); }
};
struct VertexArrayKind {
    static void generate(GLuint* name) { glGenVertexArrays(1, name); }
    static void destroy(GLuint name) { glDeleteVertexArrays(1, &name); }
};
struct SamplerKind {
    static void generate(GLuint* name) { glGenSamplers(1, name); }
    static void destroy(GLuint name) { glDeleteSamplers(1, &name); }
};
struct TextureKind {
    static void generate(GLuint* name) { glGenTextures(1, name); }
    static void destroy(GLuint name) { glDeleteTextures(1, &name); }
};
struct FramebufferKind {
    static void generate(GLuint* name) { glGenFramebuffers(1, name); }
    static void destroy(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct RenderbufferKind {
    static void generate(GLuint* name) { glGenRenderbuffers(1, name); }
    static void destroy(GLuint name) { glDeleteRenderbuffers(1, &name); }
};
struct QueryKind {
    static void generate(GLuint* name) { glGenQueries(1, name); }
    static void destroy(GLuint name) { glDeleteQueries(1, &name); }
};
struct ProgramKind {
    static void generate(GLuint* name) { *name = glCreateProgram(); }
    static void destroy(GLuint name) { glDeleteProgram(name); }
};
struct ShaderKind {
    static void destroy(GLuint name) { glDeleteShader(name); }
};

using GlBuffer = GlObject<BufferKind>;
using GlVertexArray = GlObject<VertexArrayKind>;
using GlSampler = GlObject<SamplerKind>;
using GlTexture = GlObject<TextureKind>;
using GlFramebuffer = GlObject<FramebufferKind>;
using GlRenderbuffer = GlObject<RenderbufferKind>;
using GlQuery = GlObject<QueryKind>;
using GlProgram = GlObject<ProgramKind>;
using GlShader = GlObject<ShaderKind>;

/// A linked program of a vertex and a fragment shader. An error names `name`, the stage and the
/// message of the driver's compiler.
Result<GlProgram> make_program(std::string_view name, std::string_view vertex_source,
                               std::string_view fragment_source);

/// A buffer for data that is written once and read by the next draws. It is a ring that gets fresh
/// storage when it wraps, so that writing never waits for earlier draws. Grows as needed.
class GlStreamBuffer {
public:
    /// `unit` is the size of an element in bytes: every offset is a multiple of it.
    GlStreamBuffer(size_t unit, size_t capacity_units);

    /// Copies `bytes` (a whole number of units) into the buffer and returns their offset in bytes;
    /// nothing if the driver has no memory. Binds the buffer to GL_ARRAY_BUFFER and leaves it
    /// bound.
    std::optional<size_t> write(std::span<const std::byte> bytes);

    GLuint name() const { return buffer_.name(); }

private:
    bool renew(size_t capacity);

    GlBuffer buffer_;
    size_t capacity_ = 0;
    size_t used_ = 0;
};

} // namespace occlude
