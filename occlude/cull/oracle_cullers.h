// The two ideals to compare with: what a culler could reach that knew the answer beforehand.
//
//   opt    draws exactly the leaves that an exact stop-and-wait pass found visible: the least that
//          tests of this hierarchy's boxes can draw. (Mattausch, Bittner, Wimmer 2008 compare with
//          it; it is not the optimum of a cost model that other papers call OPT.)
//   ideal  draws exactly the items that own at least one pixel: the exact visible set, which no box
//          can reach; and the translucent items in the frustum, which own none. The distance from
//          opt to ideal is the looseness of the boxes.
//
// Guarantees  exact. Neither issues a test in cull(); record() finds the answer beforehand,
//             untimed. If the tree was replaced since, both draw everything in the frustum.
#pragma once

#include <occlude/cull/culler.h>
#include <occlude/cull/parts/frustum_walk.h>
#include <occlude/cull/stop_and_wait.h>

#include <span>
#include <vector>

namespace occlude {

/// Cullers that must be told beforehand what is visible: call record() with the frame's view before
/// the frame is culled. `opt` finds the leaves by an exact stop-and-wait pass on the device;
/// `ideal` is told the items that own a pixel.
class OracleCuller : public Culler {
public:
    using Culler::Culler;
    /// Finds the answer for `view` (untimed). `owners` are the items that own at least one pixel of
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

    /// Culls and draws one whole frame by stop-and-wait, and remembers its decisions.
    void record(const View& view, QueryDevice& device, std::span<const ItemId> owners) override;

private:
    void cull_frame(CullFrame& frame) override;
    void reset_state() override {} // what was recorded is good until the next record()

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

    /// Remembers `owners`, near to far.
    void record(const View& view, QueryDevice& device, std::span<const ItemId> owners) override;

private:
    void cull_frame(CullFrame& frame) override;
    void reset_state() override {} // what was recorded is good until the next record()

    void index_items();

    std::vector<ItemId> visible_;
    uint64_t visible_triangles_ = 0;
    FrustumWalk walk_;
    uint64_t recorded_structure_ = 0; ///< of the tree that `visible_` are items of; 0: none
    std::vector<ItemPosition> position_of_item_; ///< by ItemId; invalid for an id of no item
    uint64_t indexed_structure_ = 0;
};

} // namespace occlude
