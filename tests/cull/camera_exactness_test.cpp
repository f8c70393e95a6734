// Exactness under every projection, at every distance from the origin and in every unit. The image
// of every exact algorithm equals the image of all items, drawn without a frustum test. This file
// uses the CPU device; tests/tools/render/gl_exactness_test.cpp does the same on OpenGL.
#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include "support/box_scene.h"
#include "support/camera_worlds.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::Drawing;
using test::Pose;
using test::Projection;

constexpr glm::ivec2 kSize{97, 61};

struct Picture {
    std::vector<float> depth;
    std::vector<CpuDevice::Owner> owners;

    bool operator==(const Picture&) const = default;
};

Picture picture_of(const CpuDevice& device)
{
    Picture picture;
    picture.depth.assign(device.depth().begin(), device.depth().end());
    for (size_t i = 0; i < picture.depth.size(); ++i) {
        picture.owners.push_back(device.owner(i));
    }
    return picture;
}

size_t differing_pixels(const Picture& a, const Picture& b)
{
    size_t count = a.owners.size() == b.owners.size() ? 0 : 1;
    for (size_t i = 0; i < std::min(a.owners.size(), b.owners.size()); ++i) {
        count += a.owners[i] != b.owners[i] || a.depth[i] != b.depth[i] ? 1 : 0;
    }
    return count;
}

/// Draws everything in ascending order, without a frustum test.
Picture unculled(const CpuScene& scene, size_t item_count, const View& view)
{
    CpuDevice device(scene);
    std::vector<ItemId> all;
    for (size_t i = 0; i < item_count; ++i) {
        all.emplace_back(i);
    }
    device.begin_frame(view);
    device.draw(all, DrawPass::shade);
    device.end_frame();
    return picture_of(device);
}

struct Algorithm {
    std::string name;
    std::vector<OptionValue> options = {};
};

/// Every algorithm that promises exact images and uses the device for visibility.
std::vector<Algorithm> exact_algorithms()
{
    std::vector<Algorithm> all;
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.exact && (info.needs.queries || info.needs.depth_read)) {
            all.push_back({info.name});
        }
    }
    for (Algorithm& algorithm : all) {
        if (algorithm.name == "uniform_grid") {
            algorithm.options.emplace_back("cell_triangles",
                                           "100"); // by default three cells hold everything
        }
        if (algorithm.name == "adaptive") {
            algorithm.options.emplace_back("method",
                                           "pyramid"); // else it finds nothing worth a test
        }
    }
    all.push_back({"lazy_grid", {{"bounds", "faces"}}});
    return all;
}

/// Counts over some frames, to show that they are evidence.
struct Evidence {
    size_t in_frustum = 0;
    size_t drawn = 0;
    size_t frames = 0;
    size_t empty = 0; ///< frames in which no pixel shows anything

    double hidden_share() const
    {
        return in_frustum == 0 ? 0.0
                               : 1.0 - static_cast<double>(drawn) / static_cast<double>(in_frustum);
    }
};

/// Culls the views one after the other and compares each image with the image of everything.
void expect_exact(const Algorithm& algorithm, std::span<const ItemBounds> items,
                  std::span<const View> views, std::span<const Picture> references,
                  TestMethod method, Evidence& evidence)
{
    const test::BoxCpuScene scene(items);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 24});
    CpuDevice device(scene);
    ASSERT_TRUE(device.use_method(method));
    auto culler = make_culler(algorithm.name, tree, algorithm.options);
    ASSERT_TRUE(culler) << culler.error().message;
    FrustumCuller frustum{tree};
    CpuDevice frustum_device(scene);
    for (size_t frame = 0; frame < views.size(); ++frame) {
        (*culler)->cull(views[frame], device);
        EXPECT_EQ(differing_pixels(picture_of(device), references[frame]), 0u)
            << algorithm.name << ", frame " << frame;
        frustum.cull(views[frame], frustum_device);
        evidence.in_frustum += frustum.drawn_items().size();
        evidence.drawn += (*culler)->drawn_items().size();
        ++evidence.frames;
        const bool shows = std::ranges::any_of(
            references[frame].owners, [](const auto& owner) { return owner.item.valid(); });
        evidence.empty += shows ? 0 : 1;
    }
}

std::vector<Picture> references_of(std::span<const ItemBounds> items, std::span<const View> views)
{
    const test::BoxCpuScene scene(items);
    std::vector<Picture> references;
    for (const View& view : views) {
        references.push_back(unculled(scene, items.size(), view));
    }
    return references;
}

void expect_evidence(const Evidence& evidence, double least_hidden = 0.1)
{
    EXPECT_GT(evidence.hidden_share(), least_hidden) << "nothing was hidden";
    EXPECT_LT(evidence.hidden_share(), 0.9);
    EXPECT_LT(evidence.empty, evidence.frames / 2) << "most frames show nothing";
}

std::vector<View> views_of(const Projection& projection, std::span<const Pose> poses,
                           double unit = 1.0, Drawing drawing = Drawing::relative,
                           const ViewOptions& options = {}, glm::ivec2 size = kSize)
{
    std::vector<View> views;
    for (Pose pose : poses) {
        pose.left_handed = test::is_left_handed(projection);
        views.push_back(test::view_of(projection, pose, size, unit, drawing, options));
    }
    return views;
}

std::vector<Pose> poses(Rng& rng, size_t count)
{
    std::vector<Pose> all;
    for (size_t i = 0; i < count; ++i) {
        all.push_back(test::random_pose(rng));
        if (i % 3 == 2) { // a small step: what was visible still is
            all.back() = all[i - 1];
            all.back().eye += glm::dvec3{0.3, 0.1, -0.2};
        }
    }
    return all;
}

TEST(CameraExactness, EveryAlgorithmUnderEveryProjection)
{
    Rng rng(501);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 220), 1.0, glm::dvec3{0.0});
    for (const Algorithm& algorithm : exact_algorithms()) {
        for (const TestMethod method : {TestMethod::queries, TestMethod::pyramid}) {
            Evidence evidence;
            for (const Projection& projection : test::projections_for_images()) {
                SCOPED_TRACE(algorithm.name + ", " + name(method) + ", " + projection.name);
                Rng pose_rng(502);
                const std::vector<View> views = views_of(projection, poses(pose_rng, 3));
                expect_exact(algorithm, items, views, references_of(items, views), method,
                             evidence);
            }
            SCOPED_TRACE(algorithm.name + ", " + name(method));
            expect_evidence(evidence, algorithm.name == "uniform_grid" ? 0.02 : 0.1);
        }
    }
}

// Eyes near an oblique near plane: a fault here lost 1 to 19 pixels.
TEST(CameraExactness, ObliqueNearPlanesLoseNoPixel)
{
    const std::vector<Algorithm> algorithms{{"stop_and_wait"},
                                            {"chc_plus_plus"},
                                            {"two_phase"},
                                            {"lazy_grid"},
                                            {"lazy_grid", {{"bounds", "faces"}}}};
    Evidence evidence;
    for (uint64_t seed = 0; seed < 60 * test::soak_factor(); ++seed) {
        Rng rng(7000 + seed);
        const std::vector<ItemBounds> items =
            test::placed(test::random_world(rng, 160), 1.0, glm::dvec3{0.0});
        const Projection projection = test::random_oblique(rng);
        const std::vector<View> views = views_of(projection, poses(rng, 3));
        const std::vector<Picture> references = references_of(items, views);
        SCOPED_TRACE("seed " + std::to_string(7000 + seed));
        for (const Algorithm& algorithm : algorithms) {
            expect_exact(algorithm, items, views, references, TestMethod::queries, evidence);
        }
    }
    expect_evidence(evidence);
}

// Engines with double positions move the zero of the scene to the camera. The image must not depend
// on the distance between the camera and the zero of the world.
TEST(CameraExactness, AMovedOriginShowsTheSameAtEveryDistance)
{
    Rng rng(503);
    const std::vector<test::DoubleBox> boxes = test::random_world(rng, 220);
    const std::vector<Pose> walk = poses(rng, 4);
    const std::vector<ItemBounds> at_zero = test::placed(boxes, 1.0, glm::dvec3{0.0});
    const Projection projection = test::all_projections()[0];
    const std::vector<View> views = views_of(projection, walk);
    const std::vector<Picture> references = references_of(at_zero, views);
    for (const double distance : {1e5, 1e6, 1e7}) {
        const glm::dvec3 world_offset{distance, -0.7 * distance, 0.4 * distance};
        const glm::dvec3 scene_origin = world_offset + glm::dvec3{64.0, -32.0, 16.0};
        const std::vector<ItemBounds> items = test::placed(boxes, 1.0, world_offset - scene_origin);
        std::vector<Pose> far = walk;
        for (Pose& pose : far) {
            pose.eye = pose.eye + world_offset - scene_origin;
        }
        const std::vector<View> far_views = views_of(projection, far);
        SCOPED_TRACE("offset " + std::to_string(distance));
        for (const std::string name : {"stop_and_wait", "chc_plus_plus", "two_phase"}) {
            Evidence evidence;
            expect_exact({name}, items, far_views, references_of(items, far_views),
                         TestMethod::queries, evidence);
            expect_evidence(evidence);
        }
    }
}

// Boxes and positions in float, far from zero, for both ways of drawing.
// Boxes are rounded to 1/128 unit at 1e5, to 1/16 unit at 1e6 and to 1 unit at 1e7.
TEST(CameraExactness, FarFromTheOriginNothingIsLost)
{
    for (const Drawing drawing : {Drawing::relative, Drawing::absolute}) {
        for (const double distance : {1e4, 1e5, 1e6, 1e7}) {
            Evidence evidence;
            for (uint64_t seed = 0; seed < 4 * test::soak_factor(); ++seed) {
                Rng rng(7100 + seed);
                const glm::dvec3 offset{distance, 0.3 * distance, -0.6 * distance};
                const std::vector<ItemBounds> items =
                    test::placed(test::random_world(rng, 160), 1.0, offset);
                std::vector<Pose> walk = poses(rng, 3);
                for (Pose& pose : walk) {
                    pose.eye += offset;
                }
                const std::vector<View> views =
                    views_of(test::all_projections()[seed % 9], walk, 1.0, drawing);
                SCOPED_TRACE(
                    (drawing == Drawing::relative ? "relative, seed " : "absolute, seed ") +
                    std::to_string(7100 + seed) + ", distance " + std::to_string(distance));
                const std::vector<Picture> references = references_of(items, views);
                for (const TestMethod method : {TestMethod::queries, TestMethod::pyramid}) {
                    for (const std::string name : {"stop_and_wait", "chc_plus_plus", "two_phase"}) {
                        expect_exact({name}, items, views, references, method, evidence);
                    }
                }
            }
            // Drawn in world coordinates, beyond 1e5 positions round by more than the gaps of these
            // worlds. Drawn relative to the eye, only boxes are coarse.
            if (distance <= (drawing == Drawing::relative ? 1e7 : 1e4)) {
                expect_evidence(evidence);
            }
        }
    }
}

TEST(CameraExactness, TheUnitOfTheWorldDoesNotMatter)
{
    Rng rng(504);
    const std::vector<test::DoubleBox> boxes = test::random_world(rng, 160);
    const std::vector<Pose> walk = poses(rng, 3);
    for (const Projection& projection : test::all_projections()) {
        std::vector<double> hidden;
        for (const double exponent : {-6.0, -3.0, 0.0, 3.0, 6.0, 9.0}) {
            const double unit = std::pow(10.0, exponent);
            const std::vector<ItemBounds> items = test::placed(boxes, unit, glm::dvec3{0.0});
            std::vector<Pose> scaled = walk;
            for (Pose& pose : scaled) {
                pose.eye *= unit;
            }
            const std::vector<View> views = views_of(projection, scaled, unit);
            SCOPED_TRACE(std::string{projection.name} + ", unit " + std::to_string(exponent));
            Evidence evidence;
            expect_exact({"chc_plus_plus"}, items, views, references_of(items, views),
                         TestMethod::queries, evidence);
            expect_exact({"two_phase"}, items, views, references_of(items, views),
                         TestMethod::queries, evidence);
            hidden.push_back(evidence.hidden_share());
        }
        const auto [least, most] = std::ranges::minmax(hidden);
        EXPECT_LT(most - least, 0.03) << projection.name; // rounding decides for very few boxes
    }
}

TEST(CameraExactness, TargetsOfEverySize)
{
    Rng rng(505);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 160), 1.0, glm::dvec3{0.0});
    const std::vector<Pose> walk = poses(rng, 3);
    for (const glm::ivec2 size :
         {glm::ivec2{1, 1}, {2, 1}, {1, 97}, {3, 5}, {33, 2}, {64, 64}, {65, 63}, {257, 19}}) {
        SCOPED_TRACE(std::to_string(size.x) + "x" + std::to_string(size.y));
        for (const Algorithm& algorithm : exact_algorithms()) {
            const std::vector<View> views =
                views_of(test::all_projections()[0], walk, 1.0, Drawing::relative, {}, size);
            Evidence evidence;
            expect_exact(algorithm, items, views, references_of(items, views), TestMethod::queries,
                         evidence);
        }
    }
}

// The device has no such target: nothing is drawn, tests are lost and depth cannot be read. Every
// algorithm then draws all that is in the frustum, and neither throws nor asserts.
TEST(CameraExactness, AViewWithoutATargetHidesNothing)
{
    Rng rng(507);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 160), 1.0, glm::dvec3{0.0});
    const test::BoxCpuScene scene(items);
    const Hierarchy tree = build_bvh(items, {.leaf_triangles = 24});
    const std::vector<Pose> walk = poses(rng, 2);
    for (const glm::ivec2 size : {glm::ivec2{0, 0}, {0, 90}, {100000, 100000}, {20000, 20000}}) {
        for (const Algorithm& algorithm : exact_algorithms()) {
            if (size.x == 100000 && algorithm.name == "lazy_grid") {
                continue; // four million cells: the image is right, and slow to compute
            }
            SCOPED_TRACE(algorithm.name + ", " + std::to_string(size.x) + "x" +
                         std::to_string(size.y));
            CpuDevice device(scene);
            auto culler = make_culler(algorithm.name, tree, algorithm.options);
            FrustumCuller frustum{tree};
            for (const View& view :
                 views_of(test::all_projections()[0], walk, 1.0, Drawing::relative, {}, size)) {
                (*culler)->cull(view, device);
                frustum.cull(view, device);
                EXPECT_EQ((*culler)->drawn_items().size(), frustum.drawn_items().size());
                EXPECT_GT(frustum.drawn_items().size(), 0u);
            }
        }
    }
}

// Geometry before the near plane is drawn at its depth: shadow maps keep casters behind the camera.
TEST(CameraExactness, ViewsThatIgnoreTheNearPlaneKeepWhatIsBeforeIt)
{
    Rng rng(506);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 200), 1.0, glm::dvec3{0.0});
    for (const Projection& projection : test::all_projections()) {
        const std::vector<Pose> walk = poses(rng, 3);
        const std::vector<View> clamped =
            views_of(projection, walk, 1.0, Drawing::relative, {.ignores_near_plane = true});
        const std::vector<Picture> references = references_of(items, clamped);
        const std::vector<Picture> clipped = references_of(items, views_of(projection, walk));
        size_t more = 0;
        for (size_t frame = 0; frame < clipped.size(); ++frame) {
            more += differing_pixels(clipped[frame], references[frame]);
        }
        SCOPED_TRACE(projection.name);
        Evidence evidence;
        for (const Algorithm& algorithm : exact_algorithms()) {
            expect_exact(algorithm, items, clamped, references, TestMethod::queries, evidence);
        }
        if (projection.orthographic) {
            EXPECT_GT(more, 0u) << "nothing lay before the near plane";
            EXPECT_GT(evidence.hidden_share(), 0.1);
        }
    }
}

} // namespace
} // namespace occlude
