// Mistakes in integrations, one of which can be switched on: --bug NAME. The library must report
// each, and the tests run all of them.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace gl_engine {

enum class Bug {
    none,
    box_too_small,
    forgotten_refit,
    depth_convention,
    swapped_size,
    transposed_matrix,
    depth_writes_in_tests,
    query_left_open,
    conditional_rendering,
    scissor,
    polygon_mode,
    dynamic_resolution,
    recreated_context,
    standing_clock,
};

inline constexpr std::array<std::string_view, 14> kBugNames{
    "none",
    "box-too-small",
    "forgotten-refit",
    "depth-convention",
    "swapped-size",
    "transposed-matrix",
    "depth-writes-in-tests",
    "query-left-open",
    "conditional-rendering",
    "scissor",
    "polygon-mode",
    "dynamic-resolution",
    "recreated-context",
    "standing-clock",
};

inline std::optional<Bug> bug_by_name(std::string_view name)
{
    for (size_t i = 0; i < kBugNames.size(); ++i) {
        if (kBugNames[i] == name) {
            return static_cast<Bug>(i);
        }
    }
    return std::nullopt;
}

} // namespace gl_engine
