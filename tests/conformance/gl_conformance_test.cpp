// The OpenGL device keeps the contract with every method of testing, single and multisampled, in
// every clip convention.
#include <occlude/conformance/conformance.h>

#include "backends/gl_fixture.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace occlude {
namespace {

/// The twelve triangles of a box, counter-clockwise from outside.
std::vector<glm::vec3> box_triangles(const Aabb& box)
{
    constexpr std::array<std::array<size_t, 4>, 6> kFaces{
        {{1, 3, 7, 5}, {0, 4, 6, 2}, {2, 6, 7, 3}, {0, 1, 5, 4}, {4, 5, 7, 6}, {0, 2, 3, 1}}};
    const auto corner = [&](size_t i) {
        return glm::vec3{(i & 1) != 0 ? box.max.x : box.min.x, (i & 2) != 0 ? box.max.y : box.min.y,
                         (i & 4) != 0 ? box.max.z : box.min.z};
    };
    std::vector<glm::vec3> points;
    for (const auto& face : kFaces) {
        for (const size_t i : {0u, 1u, 2u, 0u, 2u, 3u}) {
            points.push_back(corner(face[i]));
        }
    }
    return points;
}

class GlHost final : public conformance::Host {
public:
    GlHost(int samples, ClipConvention convention)
        : context_(HeadlessContext::create())
        , convention_(convention)
    {
        EXPECT_TRUE(context_) << (context_ ? "" : context_.error().message);
        scene_ = std::make_unique<QuadScene>(size_px(), samples);
        auto device = GlDevice::create(*scene_, {.max_outstanding = 200});
        EXPECT_TRUE(device) << (device ? "" : device.error().message);
        device_ = std::move(*device);
    }
    ~GlHost() override
    {
        device_.reset(); // while the context still lives
        scene_.reset();
    }

    QueryDevice& device() override { return *device_; }
    void set_items(std::span<const Aabb> boxes) override
    {
        scene_->clear();
        for (const Aabb& box : boxes) {
            scene_->add_triangles(box_triangles(box));
        }
    }
    ClipConvention convention() const override { return convention_; }

private:
    Result<std::unique_ptr<HeadlessContext>> context_;
    ClipConvention convention_;
    std::unique_ptr<QuadScene> scene_;
    std::unique_ptr<GlDevice> device_;
};

void expect_conforms(int samples, ClipConvention convention)
{
    GlHost host{samples, convention};
    ASSERT_EQ(host.device().caps().methods.size(), 3u); // queries, raster and pyramid
    const conformance::Report report = check_device(host, {.worlds = 3});
    EXPECT_TRUE(report.passed()) << to_string(report);
    EXPECT_GT(report.visible, report.tests / 10) << to_string(report);
    EXPECT_GT(report.hidden, report.tests / 20) << to_string(report);
    EXPECT_GT(report.depths_compared, 10000u) << to_string(report);
}

TEST(Conformance, TheGlDevice)
{
    expect_conforms(1, {DepthRange::minus_one_to_one, DepthOrder::near_is_small});
}

TEST(Conformance, TheGlDeviceWithDepthFromZeroToOneAndReversed)
{
    expect_conforms(1, {DepthRange::zero_to_one, DepthOrder::near_is_large});
}

TEST(Conformance, TheGlDeviceWithFourSamplesPerPixel)
{
    expect_conforms(4, {DepthRange::minus_one_to_one, DepthOrder::near_is_small});
}

} // namespace
} // namespace occlude
