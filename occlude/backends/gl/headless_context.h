// An OpenGL context without a window or a display server, for tools and tests.
#pragma once

#include <occlude/core/result.h>

#include <memory>
#include <string>

namespace occlude {

struct HeadlessContextOptions {
    std::string egl_library = "libEGL.so.1"; ///< loaded when it is needed, so that programs start
                                             ///< on machines without it
};

/// A surfaceless EGL context of the highest available OpenGL core version, at least 3.3. Draws only
/// into framebuffer objects. The process shares one EGL display, which stays initialised.
class HeadlessContext {
public:
    /// Creates a context and makes it current in this thread. Fails with `unsupported` and the
    /// reason if there is no EGL library, no surfaceless display, or no OpenGL 3.3.
    static Result<std::unique_ptr<HeadlessContext>>
    create(const HeadlessContextOptions& options = {});

    ~HeadlessContext();
    HeadlessContext(const HeadlessContext&) = delete;
    HeadlessContext& operator=(const HeadlessContext&) = delete;

    /// Makes the context current in this thread; cheap if it is. False if EGL refuses, for instance
    /// because it is current in another thread.
    bool make_current();

private:
    struct Egl;
    HeadlessContext(std::unique_ptr<Egl> egl, void* display, void* context);

    std::unique_ptr<Egl> egl_;
    void* display_ = nullptr;
    void* context_ = nullptr;
};

} // namespace occlude
