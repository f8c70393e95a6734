#include "window.h"

#include <occlude/backends/gl/headless_context.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <cstdio>
#include <utility>

namespace gl_engine {

namespace {

class Headless final : public Window {
public:
    explicit Headless(std::unique_ptr<occlude::HeadlessContext> context)
        : context_(std::move(context))
    {
    }
    Keys show(const std::string&) override { return {}; }
    bool has_framebuffer() const override { return false; }
    bool recreate_context() override
    {
        context_.reset();
        auto made = occlude::HeadlessContext::create();
        if (made) {
            context_ = std::move(*made);
        }
        return bool(made);
    }

private:
    std::unique_ptr<occlude::HeadlessContext> context_;
};

class GlfwWindow final : public Window {
public:
    explicit GlfwWindow(GLFWwindow* window)
        : window_(window)
    {
        glfwMakeContextCurrent(window_);
        glfwSwapInterval(1);
        ImGui::CreateContext();
        ImGui_ImplGlfw_InitForOpenGL(window_, true);
        ImGui_ImplOpenGL3_Init("#version 450 core");
    }
    ~GlfwWindow() override
    {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
        glfwDestroyWindow(window_);
        glfwTerminate();
    }

    Keys show(const std::string& report) override
    {
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        ImGui::SetNextWindowPos({8.0f, 8.0f});
        ImGui::Begin("occlude", nullptr,
                     ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize);
        ImGui::TextUnformatted(report.c_str());
        ImGui::TextUnformatted("C: cut to another place   P: pause   escape: quit");
        ImGui::End();
        ImGui::Render();
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        glfwSwapBuffers(window_);
        glfwPollEvents();
        return {ImGui::IsKeyPressed(GLFW_KEY_C, false), ImGui::IsKeyPressed(GLFW_KEY_P, false),
                ImGui::IsKeyPressed(GLFW_KEY_ESCAPE, false) ||
                    glfwWindowShouldClose(window_) != GLFW_FALSE};
    }
    bool has_framebuffer() const override { return true; }
    bool recreate_context() override { return false; } // only the tests do that

private:
    GLFWwindow* window_;
};

} // namespace

std::unique_ptr<Window> Window::open(glm::ivec2 size_px)
{
    GLFWwindow* window = nullptr;
    if (glfwInit() == GLFW_TRUE) {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
        glfwWindowHint(GLFW_DEPTH_BITS, 0); // the engine has a target of its own
        window = glfwCreateWindow(size_px.x, size_px.y, "occlude: gl_engine", nullptr, nullptr);
    }
    if (window == nullptr) {
        const char* why = nullptr;
        glfwGetError(&why);
        std::fprintf(stderr, "gl_engine: no window: %s; --headless needs none\n",
                     why != nullptr ? why : "GLFW says nothing");
        return nullptr;
    }
    return std::make_unique<GlfwWindow>(window);
}

std::unique_ptr<Window> Window::open_headless()
{
    auto context = occlude::HeadlessContext::create();
    if (!context) {
        std::fprintf(stderr, "gl_engine: %s\n", context.error().message.c_str());
        return nullptr;
    }
    return std::make_unique<Headless>(std::move(*context));
}

} // namespace gl_engine
