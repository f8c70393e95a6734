#include <occlude/core/query_device.h>

#include <algorithm>

namespace occlude {

const char* name(TestMethod method)
{
    switch (method) {
    case TestMethod::queries:
        return "queries";
    case TestMethod::raster:
        return "raster";
    case TestMethod::pyramid:
        return "pyramid";
    case TestMethod::automatic:
        break;
    }
    return "automatic";
}

const TestCost* DeviceCaps::find_method(TestMethod method) const
{
    const auto found = std::ranges::find(methods, method, &TestCost::method);
    return found != methods.end() ? &*found : nullptr;
}

float DepthReadCost::us(glm::ivec2 size_px) const
{
    const auto count = [](glm::ivec2 size) {
        return static_cast<float>(size.x) * static_cast<float>(size.y);
    };
    return us_per_read + us_per_pixel * count(size_px) +
           us_per_value * count(tiles_in(size_px, tile_px));
}

const DepthReadCost* DeviceCaps::find_depth_read(int tile_px) const
{
    const auto found = std::ranges::find(depth_reads, tile_px, &DepthReadCost::tile_px);
    return found != depth_reads.end() ? &*found : nullptr;
}

bool DeviceCaps::make_default(TestMethod method)
{
    const TestMethod wanted = method == TestMethod::automatic ? TestMethod::queries : method;
    const auto found = std::ranges::find(methods, wanted, &TestCost::method);
    if (found == methods.end()) {
        return false;
    }
    std::rotate(methods.begin(), found, found + 1);
    exact_counts = methods.front().exact_counts;
    return true;
}

} // namespace occlude
