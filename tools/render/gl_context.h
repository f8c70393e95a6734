// The OpenGL context that a renderer draws in: its own, or the context of a window.
#pragma once

#include <occlude/core/result.h>

#include <memory>

namespace occlude::tools {

class GlContext {
public:
    virtual ~GlContext() = default;
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    /// Makes the context current in this thread; cheap if it is.
    virtual void make_current() = 0;

protected:
    GlContext() = default;
};

/// A context without a window (HeadlessContext), current in this thread.
Result<std::shared_ptr<GlContext>> make_headless_gl_context();

} // namespace occlude::tools
