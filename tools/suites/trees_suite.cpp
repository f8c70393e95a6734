#include "suites/entries.h"

namespace occlude::tools {

namespace {

// All trees of one entry are measured in one run.
SuiteEntry entry(Scale scale, std::string name, const char* full, const char* small,
                 std::string path)
{
    SuiteEntry entry;
    entry.name = std::move(name);
    entry.scene = scale == Scale::full ? full : small;
    entry.algorithms = "frustum,chc,chc_plus_plus,adaptive";
    entry.stage.hierarchy.clear();
    for (const char* kind : {"bvh", "bsp", "octree", "grid", "two_level"}) {
        for (const char* leaf : {"256", "1024", "4096"}) {
            entry.stage.hierarchy += entry.stage.hierarchy.empty() ? "" : ",";
            entry.stage.hierarchy += std::string{kind} + ":leaf_triangles=" + leaf;
        }
    }
    entry.stage.path = std::move(path);
    entry.stage.size = {960, 540};
    entry.stage.frames = 40;
    entry.sample_every = 4;
    entry.verify_every = 10;
    return entry;
}

} // namespace

std::vector<SuiteEntry> trees_entries(Scale scale)
{
    return {entry(scale, "city", "city:triangles=34m", "city:triangles=4m", "street"),
            entry(scale, "vienna", "vienna", "vienna:triangles=2m", "street"),
            entry(scale, "boxes", "boxcity:count=40000", "boxcity:count=10000", "street"),
            entry(scale, "plant", "plant:triangles=2m", "plant:triangles=600k,objects=500", "auto"),
            entry(scale, "library", "library", "library:books=10000", "auto"),
            entry(scale, "forest", "forest", "forest:triangles=600k,trees=3500", "auto"),
            entry(scale, "teapots", "teapots:count=5000,triangles=2304",
                  "teapots:count=2000,triangles=1000", "auto"),
            entry(scale, "movers", "movers:count=2000", "movers:count=500,triangles=200k", "auto")};
}

} // namespace occlude::tools
