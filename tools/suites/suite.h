// Named sets of benchmarks, for `occlude bench --suite`: what is measured, on which scenes and how.
#pragma once

#include "options/options.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools {

/// The size of the scenes of a suite: as published, or so small that a suite takes minutes.
enum class Scale { small, full };

/// "small" or "full".
std::string_view to_string(Scale scale);

/// One scene and path with the algorithms that walk along it.
struct SuiteEntry {
    std::string name; ///< "plant_bsp", for --only and in the results
    std::string scene;
    std::string algorithms; ///< as --algorithms; the algorithms to compare with run too
    StageOptions stage;
    size_t sample_every = 1; ///< MeasureOptions
    size_t verify_every = 1; ///< MeasureOptions: of the measured frames
};

struct Suite {
    std::string_view name;
    std::string_view description;
    std::vector<SuiteEntry> (*entries)(Scale scale);
    bool has_papers = false; ///< its results are set beside published figures
};

/// All suites.
std::span<const Suite> suites();

/// The suite of that name, or null.
const Suite* find_suite(std::string_view name);

/// "papers, quick, trees".
std::string suite_names();

} // namespace occlude::tools
