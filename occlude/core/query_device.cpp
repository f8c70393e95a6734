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
