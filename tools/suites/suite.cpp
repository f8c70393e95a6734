#include "suites/suite.h"

#include "suites/entries.h"

#include <algorithm>
#include <array>

namespace occlude::tools {

std::string_view to_string(Scale scale)
{
    return scale == Scale::full ? "full" : "small";
}

std::span<const Suite> suites()
{
    static constexpr std::array<Suite, 3> kSuites{
        Suite{"papers", "the experiments of the papers, beside their published figures",
              papers_entries, true},
        Suite{"quick", "all algorithms on small scenes, every pixel compared: about a minute",
              quick_entries, false},
        Suite{"trees", "kinds of trees and sizes of leaves, beside each other", trees_entries,
              false}};
    return kSuites;
}

const Suite* find_suite(std::string_view name)
{
    const auto found = std::find_if(suites().begin(), suites().end(),
                                    [&](const Suite& suite) { return suite.name == name; });
    return found != suites().end() ? &*found : nullptr;
}

std::string suite_names()
{
    std::string names;
    for (const Suite& suite : suites()) {
        names += names.empty() ? "" : ", ";
        names += suite.name;
    }
    return names;
}

} // namespace occlude::tools
