// CpuFastDevice keeps the contract of devices.
#include "cpu_fast/box_occluders.h"

#include <occlude/backends/cpu_fast/cpu_fast_device.h>
#include <occlude/conformance/conformance.h>

#include <gtest/gtest.h>

namespace occlude {
namespace {

class CpuFastHost final : public conformance::Host {
public:
    CpuFastHost(ClipConvention convention, int cell_px)
        : convention_(convention)
        , device_(
              nullptr, scene_,
              {.buffer = {.cell_px = cell_px}, .min_px_per_triangle = 0.0f, .max_outstanding = 200})
    {
    }
    QueryDevice& device() override { return device_; }
    void set_items(std::span<const Aabb> boxes) override { scene_.set(boxes); }
    ClipConvention convention() const override { return convention_; }

private:
    ClipConvention convention_;
    test::BoxOccluders scene_;
    CpuFastDevice device_;
};

TEST(CpuFastDevice, KeepsTheContractInEveryConventionAndResolution)
{
    for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one}) {
        for (const DepthOrder order : {DepthOrder::near_is_small, DepthOrder::near_is_large}) {
            for (const int cell_px : {1, 2}) {
                CpuFastHost host({range, order}, cell_px);
                const conformance::Report report =
                    conformance::check_device(host, {.worlds = 2, .depth_may_be_farther = true});
                EXPECT_TRUE(report.passed()) << to_string(report);
                EXPECT_GT(report.hidden, 5u);
            }
        }
    }
}

} // namespace
} // namespace occlude
