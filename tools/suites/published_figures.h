// The figures that the papers print, each with the way to read the same quantity off our results.
#pragma once

#include "suites/findings.h"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools {

struct Paper {
    std::string_view key;      ///< "STAT05"
    std::string_view citation; ///< authors, title, year
    std::string_view setting;  ///< their machine, and the runs of ours that correspond to theirs
};
std::span<const Paper> papers();

struct PublishedFigure {
    std::string_view paper; ///< a key of papers()
    std::string scene;      ///< as the paper calls it
    std::string what;
    std::string published;
    Target target;
    std::function<Finding(const SuiteResults&, const Target&)> find;
};

/// Every figure, in the order of the papers.
const std::vector<PublishedFigure>& published_figures();

} // namespace occlude::tools
