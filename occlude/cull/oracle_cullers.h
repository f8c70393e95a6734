// Two ideals to compare with: cullers that are told beforehand what is visible.
//
//   opt    draws exactly the leaves that an exact stop-and-wait pass found visible. Tests of this
//          hierarchy's boxes cannot draw less. Mattausch, Bittner, Wimmer 2008 compare with it. (It
//          is not the optimum of a cost model that other papers call OPT.)
//   ideal  draws exactly the items that own at least one pixel, and the translucent items in the
//          frustum, which own none. This is the exact visible set, which no test of boxes can
//          reach. The distance from opt to ideal is the looseness of the boxes.
//
// Guarantees  exact. cull() issues no test: record() finds the answer beforehand, untimed. If the
//             tree was replaced since then, both draw everything in the frustum.
#pragma once

#include <occlude/cull/culler.h>
#include <occlude/cull/parts/frustum_walk.h>
#include <occlude/cull/stop_and_wait.h>

#include <span>
#include <vector>

namespace occlude {

/// Cullers that must be told beforehand what is visible: call record() with the frame's view before
/// cull(). `opt` finds the visible leaves by an exact stop-and-wait pass on the device; `ideal`
/// takes the items that own a pixel from the caller.
class OracleCuller : public Culler {
public:
    using Culler::Culler;
    /// Finds the answer for `view`, untimed. `owners` are the items that own at least one pixel of
    /// an id buffer of this view; only `ideal` reads them.
    virtual void record(const View& view, QueryDevice& device, std::span<const ItemId> owners) = 0;
};

class Opt final : public OracleCuller {
public:
    static constexpr AlgorithmTraits kTraits{
        .name = "opt",
        .paper = "comparison",
        .summary = "draws the leaves that an exact pass found visible",
        .needs = {.visible_set = true},
        .remembers = false,
    };

    explicit Opt(HierarchyRef hierarchy)
        : OracleCuller(hierarchy)
        , pass_(hierarchy)
    {
    }

    /// Culls and draws one whole frame by stop-and-wait, and keeps its decisions.
    void record(const View& view, QueryDevice& device, std::span<const ItemId> owners) override;

private:
    void cull_frame(CullFrame& frame) override;
    void reset_state() override {} // the record is valid until the next record()

    StopAndWait pass_;
    FrustumWalk walk_;
    uint64_t recorded_structure_ = 0; ///< of the tree that pass_ decided about; 0: none
};

class Ideal final : public OracleCuller {
public:
    static constexpr AlgorithmTraits kTraits{
        .name = "ideal",
        .paper = "comparison",
        .summary = "draws the items that own a pixel",
        .needs = {.visible_set = true},
        .node_use = NodeUse::none,
        .remembers = false,
    };

    using OracleCuller::OracleCuller;

    /// Keeps `owners`, near to far.
    void record(const View& view, QueryDevice& device, std::span<const ItemId> owners) override;

private:
    void cull_frame(CullFrame& frame) override;
    void reset_state() override {} // the record is valid until the next record()

    void index_items();

    std::vector<ItemId> visible_;
    uint64_t visible_triangles_ = 0;
    FrustumWalk walk_;
    uint64_t recorded_structure_ = 0; ///< of the tree whose items are in `visible_`; 0: none
    std::vector<ItemPosition> position_of_item_; ///< by ItemId; invalid where no item has that id
    uint64_t indexed_structure_ = 0;
};

} // namespace occlude
