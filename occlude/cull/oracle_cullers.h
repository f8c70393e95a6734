// The two ideals to compare with: what a culler could reach that knew the answer beforehand.
//
//   opt    draws exactly the leaves that an exact stop-and-wait pass found visible. It bounds what
//   any
//          box test over this hierarchy can reach. (Mattausch, Bittner, Wimmer 2008 compare with
//          it; it is not the optimum of a cost model that other papers call OPT.)
//   ideal  draws exactly the items that own at least one pixel: the exact visible set, which no box
//          can reach; and the translucent items in the frustum, which own none. The distance from
//          opt to ideal is the looseness of the boxes.
//
// Guarantees  exact. Neither issues a test in cull(); record() finds the answer beforehand,
// untimed.
#pragma once

#include <occlude/cull/registry.h>
#include <occlude/cull/stop_and_wait.h>

#include <vector>

namespace occlude {

class Opt final : public OracleCuller {
public:
    explicit Opt(const Hierarchy& hierarchy)
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
};

class Ideal final : public OracleCuller {
public:
    using OracleCuller::OracleCuller;

    /// Remembers `owners`, near to far.
    void record(const View& view, QueryDevice& device, std::span<const ItemId> owners) override;

private:
    void cull_frame(CullFrame& frame) override;
    void reset_state() override {} // what was recorded is good until the next record()

    void index_items();

    std::vector<ItemId> visible_;
    uint64_t visible_triangles_ = 0;
    std::vector<uint32_t> position_of_item_; ///< of each ItemId in Hierarchy::items()
    uint64_t indexed_structure_ = 0;
};

} // namespace occlude
