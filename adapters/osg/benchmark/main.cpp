// Plain OpenSceneGraph, its OcclusionQueryNode and occlude::osg on one walk, frame by frame in
// turn.
//
//   osg_bench [--frames N] [--side N] [--cells ACROSS UP] [--size W H] [FILE]
//
// FILE is a model; by default a city of SIDE x SIDE boxes, each face of them ACROSS x UP quads: 1 1
// makes boxes of 12 triangles, 3 7 of 252. Prints one line of a Markdown table (./dev adapters
// bench).
#include "virtual_display.h"

#include <occlude/osg/osg_culling.h>

#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/OcclusionQueryNode>
#include <osgDB/ReadFile>
#include <osgViewer/Viewer>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

struct Options {
    int frames = 60;
    int side = 200;
    std::array<int, 2> cells{1, 1};
    std::array<int, 2> size{1280, 720};
    std::string file;
};

constexpr float kBlock = 12.0f; // a box and its share of the streets
constexpr float kHalf = 4.0f;
constexpr int kGroup = 8; // boxes along a side of one query of the engine

osg::Vec3 on_face(int face, float u, float v)
{
    const std::array<osg::Vec3, 6> corner{
        {{-1, -1, 1}, {-1, 1, 0}, {-1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}}};
    const std::array<osg::Vec3, 6> across{
        {{2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {-2, 0, 0}, {0, -2, 0}, {0, 2, 0}}};
    const std::array<osg::Vec3, 6> up{
        {{0, 2, 0}, {0, -2, 0}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}};
    const auto i = static_cast<size_t>(face);
    return corner[i] + across[i] * u + up[i] * v;
}

osg::ref_ptr<osg::Geometry> make_box(float height, const std::array<int, 2>& cells)
{
    const std::array<osg::Vec3, 6> normals{
        {{0, 0, 1}, {0, 0, -1}, {0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}}};
    const osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    const osg::ref_ptr<osg::Vec3Array> normal = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    const osg::ref_ptr<osg::DrawElementsUShort> indices = new osg::DrawElementsUShort(GL_TRIANGLES);
    for (int face = 0; face < 6; ++face) {
        const auto first = static_cast<unsigned short>(vertices->size());
        const auto row = static_cast<unsigned short>(cells[0] + 1);
        for (int y = 0; y <= cells[1]; ++y) {
            for (int x = 0; x <= cells[0]; ++x) {
                const osg::Vec3 at =
                    on_face(face, static_cast<float>(x) / static_cast<float>(cells[0]),
                            static_cast<float>(y) / static_cast<float>(cells[1]));
                vertices->push_back({at.x() * kHalf, at.y() * kHalf, at.z() * height});
                normal->push_back(normals[static_cast<size_t>(face)]);
            }
        }
        for (int y = 0; y < cells[1]; ++y) {
            for (int x = 0; x < cells[0]; ++x) {
                const auto low = static_cast<unsigned short>(first + y * row + x);
                for (const int corner : {0, 1, row + 1, 0, row + 1, int{row}}) {
                    indices->push_back(static_cast<unsigned short>(low + corner));
                }
            }
        }
    }
    osg::ref_ptr<osg::Geometry> box = new osg::Geometry;
    box->setUseDisplayList(false);
    box->setUseVertexBufferObjects(true);
    box->setVertexArray(vertices.get());
    box->setNormalArray(normal.get());
    box->addPrimitiveSet(indices.get());
    return box;
}

// Groups of boxes, so that each way of culling has the same hierarchy to walk.
osg::ref_ptr<osg::Group> make_city(const Options& options)
{
    std::vector<osg::ref_ptr<osg::Geometry>> shapes;
    for (int i = 0; i < 16; ++i) {
        shapes.push_back(make_box(6.0f + 2.5f * static_cast<float>((i * 7) % 16), options.cells));
    }
    osg::ref_ptr<osg::Group> city = new osg::Group;
    for (int gx = 0; gx < options.side; gx += kGroup) {
        for (int gy = 0; gy < options.side; gy += kGroup) {
            const osg::ref_ptr<osg::Group> group = new osg::Group;
            for (int x = gx; x < std::min(gx + kGroup, options.side); ++x) {
                for (int y = gy; y < std::min(gy + kGroup, options.side); ++y) {
                    const osg::ref_ptr<osg::MatrixTransform> at =
                        new osg::MatrixTransform(osg::Matrix::translate(
                            osg::Vec3(static_cast<float>(x), static_cast<float>(y), 0.0f) *
                            kBlock));
                    at->addChild(shapes[static_cast<size_t>((x * 31 + y * 17) % 16)].get());
                    group->addChild(at.get());
                }
            }
            city->addChild(group.get());
        }
    }
    return city;
}

// The same with a query of the engine around each child of the root.
osg::ref_ptr<osg::Group> with_queries(osg::Group& scene)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    for (unsigned int i = 0; i < scene.getNumChildren(); ++i) {
        const osg::ref_ptr<osg::OcclusionQueryNode> query = new osg::OcclusionQueryNode;
        query->setVisibilityThreshold(0);
        query->setQueryFrameCount(1);
        query->addChild(scene.getChild(i));
        root->addChild(query.get());
    }
    return root;
}

// When the frame is done, and its picture.
class FrameEnd final : public osg::Camera::DrawCallback {
public:
    void operator()(osg::RenderInfo& info) const override
    {
        glFinish();
        end = Clock::now();
        const osg::Viewport& viewport = *info.getCurrentCamera()->getViewport();
        pixels.resize(static_cast<size_t>(viewport.width() * viewport.height()));
        glReadPixels(0, 0, static_cast<int>(viewport.width()), static_cast<int>(viewport.height()),
                     GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    }
    mutable Clock::time_point end;
    mutable std::vector<uint32_t> pixels;
};

struct Contestant {
    osgViewer::Viewer viewer;
    osg::ref_ptr<FrameEnd> end = new FrameEnd;
    std::vector<double> ms;
    uint64_t different = 0;
    uint64_t different_frames = 0;

    void set_up(osg::Node& scene, const Options& options)
    {
        const osg::ref_ptr<osg::GraphicsContext::Traits> traits = new osg::GraphicsContext::Traits;
        traits->readDISPLAY();
        traits->width = options.size[0];
        traits->height = options.size[1];
        traits->pbuffer = true;
        traits->doubleBuffer = true;
        osg::Camera& camera = *viewer.getCamera();
        camera.setGraphicsContext(osg::GraphicsContext::createGraphicsContext(traits.get()));
        camera.setViewport(0, 0, options.size[0], options.size[1]);
        camera.setProjectionMatrixAsPerspective(
            60.0, static_cast<double>(options.size[0]) / options.size[1], 0.5, 5000.0);
        camera.setDrawBuffer(GL_BACK);
        camera.setReadBuffer(GL_BACK);
        camera.setFinalDrawCallback(end.get());
        viewer.setThreadingModel(osgViewer::Viewer::SingleThreaded);
        viewer.setSceneData(&scene);
        viewer.realize();
    }
    void draw(const osg::Matrixd& view)
    {
        viewer.getCamera()->setViewMatrix(view);
        const Clock::time_point begin = Clock::now();
        viewer.frame(0.0);
        ms.push_back(std::chrono::duration<double, std::milli>(end->end - begin).count());
    }
    void compare(const Contestant& plain)
    {
        uint64_t count = 0;
        for (size_t i = 0; i < end->pixels.size(); ++i) {
            count += end->pixels[i] != plain.end->pixels[i] ? 1 : 0;
        }
        different += count;
        different_frames += count > 0 ? 1 : 0;
    }
    double median() const
    {
        std::vector<double> sorted(ms.begin() + static_cast<ptrdiff_t>(ms.size() / 8), ms.end());
        std::ranges::sort(sorted);
        return sorted[sorted.size() / 2];
    }
};

osg::Matrixd view_of_walk(const osg::BoundingSphere& bound, const Options& options, int frame)
{
    const double part = static_cast<double>(frame) / options.frames;
    if (options.file.empty()) {
        const double street = (options.side / 2 + 0.5) * static_cast<double>(kBlock);
        const osg::Vec3d eye(street, (options.side * 0.1 + part * options.side * 0.3) * kBlock,
                             2.0);
        const double turn = 0.7 * std::sin(frame * 0.2);
        return osg::Matrixd::lookAt(eye, eye + osg::Vec3d(std::sin(turn), std::cos(turn), 0.0),
                                    osg::Vec3d(0, 0, 1));
    }
    const double angle = part * 6.283;
    const osg::Vec3d center(bound.center());
    const osg::Vec3d eye =
        center + osg::Vec3d(std::cos(angle), 0.1, std::sin(angle)) * (0.6 * bound.radius());
    return osg::Matrixd::lookAt(eye, center, osg::Vec3d(0, 1, 0));
}

Options read_options(osg::ArgumentParser& arguments)
{
    Options options;
    arguments.read("--frames", options.frames);
    arguments.read("--side", options.side);
    arguments.read("--cells", options.cells[0], options.cells[1]);
    arguments.read("--size", options.size[0], options.size[1]);
    if (arguments.argc() > 1) {
        options.file = arguments[1];
    }
    return options;
}

} // namespace

int main(int argc, char** argv)
{
    osg::ArgumentParser arguments(&argc, argv);
    const Options options = read_options(arguments);
    if (std::getenv("DISPLAY") == nullptr && !occlude::start_virtual_display()) {
        std::fputs("there is no display, and no Xvfb to make one\n", stderr);
        return 1;
    }
    osg::ref_ptr<osg::Group> scene = make_city(options);
    if (!options.file.empty()) {
        const osg::ref_ptr<osg::Node> model = osgDB::readRefNodeFile(options.file);
        if (model == nullptr || model->asGroup() == nullptr) {
            std::fprintf(stderr, "%s: no model that OpenSceneGraph can read\n",
                         options.file.c_str());
            return 1;
        }
        scene = model->asGroup();
    }
    const osg::ref_ptr<osg::Group> queries = with_queries(*scene);
    const osg::ref_ptr<osg::Group> culled = new osg::Group;
    culled->addChild(scene.get());
    const osg::ref_ptr<occlude::OsgCulling> culling = occlude::OsgCulling::attach(*culled);

    std::array<Contestant, 3> all; // plain, queries of the engine, this adapter
    all[0].set_up(*scene, options);
    all[1].set_up(*queries, options);
    all[2].set_up(*culled, options);
    uint64_t leaves = 0;
    uint64_t hidden = 0;
    for (int frame = 0; frame < options.frames; ++frame) {
        const osg::Matrixd view = view_of_walk(scene->getBound(), options, frame);
        for (size_t i = 0; i < all.size(); ++i) {
            all[(i + static_cast<size_t>(frame)) % all.size()].draw(view);
        }
        all[1].compare(all[0]);
        all[2].compare(all[0]);
        leaves += culling->stats().leaves;
        hidden += culling->stats().hidden_leaves;
    }
    const double pixels = static_cast<double>(options.frames) * options.size[0] * options.size[1];
    std::printf(
        "| %s | %d | %.2f ms | %.2f ms, %.2f times | %.3f %% in %llu frames | "
        "%.2f ms, %.2f times | %llu in %llu frames | %.1f %% |\n",
        options.file.empty() ? "city" : options.file.c_str(), options.frames, all[0].median(),
        all[1].median(), all[0].median() / all[1].median(),
        100.0 * static_cast<double>(all[1].different) / pixels,
        static_cast<unsigned long long>(all[1].different_frames), all[2].median(),
        all[0].median() / all[2].median(), static_cast<unsigned long long>(all[2].different),
        static_cast<unsigned long long>(all[2].different_frames),
        100.0 * static_cast<double>(hidden) / static_cast<double>(std::max<uint64_t>(leaves, 1)));
    return 0;
}
