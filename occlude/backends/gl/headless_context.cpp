#include <occlude/backends/gl/headless_context.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <type_traits>
#include <utility>

namespace occlude {

// EGL is loaded by hand instead of through libepoxy, which ends the process if a library or an
// entry point is missing. Libraries are never unloaded, because drivers do not survive that.
struct HeadlessContext::Egl {
    decltype(&eglGetProcAddress) get_proc_address = nullptr;
    decltype(&eglQueryString) query_string = nullptr;
    decltype(&eglGetDisplay) get_display = nullptr;
    decltype(&eglInitialize) initialize = nullptr;
    decltype(&eglBindAPI) bind_api = nullptr;
    decltype(&eglChooseConfig) choose_config = nullptr;
    decltype(&eglCreateContext) create_context = nullptr;
    decltype(&eglDestroyContext) destroy_context = nullptr;
    decltype(&eglMakeCurrent) make_current = nullptr;
    decltype(&eglGetCurrentContext) get_current_context = nullptr;
    decltype(&eglGetError) get_error = nullptr;

    bool load(void* library)
    {
        const auto find = [library](auto& function, const char* name) {
            function =
                reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
            return function != nullptr;
        };
        return find(get_proc_address, "eglGetProcAddress") &&
               find(query_string, "eglQueryString") && find(get_display, "eglGetDisplay") &&
               find(initialize, "eglInitialize") && find(bind_api, "eglBindAPI") &&
               find(choose_config, "eglChooseConfig") && find(create_context, "eglCreateContext") &&
               find(destroy_context, "eglDestroyContext") && find(make_current, "eglMakeCurrent") &&
               find(get_current_context, "eglGetCurrentContext") && find(get_error, "eglGetError");
    }
};

namespace {

constexpr const char* kRemedy = "; install an OpenGL driver (Debian: libegl1, libopengl0, "
                                "libgl1-mesa-dri) or use the cpu device";

Error unavailable(const std::string& reason)
{
    return {ErrorCode::unsupported, "no OpenGL context: " + reason + kRemedy};
}

bool has_word(const char* words, std::string_view word)
{
    std::string_view rest = words == nullptr ? "" : words;
    while (!rest.empty()) {
        const size_t end = std::min(rest.find(' '), rest.size());
        if (rest.substr(0, end) == word) {
            return true;
        }
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return false;
}

// Tries core contexts from the highest version down; null if even 3.3 is not available.
template <class Egl>
EGLContext create_core_context(const Egl& egl, EGLDisplay display, EGLConfig config)
{
    constexpr std::array<std::pair<EGLint, EGLint>, 8> kVersions{
        {{4, 6}, {4, 5}, {4, 4}, {4, 3}, {4, 2}, {4, 1}, {4, 0}, {3, 3}}};
    for (const auto& [major, minor] : kVersions) {
        const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION_KHR,
                                               major,
                                               EGL_CONTEXT_MINOR_VERSION_KHR,
                                               minor,
                                               EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                                               EGL_NONE};
        const EGLContext context =
            egl.create_context(display, config, EGL_NO_CONTEXT, attributes.data());
        if (context != EGL_NO_CONTEXT) {
            return context;
        }
    }
    return EGL_NO_CONTEXT;
}

// The surfaceless display if the platform exists, otherwise the default one.
template <class Egl>
EGLDisplay open_display(const Egl& egl)
{
    const char* extensions = egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (has_word(extensions, "EGL_EXT_platform_base") &&
        has_word(extensions, "EGL_MESA_platform_surfaceless")) {
        const auto get_platform_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
            egl.get_proc_address("eglGetPlatformDisplayEXT"));
        if (get_platform_display != nullptr) {
            return get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY,
                                        nullptr);
        }
    }
    return egl.get_display(EGL_DEFAULT_DISPLAY);
}

} // namespace

HeadlessContext::HeadlessContext(std::unique_ptr<Egl> egl, void* display, void* context)
    : egl_(std::move(egl))
    , display_(display)
    , context_(context)
{
}

HeadlessContext::~HeadlessContext()
{
    if (egl_->get_current_context() == context_) {
        egl_->make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
    egl_->destroy_context(display_, context_);
}

bool HeadlessContext::make_current()
{
    return egl_->get_current_context() == context_ ||
           (egl_->bind_api(EGL_OPENGL_API) == EGL_TRUE &&
            egl_->make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE);
}

Result<std::unique_ptr<HeadlessContext>>
HeadlessContext::create(const HeadlessContextOptions& options)
{
    void* library = dlopen(options.egl_library.c_str(), RTLD_NOW | RTLD_GLOBAL);
    if (library == nullptr) {
        return unavailable("cannot load '" + options.egl_library + "'");
    }
    // libepoxy takes the entry points of OpenGL from one of these and aborts without them.
    if (dlopen("libOpenGL.so.0", RTLD_NOW) == nullptr &&
        dlopen("libGL.so.1", RTLD_NOW) == nullptr) {
        return unavailable("cannot load 'libOpenGL.so.0' or 'libGL.so.1'");
    }
    auto egl = std::make_unique<Egl>();
    if (!egl->load(library)) {
        return unavailable("'" + options.egl_library + "' lacks entry points of EGL 1.4");
    }
    const EGLDisplay display = open_display(*egl);
    if (display == EGL_NO_DISPLAY || egl->initialize(display, nullptr, nullptr) != EGL_TRUE) {
        return unavailable("EGL has no usable display");
    }
    const char* extensions = egl->query_string(display, EGL_EXTENSIONS);
    if (!has_word(extensions, "EGL_KHR_surfaceless_context") ||
        !has_word(extensions, "EGL_KHR_create_context")) {
        return unavailable("the EGL display has no contexts without a surface");
    }
    if (egl->bind_api(EGL_OPENGL_API) != EGL_TRUE) {
        return unavailable("this EGL offers OpenGL ES only");
    }
    EGLConfig config = nullptr; // EGL_NO_CONFIG_KHR
    if (!has_word(extensions, "EGL_KHR_no_config_context")) {
        const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                           EGL_NONE};
        EGLint count = 0;
        egl->choose_config(display, wanted.data(), &config, 1, &count);
        if (count == 0) {
            return unavailable("EGL has no configuration for OpenGL");
        }
    }
    const EGLContext context = create_core_context(*egl, display, config);
    if (context == EGL_NO_CONTEXT) {
        return unavailable("the driver has no OpenGL 3.3 core profile");
    }
    std::unique_ptr<HeadlessContext> made(new HeadlessContext(std::move(egl), display, context));
    if (!made->make_current()) {
        return unavailable("EGL cannot make a context current without a surface");
    }
    return made;
}

} // namespace occlude
