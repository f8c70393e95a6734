// Does my device keep the contract? The suite checks the device of the minimal engine here. Replace
// it by your own, and run this in your continuous integration.
#include "ray_device.h"

#include <occlude/conformance/conformance.h>

#include <cstdio>
#include <memory>
#include <vector>

namespace {

class MyHost final : public occlude::conformance::Host {
public:
    MyHost() { set_items({}); }

    occlude::QueryDevice& device() override { return *device_; }

    // An engine would upload these boxes as meshes.
    void set_items(std::span<const occlude::Aabb> boxes) override
    {
        world_.clear();
        for (const occlude::Aabb& box : boxes) {
            world_.push_back({box, 12});
        }
        device_ = std::make_unique<minimal_engine::RayDevice>(world_);
    }

private:
    std::vector<occlude::ItemBounds> world_;
    std::unique_ptr<minimal_engine::RayDevice> device_;
};

} // namespace

int main()
{
    MyHost host;
    const occlude::conformance::Report report = occlude::conformance::check_device(host);
    std::fputs(to_string(report).c_str(), stdout);
    return report.passed() ? 0 : 1;
}
