// A ValidatingDevice whose reports are collected, for the tests of its rules.
#pragma once

#include <occlude/device/validating_device.h>

#include <string>
#include <utility>

namespace occlude::test {

/// A device under test, and the names of the rules that it has broken.
struct Bench {
    explicit Bench(QueryDevice& inner,
                   ValidatingDevice::DepthChecks checks = ValidatingDevice::DepthChecks::off)
        : device(inner, {.on_violation =
                             [this](std::string_view rule, std::string_view message) {
                                 rules += std::string(rule) + " ";
                                 messages += std::string(message) + "\n";
                             },
                         .depth_checks = checks})
    {
    }

    /// The rules broken since the last call: "C5 C6 ".
    std::string broken() { return std::exchange(rules, {}); }

    std::string rules;
    std::string messages;
    ValidatingDevice device;
};

inline DeviceCaps depth_caps()
{
    return {.name = "depth", .read_depth = true, .methods = {}};
}

} // namespace occlude::test
