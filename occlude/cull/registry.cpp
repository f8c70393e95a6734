#include <occlude/cull/registry.h>

#include <occlude/core/option_text.h>
#include <occlude/cull/adaptive.h>
#include <occlude/cull/batch_and_wait.h>
#include <occlude/cull/chc.h>
#include <occlude/cull/chc_plus_plus.h>
#include <occlude/cull/frustum_culler.h>
#include <occlude/cull/lazy_grid.h>
#include <occlude/cull/next_frame.h>
#include <occlude/cull/oracle_cullers.h>
#include <occlude/cull/prioritized.h>
#include <occlude/cull/statistical.h>
#include <occlude/cull/stop_and_wait.h>
#include <occlude/cull/two_level.h>
#include <occlude/cull/two_phase.h>
#include <occlude/cull/uniform_grid.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <type_traits>

namespace occlude {

namespace {

struct NoOptions {};
template <class Visit>
void visit_options(NoOptions&, Visit&&)
{
}

// Whether these options count in time rather than in frames and triangles.
bool wants_clock(const PrioritizedOptions& options)
{
    return options.budget_time > 0.0;
}

bool wants_clock(const AdaptiveOptions& options)
{
    return options.measure;
}

bool wants_clock(const StatisticalOptions& options)
{
    return options.time == StatisticalOptions::Time::clock;
}

template <class CullerType, class Options>
Result<std::unique_ptr<Culler>> make(const Hierarchy& hierarchy,
                                     std::span<const OptionValue> values,
                                     [[maybe_unused]] SecondsClock clock)
{
    Options options;
    if (std::string problem = apply_options(options, values); !problem.empty()) {
        return Error{ErrorCode::invalid_argument, std::move(problem)};
    }
    if constexpr (std::is_same_v<Options, NoOptions>) {
        return std::unique_ptr<Culler>{std::make_unique<CullerType>(hierarchy)};
    } else if constexpr (std::constructible_from<CullerType, const Hierarchy&, Options,
                                                 SecondsClock>) {
        return std::unique_ptr<Culler>{std::make_unique<CullerType>(
            hierarchy, options, wants_clock(options) ? std::move(clock) : SecondsClock{})};
    } else {
        return std::unique_ptr<Culler>{std::make_unique<CullerType>(hierarchy, options)};
    }
}

// What an algorithm does with the nodes of the hierarchy.
enum class Tree {
    walks,     ///< it descends from node to node
    leaves,    ///< it tests leaves only: what lies in inner nodes it must draw
    no_use_of, ///< it takes the items alone, into cells of its own or as they are
};

// Those with items in inner nodes do not suit algorithms that test leaves only.
std::vector<std::string> suitable_hierarchies(Tree tree)
{
    std::vector<std::string> names;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        if (tree == Tree::walks || (tree == Tree::leaves && !kind.items_in_inner_nodes)) {
            names.emplace_back(kind.name);
        }
    }
    return names;
}

template <class CullerType, class Options = NoOptions>
AlgorithmInfo describe(std::string name, std::string paper, std::string summary, Needs needs,
                       Tree tree = Tree::walks)
{
    return {std::move(name),
            std::move(paper),
            std::move(summary),
            true,
            true,
            needs,
            suitable_hierarchies(tree),
            describe_options<Options>(),
            &make<CullerType, Options>};
}

std::vector<AlgorithmInfo> make_table()
{
    const Needs tests{.queries = true};
    const Needs answer{.visible_set = true};
    std::vector<AlgorithmInfo> table;
    table.push_back(
        describe<FrustumCuller>("frustum", "baseline", "draws everything in the view frustum", {}));
    table.push_back(describe<StopAndWait, StopAndWaitOptions>(
        "stop_and_wait", "baseline", "tests each node and waits for the answer", tests));
    table.push_back(describe<Chc, ChcOptions>(
        "chc", "Bittner, Wimmer, Piringer, Purgathofer 2004",
        "coherent hierarchical culling: draws visible leaves at once and tests them meanwhile",
        tests));
    table.push_back(describe<ChcPlusPlus, ChcPlusPlusOptions>(
        "chc_plus_plus", "Mattausch, Bittner, Wimmer 2008",
        "CHC with batched tests, multiqueries and tight bounds", tests));
    table.push_back(describe<TwoPhase, TwoPhaseOptions>(
        "two_phase", "Greene, Kass, Miller 1993; Haar, Aaltonen 2015",
        "draws what was visible last frame, then tests the rest against its depth on the CPU",
        Needs{.depth_read = true}));
    table.push_back(describe<Statistical, StatisticalOptions>(
        "statistical", "Kovalcik, Sochor 2005",
        "draws recently visible nodes untested, for longer the more often they were visible",
        tests));
    table.push_back(describe<LazyGrid, LazyGridOptions>(
        "lazy_grid", "Hey, Tobler, Purgathofer 2001",
        "compares boxes with the farthest depth of screen cells, which it updates on demand",
        {.depth_read = true}));
    table.push_back(describe<UniformGrid, UniformGridOptions>(
        "uniform_grid", "Hillesland, Salomon, Lastra, Manocha 2002",
        "tests the cells of a uniform or nested grid of its own, slab by slab", tests,
        Tree::no_use_of));
    table.push_back(describe<Prioritized, PrioritizedOptions>(
        "prioritized", "Klosowski, Silva 2000; Correa, Klosowski, Silva 2003",
        "draws first what is least likely hidden, until a budget is spent", tests,
        Tree::no_use_of));
    table.back().exact = PrioritizedOptions{}.finish;
    table.push_back(describe<TwoLevel, TwoLevelCullOptions>(
        "two_level", "Kovalcik, Tobola (two-level BSP)",
        "for moving objects: tests boxes apart on the screen together, and visible ones rarely",
        tests));
    table.push_back(describe<BatchAndWait, BatchAndWaitOptions>(
        "batch_and_wait", "Sekulic 2004, 29.3",
        "tests objects near to far: issues n queries, then reads n results", tests, Tree::leaves));
    table.push_back(describe<NextFrame, NextFrameOptions>(
        "next_frame", "Sekulic 2004, 29.4",
        "draws objects by the answers of the last frame: never waits, is late by a frame", tests,
        Tree::leaves));
    table.back().exact = false;
    table.push_back(describe<Adaptive, AdaptiveOptions>(
        "adaptive", "Guthe, Balazs, Klein 2006, with measured costs",
        "measures what drawing and testing cost, and tests only what pays; else as frustum", {}));
    table.push_back(describe<Opt>("opt", "comparison",
                                  "draws the leaves that an exact pass found visible", answer));
    table.push_back(describe<Ideal>("ideal", "comparison", "draws the items that own a pixel",
                                    answer, Tree::no_use_of));
    const std::array<std::string_view, 5> forgetful = {"frustum", "stop_and_wait", "lazy_grid",
                                                       "opt", "ideal"};
    for (AlgorithmInfo& info : table) {
        info.remembers =
            std::find(forgetful.begin(), forgetful.end(), info.name) == forgetful.end();
    }
    return table;
}

} // namespace

std::span<const AlgorithmInfo> algorithms()
{
    static const std::vector<AlgorithmInfo> table = make_table();
    return table;
}

const AlgorithmInfo* find_algorithm(std::string_view name)
{
    for (const AlgorithmInfo& info : algorithms()) {
        if (info.name == name) {
            return &info;
        }
    }
    return nullptr;
}

Result<std::unique_ptr<Culler>> make_culler(std::string_view name, HierarchyRef hierarchy,
                                            std::span<const OptionValue> options,
                                            SecondsClock clock)
{
    const AlgorithmInfo* info = find_algorithm(name);
    if (info == nullptr) {
        std::string names;
        for (const AlgorithmInfo& known : algorithms()) {
            names += (names.empty() ? "" : ", ") + known.name;
        }
        return Error{ErrorCode::not_found,
                     "there is no algorithm '" + std::string{name} + "'; there are " + names};
    }
    auto culler = info->make(hierarchy, options, std::move(clock));
    if (!culler) {
        return Error{culler.error().code, info->name + ": " + culler.error().message};
    }
    return culler;
}

} // namespace occlude
