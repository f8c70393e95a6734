#include "suites/entries.h"

namespace occlude::tools {

static SuiteEntry entry(std::string name, std::string scene, std::string hierarchy,
                        std::string path)
{
    SuiteEntry entry;
    entry.name = std::move(name);
    entry.scene = std::move(scene);
    entry.algorithms = "all";
    entry.stage.hierarchy = std::move(hierarchy);
    entry.stage.sets = {"adaptive.measure=false"}; // so that its runs repeat
    entry.stage.path = std::move(path);
    entry.stage.size = {640, 360};
    entry.stage.frames = 24;
    return entry;
}

std::vector<SuiteEntry> quick_entries(Scale)
{
    return {entry("city_street", "city:triangles=1m", "bvh", "street"),
            entry("city_cuts", "city:triangles=300k,blocks=8", "bsp", "teleport"),
            entry("boxes", "boxes:count=2000", "octree", "auto"),
            entry("movers", "movers:count=500,triangles=200k", "two_level", "auto"),
            entry("bunnies", "bunnies:count=40,triangles=4k", "bvh", "auto")};
}

} // namespace occlude::tools
