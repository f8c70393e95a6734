// The cases of invariants_test.cpp: every algorithm with the options that change its decisions, on
// every kind of hierarchy.
#pragma once

#include "support/walks.h"

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace occlude::test::invariants {

struct Case {
    std::string algorithm;
    std::vector<OptionValue> options;
    std::string hierarchy = "bvh";
};

inline std::string name_of(const ::testing::TestParamInfo<Case>& info)
{
    return test::case_name(info.param.hierarchy + "_" + info.param.algorithm, info.param.options);
}

inline const std::vector<Case>& cases()
{
    static const std::vector<Case> all{
        {"stop_and_wait", {}},
        {"batch_and_wait", {}},
        {"batch_and_wait", {{"batch_size", "0"}}},
        {"batch_and_wait", {{"skip_triangles_below", "150"}, {"occluder_share", "0.3"}}},
        {"chc", {}},
        {"chc", {{"visible_test", "geometry"}}},
        {"chc", {{"assume_visible_frames", "5"}}},
        {"chc_plus_plus", {}},
        {"chc_plus_plus", {{"batch_size", "1"}}},
        {"chc_plus_plus", {{"v_queue", "false"}}},
        {"chc_plus_plus", {{"v_fill", "1"}}},
        {"chc_plus_plus", {{"render_queue", "false"}}},
        {"chc_plus_plus", {{"min_render_triangles", "5000"}}},
        {"chc_plus_plus", {{"assume_visible_frames", "1"}, {"jitter", "false"}}},
        {"chc_plus_plus", {{"tight_bounds_depth", "0"}}},
        {"chc_plus_plus", {{"virtual_leaves", "false"}}},
        {"chc_plus_plus", {{"multiqueries", "off"}}},
        {"chc_plus_plus", {{"multiqueries", "analytic"}}},
        {"chc_plus_plus", {{"depth_only_pass", "true"}}},
        {"uniform_grid", {{"cell_triangles", "500"}}},
        {"uniform_grid", {{"cell_triangles", "2000"}, {"nested_levels", "0"}}},
        {"uniform_grid", {{"cell_triangles", "4000"}, {"nested_levels", "2"}}},
        {"prioritized", {{"finish", "true"}, {"budget_triangles", "5000"}}},
        {"prioritized",
         {{"finish", "true"},
          {"budget_triangles", "1"},
          {"cell_triangles", "300"},
          {"batch_size", "7"}}},
        {"two_phase", {}},
        {"two_phase", {{"virtual_leaves", "true"}, {"refine", "false"}}},
        {"two_phase", {{"reread_triangles", "1000"}, {"final_depth", "true"}}},
        {"adaptive", {}},
        {"adaptive", {{"method", "draw_all"}}},
        {"adaptive", {{"method", "queries"}}},
        {"adaptive", {{"method", "raster"}}},
        {"adaptive", {{"method", "pyramid"}}},
        {"two_level", {}},
        {"two_level", {{"disjoint", "false"}}},
        {"two_level", {{"multiqueries", "false"}}},
        {"two_level", {{"max_pending", "1"}}},
        {"two_level", {{"history_length", "1"}, {"spread", "false"}}},
        {"two_level", {{"max_postponed", "0"}}},
        {"statistical", {}},
        {"statistical", {{"issue", "at_place"}}},
        {"statistical", {{"results", "oldest"}}},
        {"statistical", {{"max_in_flight", "1"}}},
        {"statistical", {{"spread", "0"}, {"history", "1"}}},
        {"statistical", {{"base_time", "0"}}},
        {"statistical", {{"base_time", "0.05"}, {"max_age", "0.5"}}},
    };
    return all;
}

// Each case on each kind of hierarchy.
inline std::vector<Case> cases_on_every_hierarchy()
{
    std::vector<Case> all;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        for (const Case& c : cases()) {
            all.push_back({c.algorithm, c.options, std::string{kind.name}});
        }
    }
    return all;
}

// True for algorithms that test the cells of their own grid instead of nodes.
inline bool tests_cells(const Case& c)
{
    return c.algorithm == "uniform_grid" || c.algorithm == "prioritized";
}

inline bool has_option(const Case& c, const char* name, const char* value)
{
    return std::ranges::count(c.options, OptionValue{name, value}) > 0;
}

// True for `adaptive` where it tests on the device: the answers for visible nodes are for later
// frames.
inline bool tests_for_later_frames(const Case& c)
{
    return c.algorithm == "adaptive" && !has_option(c, "method", "draw_all") &&
           !has_option(c, "method", "pyramid");
}

inline std::vector<Case> cases_with_queries()
{
    std::vector<Case> cases = cases_on_every_hierarchy();
    std::erase_if(cases, [](const Case& c) {
        const bool tests_nodes = find_algorithm(c.algorithm)->needs.queries && !tests_cells(c);
        const bool told_to =
            has_option(c, "method", "queries") || has_option(c, "method", "raster");
        return !tests_nodes && !told_to;
    });
    return cases;
}

// Tests for later frames have no consequence until their answers arrive, so that latency changes
// what is drawn first.
inline std::vector<Case> cases_that_wait_for_every_answer()
{
    std::vector<Case> cases = cases_on_every_hierarchy();
    std::erase_if(cases, tests_for_later_frames);
    return cases;
}

} // namespace occlude::test::invariants
