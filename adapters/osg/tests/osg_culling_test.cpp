// The same program with the adapter and without, frame by frame and pixel by pixel.
#include "random_world.h"

#include <occlude/osg/osg_culling.h>

#include <osgViewer/CompositeViewer>
#include <osgViewer/Viewer>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

namespace occlude {
namespace {

using Pixels = std::vector<uint32_t>;

// Reads the picture when the camera is done.
class PixelReader final : public osg::Camera::DrawCallback {
public:
    void operator()(osg::RenderInfo& info) const override
    {
        const osg::Viewport& viewport = *info.getCurrentCamera()->getViewport();
        const std::scoped_lock lock(mutex_);
        pixels_.resize(static_cast<size_t>(viewport.width() * viewport.height()));
        glReadPixels(static_cast<int>(viewport.x()), static_cast<int>(viewport.y()),
                     static_cast<int>(viewport.width()), static_cast<int>(viewport.height()),
                     GL_RGBA, GL_UNSIGNED_BYTE, pixels_.data());
    }
    Pixels take() const
    {
        const std::scoped_lock lock(mutex_);
        return pixels_;
    }

private:
    mutable std::mutex mutex_;
    mutable Pixels pixels_;
};

osg::ref_ptr<osg::GraphicsContext> make_context(int width, int height, int samples = 0)
{
    osg::ref_ptr<osg::GraphicsContext::Traits> traits = new osg::GraphicsContext::Traits;
    traits->readDISPLAY();
    traits->width = width;
    traits->height = height;
    traits->windowDecoration = false;
    traits->doubleBuffer = true;
    traits->pbuffer = true;
    traits->samples = static_cast<unsigned int>(samples);
    traits->sampleBuffers = samples > 0 ? 1 : 0;
    return osg::GraphicsContext::createGraphicsContext(traits.get());
}

// A camera on a part of a context, whose pictures are read.
struct Eye {
    osg::ref_ptr<osg::Camera> camera;
    osg::ref_ptr<PixelReader> reader = new PixelReader;

    void look(osg::GraphicsContext* context, int x, int y, int width, int height)
    {
        camera->setGraphicsContext(context);
        camera->setViewport(x, y, width, height);
        camera->setDrawBuffer(GL_BACK);
        camera->setReadBuffer(GL_BACK);
        camera->setProjectionMatrixAsPerspective(60.0, static_cast<double>(width) / height, 0.5,
                                                 300.0);
        camera->setFinalDrawCallback(reader.get());
    }
};

size_t different(const Pixels& a, const Pixels& b)
{
    size_t count = a.size() == b.size() ? 0 : a.size() + b.size();
    for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        count += a[i] != b[i] ? 1 : 0;
    }
    return count;
}

// What a run of frames came to.
struct Tally {
    uint64_t leaves = 0;
    uint64_t hidden = 0;
    uint64_t different_pixels = 0;
    uint64_t different_frames = 0;

    double hidden_share() const
    {
        return static_cast<double>(hidden) / static_cast<double>(std::max<uint64_t>(leaves, 1));
    }
};

// Draws a frame without culling, then the same with it, and compares.
void compare_frame(osgViewer::ViewerBase& viewer, OsgCulling& culling, std::span<const Eye> eyes,
                   Tally& tally)
{
    const auto draw = [&](bool enabled) {
        culling.set_enabled(enabled);
        viewer.frame(0.0);
        if (viewer.areThreadsRunning()) {
            viewer.stopThreading(); // waits for all draws
            viewer.startThreading();
        }
        std::vector<Pixels> pictures;
        for (const Eye& eye : eyes) {
            pictures.push_back(eye.reader->take());
        }
        return pictures;
    };
    const std::vector<Pixels> plain = draw(false);
    const std::vector<Pixels> culled = draw(true);
    const OsgCullingStats stats = culling.stats();
    tally.leaves += stats.leaves;
    tally.hidden += stats.hidden_leaves;
    for (size_t i = 0; i < plain.size(); ++i) {
        const size_t count = different(plain[i], culled[i]);
        tally.different_pixels += count;
        tally.different_frames += count > 0 ? 1 : 0;
    }
}

// Strolls through a world in one window.
class Stroll {
public:
    explicit Stroll(const WorldOptions& options,
                    osgViewer::Viewer::ThreadingModel model = osgViewer::Viewer::SingleThreaded,
                    int samples = 0, const char* algorithm = "two_phase")
        : world_(options)
        , culling_(OsgCulling::attach(world_.root(), {.algorithm = algorithm, .min_leaves = 1}))
        , samples_(samples)
    {
        viewer_.setThreadingModel(model);
        viewer_.setSceneData(&world_.root());
        eye_.camera = viewer_.getCamera();
        open_window(320, 200);
    }
    void open_window(int width, int height)
    {
        viewer_.stopThreading();
        if (context_ != nullptr) {
            context_->close();
        }
        context_ = make_context(width, height, samples_);
        resize(width, height);
        viewer_.realize();
    }
    void resize(int width, int height) { eye_.look(context_.get(), 0, 0, width, height); }
    void walk(int frames)
    {
        for (int frame = 0; frame < frames; ++frame) {
            world_.advance();
            viewer_.getCamera()->setViewMatrix(world_.next_view());
            compare_frame(viewer_, *culling_, {&eye_, 1}, tally_);
        }
    }
    /// Also forgets what was counted.
    void expect_no_difference(uint64_t seed, double least_hidden = 0.2)
    {
        EXPECT_EQ(tally_.different_pixels, 0u)
            << "in " << tally_.different_frames << " frames, seed " << seed;
        EXPECT_GT(tally_.hidden_share(), least_hidden) << "the case is not representative";
        EXPECT_LT(tally_.hidden_share(), 0.95) << "the case is not representative";
        tally_ = {};
    }

    OsgCulling& culling() { return *culling_; }

private:
    RandomWorld world_;
    osg::ref_ptr<OsgCulling> culling_;
    osg::ref_ptr<osg::GraphicsContext> context_;
    osgViewer::Viewer viewer_;
    Eye eye_;
    Tally tally_;
    int samples_;
};

TEST(OsgCulling, ShowsTheSamePixelsWhileEverythingMovesComesAndGoes)
{
    Stroll stroll({.seed = 1});
    stroll.walk(250);
    stroll.expect_no_difference(1);
}

TEST(OsgCulling, ShowsTheSamePixelsInStillScenes)
{
    Stroll stroll({.seed = 2,
                   .moves = false,
                   .comes_and_goes = false,
                   .levels = false,
                   .deforms = false,
                   .odd_states = false});
    stroll.walk(100);
    stroll.expect_no_difference(2);
    EXPECT_EQ(stroll.culling().stats().unknown_leaves, 0u);
    EXPECT_EQ(stroll.culling().stats().exempt_leaves, 0u);
    EXPECT_EQ(stroll.culling().stats().rebuilds, 1u);
}

TEST(OsgCulling, ShowsTheSamePixelsWithAlgorithmsThatTestInOtherWays)
{
    for (const char* algorithm : {"chc_plus_plus", "stop_and_wait", "adaptive"}) {
        SCOPED_TRACE(algorithm);
        Stroll stroll({.seed = 3}, osgViewer::Viewer::SingleThreaded, 0, algorithm);
        stroll.walk(40);
        stroll.expect_no_difference(3, 0.01); // which ones hide how much is not the adapter's
    }
}

TEST(OsgCulling, ShowsTheSamePixelsInEveryThreadingModel)
{
    for (const auto model :
         {osgViewer::Viewer::CullDrawThreadPerContext, osgViewer::Viewer::DrawThreadPerContext,
          osgViewer::Viewer::CullThreadPerCameraDrawThreadPerContext}) {
        SCOPED_TRACE(static_cast<int>(model));
        Stroll stroll({.seed = 4}, model);
        stroll.walk(40);
        stroll.expect_no_difference(4);
    }
}

TEST(OsgCulling, ShowsTheSamePixelsWithSeveralSamplesPerPixel)
{
    Stroll stroll({.seed = 5}, osgViewer::Viewer::SingleThreaded, 4);
    stroll.walk(60);
    stroll.expect_no_difference(5);
}

TEST(OsgCulling, FollowsAWindowThatChangesItsSize)
{
    Stroll stroll({.seed = 6});
    for (const int width : {320, 200, 311, 97}) {
        stroll.resize(width, width / 2);
        stroll.walk(12);
    }
    stroll.expect_no_difference(6);
}

TEST(OsgCulling, GoesOnInANewContext)
{
    Stroll stroll({.seed = 7});
    stroll.walk(20);
    stroll.expect_no_difference(7);
    stroll.open_window(300, 180);
    stroll.walk(20);
    stroll.expect_no_difference(7);
    stroll.open_window(200, 200);
    stroll.walk(20);
    stroll.expect_no_difference(7);
}

TEST(OsgCulling, CullsForTwoCamerasInOneWindowAndOneInAnother)
{
    RandomWorld world({.seed = 8});
    const osg::ref_ptr<OsgCulling> culling =
        OsgCulling::attach(world.root(), {.algorithm = "two_phase", .min_leaves = 1});
    const osg::ref_ptr<osg::GraphicsContext> both = make_context(400, 200);
    const osg::ref_ptr<osg::GraphicsContext> other = make_context(150, 150);
    osgViewer::CompositeViewer viewer;
    viewer.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
    std::array<Eye, 3> eyes;
    for (size_t i = 0; i < eyes.size(); ++i) {
        const osg::ref_ptr<osgViewer::View> view = new osgViewer::View;
        view->setSceneData(&world.root());
        eyes[i].camera = view->getCamera();
        viewer.addView(view.get());
    }
    eyes[0].look(both.get(), 0, 0, 200, 200);
    eyes[1].look(both.get(), 200, 20, 200, 150);
    eyes[2].look(other.get(), 0, 0, 150, 150);
    viewer.realize();
    Tally tally;
    for (int frame = 0; frame < 60; ++frame) {
        world.advance();
        const osg::Matrixd view = world.next_view();
        for (size_t i = 0; i < eyes.size(); ++i) {
            eyes[i].camera->setViewMatrix(
                view * osg::Matrixd::rotate(static_cast<double>(i), osg::Vec3d(0, 1, 0)));
        }
        compare_frame(viewer, *culling, eyes, tally);
    }
    EXPECT_EQ(tally.different_pixels, 0u) << "in " << tally.different_frames << " pictures, seed 8";
    EXPECT_GT(tally.hidden_share(), 0.1) << "the case is not representative";
}

TEST(OsgCulling, LeavesTheEngineAloneWhenDetachedOrSwitchedOff)
{
    Stroll stroll({.seed = 9});
    stroll.walk(3);
    EXPECT_TRUE(stroll.culling().enabled());
    stroll.culling().set_enabled(false);
    EXPECT_FALSE(stroll.culling().enabled());
    const osg::ref_ptr<osg::Group> node = new osg::Group;
    const osg::ref_ptr<osg::NodeCallback> mine = new osg::NodeCallback;
    node->setCullCallback(mine.get());
    const osg::ref_ptr<OsgCulling> culling = OsgCulling::attach(*node);
    EXPECT_EQ(node->getCullCallback(), culling.get());
    culling->detach(*node);
    EXPECT_EQ(node->getCullCallback(), mine.get());
}

} // namespace
} // namespace occlude
