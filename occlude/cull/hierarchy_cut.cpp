#include <occlude/cull/hierarchy_cut.h>

#include <bit>

namespace occlude {

void HierarchyCut::reset(const Hierarchy& hierarchy)
{
    next_.clear();
    entries_.assign(1, Entry{hierarchy.root()});
}

void HierarchyCut::clear()
{
    entries_.clear();
    next_.clear();
}

void HierarchyCut::start_counting()
{
    parents_.assign(std::bit_ceil(2 * next_.size() + 1), {});
    parent_of_.resize(next_.size());
}

uint32_t HierarchyCut::find(NodeId parent)
{
    const auto mask = static_cast<uint32_t>(parents_.size() - 1);
    uint32_t place = (parent.value * 2654435769u) >> 7 & mask; // Fibonacci hashing
    while (parents_[place].node.valid() && parents_[place].node != parent) {
        place = (place + 1) & mask;
    }
    parents_[place].node = parent;
    return place;
}

} // namespace occlude
