#include "scenes/walk_path.h"

namespace occlude::tools {

std::vector<Keyframe> find_walk(const SceneModel& model)
{
    (void)model;
    return {};
}

} // namespace occlude::tools
