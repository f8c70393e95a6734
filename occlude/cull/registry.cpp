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

#include <concepts>

namespace occlude {

namespace {

template <class CullerType>
Result<std::unique_ptr<Culler>> make(const Hierarchy& hierarchy,
                                     std::span<const OptionValue> values,
                                     [[maybe_unused]] SecondsClock clock)
{
    using Options = typename CullerType::Options;
    Options options;
    if (std::string problem = apply_options(options, values); !problem.empty()) {
        return Error{ErrorCode::invalid_argument, std::move(problem)};
    }
    std::unique_ptr<Culler> culler;
    if constexpr (std::constructible_from<CullerType, const Hierarchy&, Options, SecondsClock>) {
        culler = std::make_unique<CullerType>(hierarchy, options, std::move(clock));
    } else if constexpr (std::constructible_from<CullerType, const Hierarchy&, Options>) {
        culler = std::make_unique<CullerType>(hierarchy, options);
    } else {
        culler = std::make_unique<CullerType>(hierarchy);
    }
    return culler;
}

// The kinds of trees that suit an algorithm with this use of nodes.
std::vector<std::string> suitable_hierarchies(NodeUse use)
{
    std::vector<std::string> names;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        if (use == NodeUse::walks || (use == NodeUse::leaves && !kind.items_in_inner_nodes)) {
            names.emplace_back(kind.name);
        }
    }
    return names;
}

template <class CullerType>
AlgorithmInfo describe()
{
    constexpr AlgorithmTraits traits = CullerType::kTraits;
    return {.name = std::string{traits.name},
            .paper = std::string{traits.paper},
            .summary = std::string{traits.summary},
            .exact = traits.exact,
            .remembers = traits.remembers,
            .needs = traits.needs,
            .hierarchies = suitable_hierarchies(traits.node_use),
            .options = describe_options<typename CullerType::Options>(),
            .make = &make<CullerType>};
}

// One line per algorithm, in the order in which tables show them.
std::vector<AlgorithmInfo> make_table()
{
    std::vector<AlgorithmInfo> table;
    table.push_back(describe<FrustumCuller>());
    table.push_back(describe<StopAndWait>());
    table.push_back(describe<Chc>());
    table.push_back(describe<ChcPlusPlus>());
    table.push_back(describe<TwoPhase>());
    table.push_back(describe<Statistical>());
    table.push_back(describe<LazyGrid>());
    table.push_back(describe<UniformGrid>());
    table.push_back(describe<Prioritized>());
    table.push_back(describe<TwoLevel>());
    table.push_back(describe<BatchAndWait>());
    table.push_back(describe<NextFrame>());
    table.push_back(describe<Adaptive>());
    table.push_back(describe<Opt>());
    table.push_back(describe<Ideal>());
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
