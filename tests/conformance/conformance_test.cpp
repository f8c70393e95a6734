// Every device of the library keeps the contract of core/query_device.h.
#include <occlude/conformance/conformance.h>
#include <occlude/device/cost_model_device.h>
#include <occlude/device/counting_device.h>
#include <occlude/device/delaying_device.h>
#include <occlude/device/faulty_device.h>
#include <occlude/device/recording_device.h>
#include <occlude/device/scripted_device.h>
#include <occlude/device/validating_device.h>

#include "conformance/cpu_host.h"

#include <gtest/gtest.h>

namespace occlude {
namespace {

using conformance::check_device;
using test::CpuHost;

/// Expects that the device conforms, and that the check was evidence: it saw hidden and visible
/// boxes.
void expect_conforms(conformance::Host& host, const conformance::Options& options = {})
{
    const conformance::Report report = check_device(host, options);
    EXPECT_TRUE(report.passed()) << to_string(report);
    EXPECT_GT(report.visible, report.tests / 10) << to_string(report);
    if (options.must_find_hidden) {
        EXPECT_GT(report.hidden, report.tests / 20) << to_string(report);
        EXPECT_LT(report.hidden, report.tests * 9 / 10) << to_string(report);
    }
    if (host.device().caps().read_depth && options.must_find_hidden) {
        EXPECT_GT(report.depths_compared, 10000u) << to_string(report);
    }
}

template <class Decorator, class... Arguments>
CpuHost wrapped_in(Arguments... arguments)
{
    return CpuHost{[=](QueryDevice& inner) -> std::unique_ptr<QueryDevice> {
        return std::make_unique<Decorator>(inner, arguments...);
    }};
}

TEST(Conformance, TheCpuDeviceInEveryClipConvention)
{
    for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one}) {
        for (const DepthOrder order : {DepthOrder::near_is_small, DepthOrder::near_is_large}) {
            CpuHost host{{}, {range, order}};
            expect_conforms(host, {.seed = 7});
        }
    }
}

TEST(Conformance, TheCountingDevice)
{
    CpuHost host = wrapped_in<CountingDevice>();
    expect_conforms(host);
}

TEST(Conformance, TheRecordingDevice)
{
    CpuHost host = wrapped_in<RecordingDevice>();
    expect_conforms(host);
}

TEST(Conformance, TheCostModelDevice)
{
    static const std::vector<uint32_t> triangles(64, 12);
    CpuHost host = wrapped_in<CostModelDevice>(DeviceCosts{}, std::span<const uint32_t>{triangles});
    expect_conforms(host);
}

// The suite deliberately uses spent and invented tickets, and one test too many: C7 and C11. The
// validator must report nothing else, which shows that the suite itself keeps the contract.
TEST(Conformance, TheValidatingDeviceFindsOnlyWhatTheSuiteBreaksOnPurpose)
{
    std::vector<std::string> found;
    const ValidatingDevice::Options options{
        .on_violation = [&](std::string_view rule, std::string_view message) {
            if (rule != "C7" && rule != "C11") {
                found.push_back(std::string{rule} + ": " + std::string{message});
            }
        }};
    CpuHost host = wrapped_in<ValidatingDevice>(options);
    expect_conforms(host);
    EXPECT_EQ(found, std::vector<std::string>{});
}

TEST(Conformance, TheDelayingDeviceWithAndWithoutLosses)
{
    CpuHost late = wrapped_in<DelayingDevice>(
        DelayOptions{.seed = 5, .min_polls = 2, .max_polls = 9, .max_frames = 3});
    expect_conforms(late);
    CpuHost losing = wrapped_in<DelayingDevice>(DelayOptions{.seed = 5, .lose_every = 7});
    expect_conforms(losing, {.may_lose_answers = true});
}

TEST(Conformance, TheFaultyDeviceWithEveryFault)
{
    CpuHost host = wrapped_in<FaultyDevice>(Faults{.seed = 9,
                                                   .lost = 50,
                                                   .never_ready = 50,
                                                   .depth_fails = 200,
                                                   .max_polls = 5,
                                                   .max_frames = 2,
                                                   .expires_after_frames = 12,
                                                   .max_outstanding = 70});
    expect_conforms(host, {.may_lose_answers = true});
    CpuHost later = wrapped_in<FaultyDevice>(Faults{.max_frames = 2, .same_frame_results = false});
    expect_conforms(later);
}

class ScriptedHost final : public conformance::Host {
public:
    QueryDevice& device() override { return device_; }
    void set_items(std::span<const Aabb>) override {}

private:
    ScriptedDevice device_;
};

TEST(Conformance, TheScriptedDeviceThatSeesEverything)
{
    ScriptedHost host;
    expect_conforms(host, {.must_find_hidden = false});
}

} // namespace
} // namespace occlude
