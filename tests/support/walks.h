// A camera walk and the names of cases, for several tests of occlude/cull.
#pragma once

#include "support/trees.h"

#include <occlude/cull/registry.h>

#include <cctype>
#include <span>
#include <string>

namespace occlude::test {

/// A walk through the boxes of random_boxes(), with jumps and turns by 90 degrees.
inline View rough_walk(uint64_t frame)
{
    const float t = static_cast<float>(frame);
    if (frame % 16 == 7) {
        return look({-60.0f, 5.0f, 10.0f}, {60.0f, 0.0f, 0.0f}); // a jump
    }
    if (frame % 16 > 11) {
        return look({0.0f, 0.0f, 60.0f - t}, {60.0f, 0.0f, 60.0f - t}); // 90 degrees
    }
    return look({0.0f, 0.0f, 60.0f - t}, {0.1f * t, 0.0f, -60.0f});
}

/// `name` and the options as the name of a parametrised test: letters, digits and underscores.
inline std::string case_name(std::string name, std::span<const OptionValue> options)
{
    for (const auto& [option, value] : options) {
        name += "_" + option + "_" + value;
    }
    for (char& c : name) {
        c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    }
    return name;
}

} // namespace occlude::test
