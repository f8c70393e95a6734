// The base of exactness, without any algorithm: draw everything, then test the box of every item.
// The box of an item that owns a sample must be visible: under every projection, at every distance
// from the origin, in every unit, with every device and test method.
#include "backends/owner_scene.h"

#include <occlude/backends/cpu/cpu_device.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

using test::Drawing;
using test::Pose;
using test::Projection;

constexpr glm::ivec2 kSize{97, 61};

/// Counts of the answers of some frames.
struct Tally {
    size_t owners = 0; ///< boxes of items that own a sample
    size_t lost = 0;   ///< of these, answered "hidden": holes in a picture
    size_t tested = 0; ///< boxes of other items
    size_t hidden = 0; ///< of these, answered "hidden"

    double hidden_share() const
    {
        return tested + owners == 0
                   ? 0.0
                   : static_cast<double>(hidden) / static_cast<double>(tested + owners);
    }
};

std::vector<ItemId> all_items(size_t count)
{
    std::vector<ItemId> items;
    for (size_t i = 0; i < count; ++i) {
        items.emplace_back(i);
    }
    return items;
}

/// Tests every item's box against the depth of all of them. `owners` is called before the tests.
template <class Owners>
void test_all_boxes(QueryDevice& device, const View& view, std::span<const ItemBounds> items,
                    TestMethod method, Owners&& owners, Tally& tally)
{
    device.begin_frame(view);
    device.draw(all_items(items.size()), DrawPass::shade);
    const std::set<uint32_t> owning = owners();
    std::vector<QueryBox> boxes;
    std::vector<uint32_t> ends;
    std::vector<uint32_t> subjects;
    for (uint32_t i = 0; i < items.size(); ++i) {
        const bool owns = owning.contains(i);
        const bool outside = view.frustum().classify(items[i].box) == Containment::outside;
        if (outside) {
            tally.lost += owns ? 1 : 0;
            continue;
        }
        const Aabb box = view.inflated_for_test(items[i].box);
        if (!view.touches_near(box)) {
            boxes.push_back({box, nullptr, {}});
            ends.push_back(static_cast<uint32_t>(boxes.size()));
            subjects.push_back(i);
        }
    }
    std::vector<Ticket> tickets(ends.size());
    device.query({boxes, ends, method}, tickets);
    for (size_t i = 0; i < tickets.size(); ++i) {
        const Answer answer = device.wait(tickets[i]);
        const bool hidden = answer.state == AnswerState::ready && answer.samples == 0;
        const bool owns = owning.contains(subjects[i]);
        tally.owners += owns ? 1 : 0;
        tally.tested += owns ? 0 : 1;
        tally.lost += owns && hidden ? 1 : 0;
        tally.hidden += !owns && hidden ? 1 : 0;
    }
    device.end_frame();
}

class OnCpu {
public:
    OnCpu(std::span<const ItemBounds> items, glm::ivec2, Drawing)
        : items_(items)
        , scene_(items)
        , device_(scene_)
    {
    }
    static std::vector<TestMethod> methods() { return {TestMethod::queries, TestMethod::pyramid}; }
    void test(const View& view, TestMethod method, Tally& tally)
    {
        const auto owners = [&] {
            std::set<uint32_t> found;
            for (size_t i = 0; i < device_.depth().size(); ++i) {
                if (device_.owner(i).item.valid()) {
                    found.insert(device_.owner(i).item.value);
                }
            }
            return found;
        };
        test_all_boxes(device_, view, items_, method, owners, tally);
    }

private:
    std::span<const ItemBounds> items_;
    test::BoxCpuScene scene_;
    CpuDevice device_;
};

class OnGl {
public:
    OnGl(std::span<const ItemBounds> items, glm::ivec2 size, Drawing drawing)
        : items_(items)
    {
        auto context = HeadlessContext::create();
        EXPECT_TRUE(context) << (context ? "" : context.error().message);
        context_ = std::move(*context);
        scene_ = std::make_unique<IdScene>(size, 1, items, drawing);
        auto device = GlDevice::create(*scene_);
        EXPECT_TRUE(device) << (device ? "" : device.error().message);
        device_ = std::move(*device);
    }
    ~OnGl()
    {
        device_.reset();
        scene_.reset();
    }
    static std::vector<TestMethod> methods()
    {
        return {TestMethod::queries, TestMethod::raster, TestMethod::pyramid};
    }
    void test(const View& view, TestMethod method, Tally& tally)
    {
        const auto owners = [&] { return scene_->owners(); };
        test_all_boxes(*device_, view, items_, method, owners, tally);
    }

private:
    std::span<const ItemBounds> items_;
    std::unique_ptr<HeadlessContext> context_;
    std::unique_ptr<IdScene> scene_;
    std::unique_ptr<GlDevice> device_;
};

template <class Device>
class CameraTests : public testing::Test {
};
using Devices = testing::Types<OnCpu, OnGl>;
TYPED_TEST_SUITE(CameraTests, Devices);

View turned(const Projection& projection, Pose pose, double unit = 1.0,
            Drawing drawing = Drawing::relative, const ViewOptions& options = {},
            glm::ivec2 size = kSize)
{
    pose.left_handed = test::is_left_handed(projection);
    return test::view_of(projection, pose, size, unit, drawing, options);
}

TYPED_TEST(CameraTests, NoOwnerOfASampleIsHiddenUnderAnyProjection)
{
    Rng rng(601);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 300), 1.0, glm::dvec3{0.0});
    for (const Drawing drawing : {Drawing::relative, Drawing::absolute}) {
        TypeParam device(items, kSize, drawing);
        for (const TestMethod method : TypeParam::methods()) {
            for (const Projection& projection : test::projections_for_images()) {
                Tally tally;
                // A narrow view shows few boxes at a time, so that it needs more poses.
                for (uint64_t i = 0; i < 6 * test::soak_factor() || (tally.owners <= 20 && i < 60);
                     ++i) {
                    const Pose pose = test::random_pose(rng);
                    device.test(turned(projection, pose, 1.0, drawing), method, tally);
                }
                EXPECT_EQ(tally.lost, 0u) << projection.name << ", " << name(method);
                EXPECT_GT(tally.owners, 20u) << projection.name;
                EXPECT_GT(tally.hidden_share(), 0.05) << projection.name << ", " << name(method);
            }
        }
    }
}

// Mirrors, portals and water put the eye close to an oblique plane. Depth varies across the screen
// there, so that a box must also be moved toward the viewer, by what snapping a vertex changes.
TYPED_TEST(CameraTests, NoOwnerOfASampleIsHiddenUnderAnObliqueNearPlane)
{
    Rng rng(602);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 300), 1.0, glm::dvec3{0.0});
    TypeParam device(items, kSize, Drawing::relative);
    for (const TestMethod method : TypeParam::methods()) {
        Tally tally;
        for (uint64_t i = 0; i < 250 * test::soak_factor(); ++i) {
            const Projection projection = test::random_oblique(rng);
            device.test(turned(projection, test::random_pose(rng)), method, tally);
        }
        EXPECT_EQ(tally.lost, 0u) << name(method) << " of " << tally.owners;
        EXPECT_GT(tally.hidden_share(), 0.1) << name(method);
    }
}

TYPED_TEST(CameraTests, NoOwnerOfASampleIsHiddenFarFromTheOrigin)
{
    Rng rng(603);
    const std::vector<test::DoubleBox> world = test::random_world(rng, 300);
    for (const Drawing drawing : {Drawing::relative, Drawing::absolute}) {
        for (const double distance : {1e4, 1e5, 1e6, 1e7}) {
            const glm::dvec3 offset{distance, 0.3 * distance, -0.6 * distance};
            const std::vector<ItemBounds> items = test::placed(world, 1.0, offset);
            TypeParam device(items, kSize, drawing);
            for (const TestMethod method : TypeParam::methods()) {
                Tally tally;
                for (uint64_t i = 0; i < 12 * test::soak_factor(); ++i) {
                    const Pose pose = test::random_pose(rng, 1.0, offset);
                    const Projection projection = test::all_projections()[i % 13];
                    device.test(turned(projection, pose, 1.0, drawing), method, tally);
                }
                EXPECT_EQ(tally.lost, 0u)
                    << distance << ", " << name(method) << " of " << tally.owners;
                // Relative drawing is limited by the boxes, which float rounds to 1 unit at 1e7.
                if (distance <= (drawing == Drawing::relative ? 1e7 : 1e4)) {
                    EXPECT_GT(tally.hidden_share(), 0.1) << distance << ", " << name(method);
                }
            }
        }
    }
}

TYPED_TEST(CameraTests, NoOwnerOfASampleIsHiddenInAnyUnit)
{
    Rng rng(604);
    const std::vector<test::DoubleBox> world = test::random_world(rng, 300);
    for (const double unit : {1e-6, 1e-3, 1e3, 1e6, 1e9}) {
        const std::vector<ItemBounds> items = test::placed(world, unit, glm::dvec3{0.0});
        TypeParam device(items, kSize, Drawing::relative);
        for (const TestMethod method : TypeParam::methods()) {
            Tally tally;
            for (uint64_t i = 0; i < 13 * test::soak_factor(); ++i) {
                const Projection projection = test::all_projections()[i % 13];
                device.test(turned(projection, test::random_pose(rng, unit), unit), method, tally);
            }
            EXPECT_EQ(tally.lost, 0u) << unit << ", " << name(method);
            EXPECT_GT(tally.hidden_share(), 0.1) << unit << ", " << name(method);
        }
    }
}

TYPED_TEST(CameraTests, NoOwnerOfASampleIsHiddenWhereTheNearPlaneIsIgnored)
{
    Rng rng(605);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 300), 1.0, glm::dvec3{0.0});
    TypeParam device(items, kSize, Drawing::relative);
    for (const TestMethod method : TypeParam::methods()) {
        Tally tally;
        for (const Projection& projection : test::all_projections()) {
            for (uint64_t i = 0; i < 5 * test::soak_factor(); ++i) {
                device.test(turned(projection, test::random_pose(rng), 1.0, Drawing::relative,
                                   {.ignores_near_plane = true}),
                            method, tally);
            }
        }
        EXPECT_EQ(tally.lost, 0u) << name(method);
        EXPECT_GT(tally.hidden_share(), 0.1) << name(method);
    }
}

TYPED_TEST(CameraTests, NoOwnerOfASampleIsHiddenAtAnySize)
{
    Rng rng(606);
    const std::vector<ItemBounds> items =
        test::placed(test::random_world(rng, 300), 1.0, glm::dvec3{0.0});
    for (const glm::ivec2 size : {glm::ivec2{1, 1}, {2, 1}, {1, 90}, {5, 3}, {211, 17}}) {
        TypeParam device(items, size, Drawing::relative);
        for (const TestMethod method : TypeParam::methods()) {
            Tally tally;
            for (uint64_t i = 0; i < 20 * test::soak_factor(); ++i) {
                device.test(turned(test::all_projections()[i % 13], test::random_pose(rng), 1.0,
                                   Drawing::relative, {}, size),
                            method, tally);
            }
            EXPECT_EQ(tally.lost, 0u) << size.x << "x" << size.y << ", " << name(method);
            EXPECT_GT(tally.hidden, 0u) << size.x << "x" << size.y << ", " << name(method);
        }
    }
}

} // namespace
} // namespace occlude
