// An ordered list of nodes that are still to be decided, in which the children of a node take its
// place. Doubly linked over one vector, so that positions stay valid while others come and go.
#pragma once

#include <occlude/core/assert.h>
#include <occlude/core/frustum.h>
#include <occlude/core/ids.h>

#include <cstdint>
#include <vector>

namespace occlude {

class NodeList {
public:
    using Position = uint32_t;

    struct Entry {
        NodeId node;
        PlaneMask mask = Frustum::kAllPlanes;
        bool pending = false; ///< its test is under way: it only keeps the place for its children
        Position previous = 0;
        Position next = 0;
    };

    /// Empties the list; keeps its memory.
    void clear() { entries_.assign(1, Entry{}); } // the end is an entry, so that it has a position

    bool empty() const { return begin() == end(); }
    Position begin() const { return entries_.front().next; }
    static constexpr Position end() { return 0; }
    Position next(Position at) const
    {
        OCCLUDE_ASSERT(at < entries_.size(), "the position belongs to another frame");
        return entries_[at].next;
    }
    Entry& operator[](Position at) { return entries_[at]; }

    /// Adds a node before `at` and returns its position.
    Position insert_before(Position at, NodeId node, PlaneMask mask)
    {
        const auto here = static_cast<Position>(entries_.size());
        const Position previous = entries_[at].previous;
        entries_.push_back({node, mask, false, previous, at});
        entries_[previous].next = here;
        entries_[at].previous = here;
        return here;
    }

    /// Takes an entry out and returns the position after it. Its memory is reused after clear().
    Position erase(Position at)
    {
        OCCLUDE_ASSERT(at != end() && at < entries_.size(), "the end of the list cannot be erased");
        const auto [previous, next] = std::pair{entries_[at].previous, entries_[at].next};
        entries_[previous].next = next;
        entries_[next].previous = previous;
        return next;
    }

private:
    std::vector<Entry> entries_ = std::vector<Entry>(1);
};

} // namespace occlude
