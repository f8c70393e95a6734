#include "load/loaded_scene.h"

namespace occlude::tools {

LeftOut& LeftOut::operator+=(const LeftOut& other)
{
    points += other.points;
    lines += other.lines;
    degenerate += other.degenerate;
    non_finite += other.non_finite;
    masked_away += other.masked_away;
    return *this;
}

} // namespace occlude::tools
