#include <occlude/backends/gl/detail/gl_context.h>

#include <dlfcn.h>

namespace occlude {

namespace {

thread_local int foreign_names = 0;

// Null if the process has not loaded the library: this function must not load a second kind of
// OpenGL.
void* find_loaded(const char* library, const char* function)
{
    void* handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
    if (handle == nullptr) {
        return nullptr;
    }
    void* found = dlsym(handle, function);
    dlclose(handle);
    return found;
}

} // namespace

GlContextWatch::GlContextWatch()
    : egl_(reinterpret_cast<GetCurrent>(find_loaded("libEGL.so.1", "eglGetCurrentContext")))
    , glx_(reinterpret_cast<GetCurrent>(find_loaded("libGLX.so.0", "glXGetCurrentContext")))
{
    if (glx_ == nullptr) {
        glx_ = reinterpret_cast<GetCurrent>(find_loaded("libGL.so.1", "glXGetCurrentContext"));
    }
}

void* GlContextWatch::current() const
{
    void* context = egl_ != nullptr ? egl_() : nullptr;
    return context == nullptr && glx_ != nullptr ? glx_() : context;
}

GlNamesAreForeign::GlNamesAreForeign()
{
    ++foreign_names;
}

GlNamesAreForeign::~GlNamesAreForeign()
{
    --foreign_names;
}

bool GlNamesAreForeign::now()
{
    return foreign_names > 0;
}

} // namespace occlude
