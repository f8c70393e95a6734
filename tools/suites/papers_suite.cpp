#include "suites/entries.h"

namespace occlude::tools {

namespace {

// The two sizes of one experiment: the published one, and one for daily use.
struct Sizes {
    std::string full;
    std::string small;
};

SuiteEntry walk(Scale scale, std::string name, const Sizes& scene, std::string path,
                std::string algorithms)
{
    SuiteEntry entry;
    entry.name = std::move(name);
    entry.scene = scale == Scale::full ? scene.full : scene.small;
    entry.algorithms = std::move(algorithms);
    entry.stage.path = std::move(path);
    entry.stage.frames = scale == Scale::full ? 240 : 120;
    // Papers leave their sizes out or had this one. In software each pixel is expensive, unlike on
    // their hardware: larger images would measure shading, which costs all algorithms the same.
    entry.stage.size = {640, 480};
    // A frame without culling takes seconds at full scale, and 30 of them show as much as 240.
    entry.sample_every = scale == Scale::full ? 8 : 6;
    entry.verify_every = scale == Scale::full ? 6 : 5;
    return entry;
}

// Kovalcik, Sochor 2005: an axis-aligned BSP tree, and a static scene that is flown through. Their
// tree puts small objects into small cells; here meshes are divided between triangles, for tight
// boxes.
SuiteEntry statistical(Scale scale, std::string name, const Sizes& scene, uint32_t part_triangles)
{
    SuiteEntry entry = walk(scale, std::move(name), scene, "auto",
                            "frustum,stop_and_wait,statistical,chc_plus_plus");
    entry.stage.hierarchy = "bsp";
    entry.stage.item_triangles = part_triangles;
    entry.stage.leaf_triangles = part_triangles;
    return entry;
}

// Here many parts straddle each plane. They become a child of their own, to be tested like the
// sides. In the node itself they would be drawn whenever something of it is visible.
void test_what_straddles(SuiteEntry& entry)
{
    entry.stage.sets = {"bsp.straddling=child"};
}

// The plant, from an aisle with the whole plant ahead, 9 cm per frame at full scale.
void go_through_the_plant(SuiteEntry& entry)
{
    entry.stage.path = "through";
    entry.stage.frames *= 2;
    entry.sample_every *= 2;
}

// Parts of 64 triangles: larger parts mostly show beside the pipes that hide them. `frustum` is as
// fast with these as with 128.
SuiteEntry statistical_plant(Scale scale, const Sizes& scene)
{
    SuiteEntry entry = statistical(scale, "plant_2m", scene, 64);
    entry.stage.leaf_triangles = 256;
    test_what_straddles(entry);
    go_through_the_plant(entry);
    return entry;
}

// The teapots, with the whole heap ahead.
SuiteEntry statistical_teapots(Scale scale, const Sizes& scene)
{
    SuiteEntry entry = statistical(scale, "teapots", scene, scale == Scale::full ? 2048 : 512);
    test_what_straddles(entry);
    entry.stage.path = "drift";
    entry.stage.frames = 120;
    return entry;
}

// Kovalcik, Tobola 2006: the two-level tree over meshes that planes cut into parts.
SuiteEntry two_level(Scale scale, std::string name, const Sizes& scene, uint32_t part_triangles)
{
    SuiteEntry entry = walk(scale, std::move(name), scene, "auto",
                            "frustum,stop_and_wait,two_level,chc_plus_plus");
    entry.stage.hierarchy = "two_level";
    entry.stage.split = "exact";
    entry.stage.item_triangles = part_triangles;
    return entry;
}

// With parts of 2048 triangles `frustum` is as fast, but drawing the visible parts takes an eighth
// longer.
SuiteEntry two_level_plant(Scale scale, const Sizes& scene)
{
    SuiteEntry entry = two_level(scale, "plant_13m", scene, scale == Scale::full ? 1024 : 512);
    go_through_the_plant(entry);
    return entry;
}

// The same for the moving bunnies, which move by up to 1.5% of their size per frame, while the eye
// goes a third of the way around them, 5 cm per frame.
SuiteEntry bunnies_in_motion(Scale scale, const Sizes& scene, uint32_t part_triangles)
{
    SuiteEntry entry = two_level(scale, "bunnies", scene, part_triangles);
    entry.algorithms = "frustum,stop_and_wait,two_level";
    entry.stage.path = "pass";
    entry.stage.leaf_triangles = part_triangles;
    // A test is cheap where triangles are expensive: on the paper's hardware 14,408 tests took over
    // two seconds. A larger image reduces this difference.
    entry.stage.size = {1024, 768};
    entry.stage.frames = 240;
    entry.sample_every = 12;
    entry.verify_every = 12;
    return entry;
}

// Hey, Tobler, Purgathofer 2001: cells of 32 pixels, and boxes of at most 1500 triangles. Smaller
// boxes are better for lazy and busy; `frustum` culls item by item, so that they do not affect it.
// Boxes are tested by their faces. Many tests wait for pixels at once, which are read in rows of
// cells. If a box covers an eighth of a border cell, the whole cell is read (section 6).
SuiteEntry lazy_grid(Scale scale, std::string name, const Sizes& scene, std::string path,
                     glm::ivec2 size)
{
    SuiteEntry entry = walk(scale, std::move(name), scene, std::move(path),
                            "frustum,lazy_grid,lazy_grid:update=busy,chc_plus_plus");
    entry.stage.size = size;
    entry.stage.leaf_triangles = 64;
    entry.stage.item_triangles = 128;
    entry.stage.sets = {"lazy_grid.cell_size=32", "lazy_grid.bounds=faces",
                        "lazy_grid.tests_at_once=96", "lazy_grid.whole_cell_share=0.125",
                        "lazy_grid.join=rows"};
    return entry;
}

// Bittner, Mattausch, Wimmer 2008: CHC++ with and without its last two extensions.
SuiteEntry chc_plus_plus(Scale scale, std::string name, const Sizes& scene, std::string path)
{
    SuiteEntry entry = walk(scale, std::move(name), scene, std::move(path),
                            "frustum,stop_and_wait,chc,chc_plus_plus,"
                            "chc_plus_plus:multiqueries=off:tight_bounds_depth=0");
    entry.stage.leaf_triangles = 128; // CHC++ is designed for many visible leaves
    entry.stage.item_triangles = 512;
    return entry;
}

// A case where boxes are larger than their contents: every algorithm that tests boxes draws more
// than is visible. The difference between `opt`, which tests perfectly, and `ideal` is beyond any
// test of boxes.
SuiteEntry hollow(Scale scale, std::string name, const Sizes& scene)
{
    return walk(scale, std::move(name), scene, "pass",
                "frustum,stop_and_wait,chc_plus_plus,lazy_grid");
}

// Sekulic 2004: one test per object.
SuiteEntry objects(Scale scale, std::string name, const Sizes& scene)
{
    return walk(scale, std::move(name), scene, "auto",
                "frustum,batch_and_wait,next_frame,chc_plus_plus");
}

// ... teapots in one piece.
SuiteEntry teapot_objects(Scale scale, const Sizes& scene)
{
    constexpr uint32_t kMoreThanATeapotHas = 8192;
    SuiteEntry entry = objects(scale, "teapot_objects", scene);
    entry.stage.item_triangles = kMoreThanATeapotHas;
    entry.stage.leaf_triangles = kMoreThanATeapotHas;
    entry.stage.path = "drift";
    entry.stage.frames = 60;
    return entry;
}

} // namespace

std::vector<SuiteEntry> papers_entries(Scale scale)
{
    const Sizes plant{"plant:triangles=2m", "plant:triangles=600k,objects=500"};
    const Sizes library{"library", "library:books=10000"};
    const Sizes teapots{"teapots:count=5000,triangles=6400", "teapots:count=2000,triangles=1000"};
    const Sizes large_plant{"plant:triangles=13m", "plant:triangles=1200k"};
    const Sizes bunnies{"bunnies", "bunnies:count=100,triangles=7k"};
    const Sizes forest{"forest", "forest:triangles=600k,trees=3500"};
    const Sizes city{"city:triangles=34m,blocks=64", "city:triangles=4m,blocks=24"};
    const Sizes vienna{"vienna", "vienna:triangles=2m"};
    const glm::ivec2 low{640, 480};
    const glm::ivec2 high{1280, 960};
    return {statistical_plant(scale, plant),
            statistical(scale, "library", library, 512),
            statistical_teapots(scale, teapots),
            two_level_plant(scale, large_plant),
            bunnies_in_motion(scale, bunnies, scale == Scale::full ? 1000 : 200),
            lazy_grid(scale, "forest_640", forest, "auto", low),
            lazy_grid(scale, "forest_1280", forest, "auto", high),
            lazy_grid(scale, "city_640", city, "street", low),
            lazy_grid(scale, "city_1280", city, "street", high),
            chc_plus_plus(scale, "city_street", city, "street"),
            chc_plus_plus(scale, "city_rise", city, "rise"),
            chc_plus_plus(scale, "vienna_street", vienna, "street"),
            chc_plus_plus(scale, "vienna_rise", vienna, "rise"),
            objects(scale, "boxes_12",
                    {"boxcity:count=40000,triangles=12", "boxcity:count=4000,triangles=12"}),
            objects(scale, "boxes_252",
                    {"boxcity:count=40000,triangles=252", "boxcity:count=4000,triangles=252"}),
            teapot_objects(scale, teapots),
            hollow(scale, "pyramids", {"pyramids:count=4000", "pyramids"}),
            hollow(scale, "rings", {"rings:count=4000", "rings"})};
}

} // namespace occlude::tools
