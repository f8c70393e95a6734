// Every reader of foreign data, as a function of bytes. Whatever the bytes are, it must not crash,
// hang or take memory without limit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace occlude::fuzz {

using Bytes = std::span<const uint8_t>;

void path_file(Bytes bytes);
void results(Bytes bytes);
void device_recording(Bytes bytes);
void run_recording(Bytes bytes);
void scene(Bytes bytes);        ///< the first byte chooses the format
void command_line(Bytes bytes); ///< one argument a line

struct Target {
    std::string_view name; ///< also of the folder of its corpus
    void (*run)(Bytes);
};

inline constexpr std::array kTargets{
    Target{"path_file", path_file},
    Target{"results", results},
    Target{"device_recording", device_recording},
    Target{"run_recording", run_recording},
    Target{"scene", scene},
    Target{"command_line", command_line},
};

} // namespace occlude::fuzz
