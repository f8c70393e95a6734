// Exactness on OpenGL, with the program's renderer: under every projection, with and without
// multisampling, with every test method, and far from the origin. The reference draws all items,
// without a frustum test. tests/cull/camera_exactness_test.cpp does the same on the CPU device.
#include "measure/stage.h"
#include "render/gl_renderer.h"
#include "render/image.h"

#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include "support/camera_worlds.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include <memory>

namespace occlude::tools {
namespace {

using test::Pose;
using test::Projection;

constexpr glm::ivec2 kSize{97, 61};

Mesh cube()
{
    Mesh mesh;
    mesh.name = "cube";
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 normal{0.0f};
            normal[axis] = side;
            const auto first = static_cast<uint32_t>(mesh.positions.size());
            for (int corner = 0; corner < 4; ++corner) {
                glm::vec3 p = normal;
                p[(axis + 1) % 3] = (corner & 1) != 0 ? 1.0f : -1.0f;
                p[(axis + 2) % 3] = (corner & 2) != 0 ? 1.0f : -1.0f;
                mesh.positions.push_back(p);
                mesh.normals.push_back(normal);
            }
            mesh.indices.insert(mesh.indices.end(),
                                {first, first + 1, first + 2, first + 2, first + 1, first + 3});
        }
    }
    mesh.parts = {{0, 36, {glm::vec3{-1.0f}, glm::vec3{1.0f}}}};
    return mesh;
}

/// Cubes that are stretched, turned and mirrored into the boxes of a random world. With `grid`, all
/// coordinates are multiples of 1/64 and no cube is turned, so that an integer offset changes no
/// bit.
SceneModel model_of(std::span<const test::DoubleBox> boxes, const glm::dvec3& offset, bool grid)
{
    SceneModel model;
    model.name = "cubes";
    model.meshes = {cube()};
    Rng rng(701);
    for (const test::DoubleBox& box : boxes) {
        glm::dvec3 center = 0.5 * (box.min + box.max);
        glm::dvec3 half = glm::max(0.5 * (box.max - box.min), glm::dvec3{1.0 / 64.0});
        glm::dmat4 world{1.0};
        if (grid) {
            center = glm::round(64.0 * center) / 64.0;
            half = glm::round(64.0 * half) / 64.0;
        } else if (rng.below(3) == 0) {
            world = glm::rotate(world, double{rng.range(0.0f, 6.0f)},
                                glm::normalize(glm::dvec3{1.0, 2.0, 0.5}));
        }
        half.x *= rng.below(4) == 0 ? -1.0 : 1.0;
        world = glm::translate(glm::dmat4{1.0}, center + offset) * world *
                glm::scale(glm::dmat4{1.0}, half);
        model.instances.push_back(
            {"cube", 0, glm::mat4{world}, {rng.range(0.1f, 0.9f), rng.range(0.1f, 0.9f), 0.4f}});
    }
    return model;
}

/// A model with its renderer, tree and all its items.
struct World {
    World(SceneModel made, int samples, glm::ivec2 size = kSize)
        : model(std::move(made))
        , cull_scene(make_cull_scene(model))
        , tree(build_bvh(cull_scene.scene.item_bounds(), {.leaf_triangles = 36}))
    {
        auto gl = make_gl_renderer(model, cull_scene.items, size, samples);
        EXPECT_TRUE(gl) << (gl ? "" : gl.error().message);
        renderer = std::move(*gl);
        for (size_t i = 0; i < cull_scene.items.size(); ++i) {
            all.emplace_back(i);
        }
    }

    Capture unculled(const View& view)
    {
        renderer->render(view, all);
        return renderer->capture();
    }

    SceneModel model;
    CullScene cull_scene;
    Hierarchy tree;
    std::unique_ptr<SceneRenderer> renderer;
    std::vector<ItemId> all;
};

/// True if surfaces may share a depth: then the order of draws decides which one is visible.
enum class Ties { none, expected };

size_t differing(const Capture& a, const Capture& b, Ties ties = Ties::none)
{
    size_t count = ties == Ties::none ? count_differences(a.color, b.color) : 0;
    for (size_t i = 0; i < std::min(a.depth.size(), b.depth.size()); ++i) {
        count += a.depth[i] != b.depth[i] ? 1 : 0;
    }
    return count;
}

struct Evidence {
    size_t in_frustum = 0;
    size_t drawn = 0;

    double hidden_share() const
    {
        return in_frustum == 0 ? 0.0
                               : 1.0 - static_cast<double>(drawn) / static_cast<double>(in_frustum);
    }
};

void expect_exact(World& world, const std::string& algorithm, std::span<const OptionValue> options,
                  std::span<const View> views, std::span<const Capture> references,
                  Evidence& evidence, Ties ties = Ties::none)
{
    auto culler = make_culler(algorithm, world.tree, options);
    ASSERT_TRUE(culler) << culler.error().message;
    for (size_t frame = 0; frame < views.size(); ++frame) {
        const View& view = views[frame];
        if (auto* oracle = dynamic_cast<OracleCuller*>(culler->get())) {
            oracle->record(view, world.renderer->device(),
                           owners_of_pixels(world.renderer->render_ids(view, world.all)));
        }
        (*culler)->cull(view, world.renderer->device());
        EXPECT_EQ(differing(world.renderer->capture(), references[frame], ties), 0u)
            << algorithm << ", frame " << frame;
        evidence.drawn += (*culler)->drawn_items().size();
        for (const ItemBounds& item : world.cull_scene.scene.item_bounds()) {
            evidence.in_frustum +=
                view.frustum().classify(item.box) != Containment::outside ? 1 : 0;
        }
    }
}

std::vector<View> views_of(const Projection& projection, uint64_t seed, size_t count,
                           const glm::dvec3& offset = glm::dvec3{0.0}, glm::ivec2 size = kSize)
{
    Rng rng(seed);
    std::vector<View> views;
    for (size_t i = 0; i < count; ++i) {
        Pose pose = test::random_pose(rng);
        pose.eye = glm::round(64.0 * pose.eye) / 64.0 + offset;
        pose.left_handed = test::is_left_handed(projection);
        views.push_back(test::view_of(projection, pose, size));
    }
    return views;
}

std::vector<Capture> references_of(World& world, std::span<const View> views)
{
    std::vector<Capture> references;
    for (const View& view : views) {
        references.push_back(world.unculled(view));
    }
    return references;
}

std::vector<OptionValue> options_of(const std::string& algorithm)
{
    std::vector<OptionValue> options;
    if (algorithm == "uniform_grid") {
        options.emplace_back("cell_triangles", "100");
    }
    return options;
}

TEST(GlExactness, EveryProjectionByEveryMethod)
{
    Rng rng(702);
    World world(model_of(test::random_world(rng, 220, true), glm::dvec3{0.0}, false), 1);
    for (const TestMethod method : {TestMethod::queries, TestMethod::raster, TestMethod::pyramid}) {
        ASSERT_TRUE(world.renderer->use_test_method(method));
        Evidence evidence;
        for (const Projection& projection : test::projections_for_images()) {
            SCOPED_TRACE(std::string{name(method)} + ", " + projection.name);
            const std::vector<View> views =
                views_of(projection, 703, 2 * static_cast<size_t>(test::soak_factor()));
            const std::vector<Capture> references = references_of(world, views);
            // So close a near plane leaves few steps of depth for the rest of the world.
            const Ties ties =
                std::string_view{projection.name} == "tiny near" ? Ties::expected : Ties::none;
            for (const std::string algorithm :
                 {"stop_and_wait", "chc_plus_plus", "two_phase", "lazy_grid"}) {
                expect_exact(world, algorithm, {}, views, references, evidence, ties);
            }
        }
        EXPECT_GT(evidence.hidden_share(), 0.1) << name(method);
        EXPECT_LT(evidence.hidden_share(), 0.9) << name(method);
    }
}

// The driver gives this number for larger requests. llvmpipe has four, also for two requested ones.
int most_samples(World& world)
{
    const auto refused = world.renderer->resize(kSize, 1 << 20);
    EXPECT_FALSE(refused);
    const std::string& sentence = refused.error().message;
    const size_t at = sentence.rfind("choose 1 to ");
    EXPECT_NE(at, std::string::npos) << sentence;
    return std::atoi(sentence.c_str() + at + std::string_view{"choose 1 to "}.size());
}

TEST(GlExactness, EveryExactAlgorithmWithAllNumbersOfSamplesThatTheDriverHas)
{
    Rng rng(704);
    const std::vector<test::DoubleBox> boxes = test::random_world(rng, 220, true);
    World single(model_of(boxes, glm::dvec3{0.0}, false), 1);
    const int most = most_samples(single);
    ASSERT_GE(most, 4) << "OpenGL asks for that of every driver";
    for (const int samples : {2, 4, 8}) {
        if (samples > most) {
            EXPECT_FALSE(single.renderer->resize(kSize, samples))
                << samples << " samples: the driver said that it has at most " << most;
            RecordProperty("most_samples_of_the_driver", most);
            continue;
        }
        World world(model_of(boxes, glm::dvec3{0.0}, false), samples);
        const auto pixels = static_cast<size_t>(kSize.x) * static_cast<size_t>(kSize.y);
        EXPECT_GE(
            world.renderer->render_ids(views_of(test::all_projections()[0], 705, 1)[0], world.all)
                .size(),
            static_cast<size_t>(samples) * pixels)
            << "fewer samples than asked for";
        for (const size_t which : {0u, 4u, 9u}) {
            const Projection projection = test::all_projections()[which];
            const std::vector<View> views = views_of(projection, 705, 3);
            const std::vector<Capture> references = references_of(world, views);
            for (const AlgorithmInfo& info : algorithms()) {
                if (!info.exact) {
                    continue;
                }
                SCOPED_TRACE(std::to_string(samples) + " samples, " + info.name + ", " +
                             projection.name);
                Evidence evidence;
                expect_exact(world, info.name, options_of(info.name), views, references, evidence);
                if (info.name == "ideal" || info.name == "stop_and_wait") {
                    EXPECT_GT(evidence.hidden_share(), 0.1);
                    EXPECT_LT(evidence.hidden_share(), 0.95);
                }
            }
        }
    }
}

// A sample away from the middle of its pixel can belong to an item that owns no middle.
TEST(GlExactness, OwnersOfSamplesAreMoreThanOwnersOfPixels)
{
    Rng rng(706);
    const std::vector<test::DoubleBox> boxes = test::random_world(rng, 400, true);
    World one(model_of(boxes, glm::dvec3{0.0}, false), 1, {31, 23});
    World four(model_of(boxes, glm::dvec3{0.0}, false), 4, {31, 23});
    size_t of_pixels = 0;
    size_t of_samples = 0;
    for (const View& view :
         views_of(test::all_projections()[0], 707, 6, glm::dvec3{0.0}, {31, 23})) {
        const auto ids = four.renderer->render_ids(view, four.all);
        ASSERT_EQ(ids.size(), 4u * 31u * 23u);
        of_pixels += owners_of_pixels(one.renderer->render_ids(view, one.all)).size();
        of_samples += owners_of_pixels(ids).size();
    }
    EXPECT_GT(of_samples, of_pixels);
}

// The renderer subtracts the camera's position first. An offset that changes no bit of the
// positions changes no bit of the image.
TEST(GlExactness, AnOffsetChangesNoBitOfTheImage)
{
    Rng rng(708);
    const std::vector<test::DoubleBox> boxes = test::random_world(rng, 220, true);
    World near_world(model_of(boxes, glm::dvec3{0.0}, true), 1);
    const glm::dvec3 offset{100000.0, -65536.0, 30000.0};
    World far_world(model_of(boxes, offset, true), 1);
    const Projection projection = test::all_projections()[0];
    const std::vector<View> near_views = views_of(projection, 709, 4);
    const std::vector<View> far_views = views_of(projection, 709, 4, offset);
    const std::vector<Capture> near_images = references_of(near_world, near_views);
    const std::vector<Capture> far_images = references_of(far_world, far_views);
    for (size_t frame = 0; frame < near_images.size(); ++frame) {
        EXPECT_EQ(differing(near_images[frame], far_images[frame]), 0u) << "frame " << frame;
    }
    Evidence near_evidence;
    Evidence far_evidence;
    for (const std::string algorithm : {"stop_and_wait", "chc_plus_plus", "two_phase"}) {
        expect_exact(near_world, algorithm, {}, near_views, near_images, near_evidence);
        expect_exact(far_world, algorithm, {}, far_views, far_images, far_evidence);
    }
    EXPECT_GT(far_evidence.hidden_share(), 0.1);
    EXPECT_NEAR(far_evidence.hidden_share(), near_evidence.hidden_share(), 0.03);
}

} // namespace
} // namespace occlude::tools
