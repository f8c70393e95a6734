// A model, or a town of its own, in a viewer of the engine, culled.
//
//   osg_town [FILE...]              opens a window; c switches culling, s shows the engine's
//   figures osg_town --frames N [FILE...]   walks N frames, prints what was hidden, and ends
//   ... --picture FILE.png          ... and writes the last frame
#include <occlude/osg/osg_culling.h>

#include <osg/Geode>
#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>
#include <osgDB/ReadFile>
#include <osgDB/WriteFile>
#include <osgGA/TrackballManipulator>
#include <osgViewer/Viewer>
#include <osgViewer/ViewerEventHandlers>

#include <cmath>
#include <cstdio>
#include <string>

namespace {

constexpr int kBlocks = 60;     // a side of the town
constexpr double kBlock = 24.0; // street included
constexpr double kHouse = 16.0;

osg::ref_ptr<osg::Node> make_town()
{
    osg::ref_ptr<osg::Group> town = new osg::Group;
    for (int x = 0; x < kBlocks; ++x) {
        for (int y = 0; y < kBlocks; ++y) {
            const double height = 8.0 + 7.0 * ((x * 7 + y * 13) % 5);
            osg::ref_ptr<osg::ShapeDrawable> house = new osg::ShapeDrawable(
                new osg::Box({0.0f, 0.0f, 0.0f}, kHouse, kHouse, static_cast<float>(height)));
            const auto shade = static_cast<float>(0.45 + 0.1 * ((x + 2 * y) % 5));
            house->setColor({shade, 0.9f * shade, 0.75f * shade, 1.0f});
            osg::ref_ptr<osg::MatrixTransform> at = new osg::MatrixTransform(
                osg::Matrix::translate(x * kBlock, y * kBlock, 0.5 * height));
            at->addChild(house.get());
            town->addChild(at.get());
        }
    }
    const float side = kBlocks * kBlock;
    osg::ref_ptr<osg::ShapeDrawable> ground =
        new osg::ShapeDrawable(new osg::Box({0.5f * side, 0.5f * side, -0.5f}, side, side, 1.0f));
    ground->setColor({0.35f, 0.4f, 0.33f, 1.0f});
    town->addChild(ground.get());
    return town;
}

// Down a street, looking a little to both sides.
osg::Matrixd view_of_walk(int frame, int frames)
{
    const double along = 2.0 * kBlock + frame * kBlock * 20.0 / frames;
    const double turn = 0.6 * std::sin(frame * 0.15);
    const osg::Vec3d eye(20.5 * kBlock, along, 6.0);
    return osg::Matrixd::lookAt(eye, eye + osg::Vec3d(std::sin(turn), std::cos(turn), 0.0),
                                osg::Vec3d(0.0, 0.0, 1.0));
}

class CullingSwitch final : public osgGA::GUIEventHandler {
public:
    explicit CullingSwitch(occlude::OsgCulling& culling)
        : culling_(&culling)
    {
    }
    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter&) override
    {
        if (event.getEventType() != osgGA::GUIEventAdapter::KEYDOWN || event.getKey() != 'c') {
            return false;
        }
        culling_->set_enabled(!culling_->enabled());
        std::printf("culling is %s\n", culling_->enabled() ? "on" : "off");
        return true;
    }

private:
    osg::ref_ptr<occlude::OsgCulling> culling_;
};

// Reads the picture of a camera when it is drawn.
class Picture final : public osg::Camera::DrawCallback {
public:
    void operator()(osg::RenderInfo& info) const override
    {
        const osg::Viewport& viewport = *info.getCurrentCamera()->getViewport();
        image->readPixels(0, 0, static_cast<int>(viewport.width()),
                          static_cast<int>(viewport.height()), GL_RGB, GL_UNSIGNED_BYTE);
    }
    osg::ref_ptr<osg::Image> image = new osg::Image;
};

void walk(osgViewer::Viewer& viewer, occlude::OsgCulling& culling, int frames, bool own_town)
{
    viewer.realize();
    uint64_t leaves = 0;
    uint64_t hidden = 0;
    for (int frame = 0; frame < frames && !viewer.done(); ++frame) {
        if (own_town) {
            viewer.getCamera()->setViewMatrix(view_of_walk(frame, frames));
        }
        viewer.frame();
        leaves += culling.stats().leaves;
        hidden += culling.stats().hidden_leaves;
    }
    std::printf("%d frames: %.0f drawables in the frustum, %.0f of them hidden and not drawn\n",
                frames, static_cast<double>(leaves) / frames, static_cast<double>(hidden) / frames);
}

} // namespace

int main(int argc, char** argv)
{
    osg::ArgumentParser arguments(&argc, argv);
    int frames = 0;
    std::string picture_file;
    arguments.read("--frames", frames);
    arguments.read("--picture", picture_file);
    osgViewer::Viewer viewer(arguments);
    osg::ref_ptr<osg::Node> scene = osgDB::readRefNodeFiles(arguments);
    const bool own_town = scene == nullptr;
    if (own_town) {
        scene = make_town();
    }
    viewer.setSceneData(scene.get());
    viewer.setLightingMode(osg::View::SKY_LIGHT);

    // This is all that culling needs.
    occlude::OsgCullingOptions options;
    options.on_message = [](const occlude::Message& message) {
        std::fprintf(stderr, "%s: %s\n", std::string(message.name).c_str(),
                     std::string(message.text).c_str());
    };
    osg::ref_ptr<occlude::OsgCulling> culling = occlude::OsgCulling::attach(*scene, options);

    osg::ref_ptr<Picture> picture = new Picture;
    if (!picture_file.empty()) {
        viewer.getCamera()->setFinalDrawCallback(picture.get());
    }
    viewer.addEventHandler(new CullingSwitch(*culling));
    viewer.addEventHandler(new osgViewer::StatsHandler);
    if (frames <= 0) {
        return viewer.run();
    }
    viewer.setUpViewInWindow(0, 0, 960, 540);
    if (!own_town) {
        viewer.setCameraManipulator(new osgGA::TrackballManipulator);
    }
    walk(viewer, *culling, frames, own_town);
    viewer.stopThreading();
    return picture_file.empty() || osgDB::writeImageFile(*picture->image, picture_file) ? 0 : 1;
}
