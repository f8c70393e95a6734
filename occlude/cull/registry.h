// Every algorithm by name, with its options by name: what `occlude list`, `--algorithms` and
// `--set` are made of.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/core/option_text.h>
#include <occlude/core/result.h>
#include <occlude/cull/culler.h>

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace occlude {

/// What an algorithm needs beyond drawing and testing.
struct Needs {
    bool queries = false;     ///< asks the device tests
    bool depth_read = false;  ///< reads the depth buffer
    bool visible_set = false; ///< must be told the answer beforehand (`opt`, `ideal`)
};

struct AlgorithmInfo {
    std::string name;
    std::string paper; ///< who published it, or "baseline"
    std::string summary;
    bool exact = true;     ///< with its default options
    bool remembers = true; ///< what it saw in a frame changes what it does in later ones
    Needs needs;
    /// The kinds of hierarchies that suit it (hierarchy_kinds.h), in their order; on the others it
    /// is right, but not what it could be. Empty: it makes no use of nodes, and all kinds are
    /// alike.
    std::vector<std::string> hierarchies;
    std::vector<OptionInfo> options;
    Result<std::unique_ptr<Culler>> (*make)(const Hierarchy&, std::span<const OptionValue>,
                                            SecondsClock) = nullptr;
};

/// All algorithms, in the order in which tables show them.
std::span<const AlgorithmInfo> algorithms();

/// The algorithm of that name, or null.
const AlgorithmInfo* find_algorithm(std::string_view name);

/// A culler by name. `clock` is for options that count in time (`prioritized.budget_time`,
/// `statistical.time`) and for `adaptive`, which measures by it; it is not asked otherwise, so that
/// runs repeat, and without it they do nothing. Errors name the unknown algorithm or option and
/// list what there is.
Result<std::unique_ptr<Culler>> make_culler(std::string_view name, HierarchyRef hierarchy,
                                            std::span<const OptionValue> options = {},
                                            SecondsClock clock = {});

/// Cullers that must be told beforehand what is visible derive from this too: call record() with
/// the frame's view before the frame is culled. `opt` finds the leaves by an exact stop-and-wait
/// pass on the device; `ideal` is told the items that own a pixel.
class OracleCuller : public Culler {
public:
    using Culler::Culler;
    /// Finds the answer for `view` (untimed). `owners` are the items that own at least one pixel of
    /// an id buffer of this view; only `ideal` reads them.
    virtual void record(const View& view, QueryDevice& device, std::span<const ItemId> owners) = 0;
};

} // namespace occlude
