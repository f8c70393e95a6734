#include <occlude/backends/gl/gl_device.h>
#include <occlude/backends/gl/headless_context.h>

#include "backends/gl_fixture.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

TEST(HeadlessContext, IsCurrentAndAtLeastCore33)
{
    auto context = HeadlessContext::create();
    ASSERT_TRUE(context) << context.error().message;
    EXPECT_GE(epoxy_gl_version(), 33);
    GLint profile = 0;
    glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    EXPECT_NE(profile & GL_CONTEXT_CORE_PROFILE_BIT, 0);
}

TEST(HeadlessContext, MissingLibraryIsAnErrorThatNamesItAndTheRemedy)
{
    const auto context = HeadlessContext::create({.egl_library = "libNoSuchEGL.so.7"});
    ASSERT_FALSE(context);
    EXPECT_EQ(context.error().code, ErrorCode::unsupported);
    EXPECT_NE(context.error().message.find("libNoSuchEGL.so.7"), std::string::npos);
    EXPECT_NE(context.error().message.find("install"), std::string::npos);
}

TEST(HeadlessContext, LibraryWithoutEglEntryPointsIsAnError)
{
    const auto context = HeadlessContext::create({.egl_library = "libm.so.6"});
    ASSERT_FALSE(context);
    EXPECT_NE(context.error().message.find("entry points"), std::string::npos);
}

TEST(HeadlessContext, TwoLiveSideBySide)
{
    auto first = HeadlessContext::create();
    ASSERT_TRUE(first);
    GLuint buffer = 0;
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    auto second = HeadlessContext::create();
    ASSERT_TRUE(second);
    EXPECT_FALSE(glIsBuffer(buffer));
    second->reset();
    ASSERT_TRUE((*first)->make_current());
    EXPECT_TRUE(glIsBuffer(buffer));
}

// Owns no OpenGL objects, so that it may outlive every context.
class EmptyScene final : public GlScene {
public:
    void begin_frame(const View&) override {}
    void draw(std::span<const ItemId>, DrawPass) override {}
    void restore_state() override {}
};

TEST(GlDeviceCreation, NoCurrentContextIsAnError)
{
    auto context = HeadlessContext::create();
    ASSERT_TRUE(context);
    context->reset(); // no context is current
    EmptyScene scene;
    const auto device = GlDevice::create(scene);
    ASSERT_FALSE(device);
    EXPECT_EQ(device.error().code, ErrorCode::unsupported);
}

TEST(GlDeviceCreation, TooOldAVersionIsAnErrorThatNamesIt)
{
    auto context = HeadlessContext::create();
    ASSERT_TRUE(context);
    QuadScene scene({4, 4}, 1);
    const auto device = GlDevice::create(scene, {.max_gl_version = 31});
    ASSERT_FALSE(device);
    EXPECT_NE(device.error().message.find("3.1"), std::string::npos);
}

TEST(GlProgram, CompileErrorNamesProgramStageAndReason)
{
    auto context = HeadlessContext::create();
    ASSERT_TRUE(context);
    const auto program = make_program("broken one", "#version 330 core\nvoid main() { nonsense; }",
                                      "#version 330 core\nvoid main() {}");
    ASSERT_FALSE(program);
    EXPECT_NE(program.error().message.find("broken one"), std::string::npos);
    EXPECT_NE(program.error().message.find("vertex"), std::string::npos);
    EXPECT_NE(program.error().message.find("nonsense"), std::string::npos);
}

} // namespace
} // namespace occlude
