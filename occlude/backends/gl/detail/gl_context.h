// Finds out which OpenGL context is current, by whatever library it was created.
#pragma once

namespace occlude {

/// Asks EGL and GLX, if the process has loaded them. On platforms with neither, contexts cannot be
/// told apart, and known() is false.
class GlContextWatch {
public:
    /// Looks for libraries that have been loaded since.
    GlContextWatch();

    bool known() const { return egl_ != nullptr || glx_ != nullptr; }

    /// A value that differs between contexts; null if none is current in this thread, or if
    /// contexts cannot be told apart. A few nanoseconds.
    void* current() const;

private:
    using GetCurrent = void* (*)();
    GetCurrent egl_ = nullptr;
    GetCurrent glx_ = nullptr;
};

/// While it lives, owners of OpenGL names in this thread forget the names instead of deleting them,
/// because in another context the names belong to others.
class GlNamesAreForeign {
public:
    GlNamesAreForeign();
    ~GlNamesAreForeign();
    GlNamesAreForeign(const GlNamesAreForeign&) = delete;
    GlNamesAreForeign& operator=(const GlNamesAreForeign&) = delete;

    static bool now();
};

} // namespace occlude
