#include <occlude/cull/parts/hierarchy_cut.h>

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

} // namespace occlude
