#include "generate/boxcity_generator.h"
#include "generate/boxes_generator.h"
#include "generate/bunnies_generator.h"
#include "generate/city_generator.h"
#include "generate/forest_generator.h"
#include "generate/hollow_generators.h"
#include "generate/library_generator.h"
#include "generate/moving_generators.h"
#include "generate/parameters.h"
#include "generate/plant_generator.h"
#include "generate/scene_source.h"
#include "generate/teapots_generator.h"
#include "generate/vienna_generator.h"
#include "load/assimp_loader.h"
#include "model/exact_split.h"
#include "model/mesh_tools.h"
#include "model/scene_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace occlude::tools {
namespace {

Result<SceneModel> make_city(std::string_view source, std::string_view text,
                             const SceneOptions& options)
{
    CityOptions city;
    uint64_t blocks = city.blocks;
    const std::array parameters{
        Parameter{"blocks", &blocks, 1, 64},
        Parameter{"seed", &city.seed, 0, kMostSeed},
        Parameter{"triangles", &city.triangles, 1000, 200000000},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    city.blocks = static_cast<uint32_t>(blocks);
    auto model = generate_city(city, options);
    return model ? std::move(model)
                 : Result<SceneModel>{bad_parameter(source, model.error().message)};
}

Result<SceneModel> make_boxes(std::string_view source, std::string_view text,
                              const SceneOptions& options)
{
    BoxesOptions boxes;
    uint64_t count = boxes.count;
    const std::array parameters{
        Parameter{"count", &count, 1, 10000000},
        Parameter{"seed", &boxes.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    boxes.count = static_cast<uint32_t>(count);
    return generate_boxes(boxes, options);
}

Result<SceneModel> make_boxcity(std::string_view source, std::string_view text,
                                const SceneOptions& options)
{
    BoxCityOptions city;
    const std::array parameters{
        Parameter{"count", &city.count, 100, 1000000},
        Parameter{"triangles", &city.triangles, 12, 10000},
        Parameter{"seed", &city.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    return generate_boxcity(city, options);
}

Result<SceneModel> make_teapots(std::string_view source, std::string_view text,
                                const SceneOptions& options)
{
    TeapotsOptions teapots;
    const std::array parameters{
        Parameter{"count", &teapots.count, 1, 1000000},
        Parameter{"triangles", &teapots.triangles, 64, 1000000},
        Parameter{"seed", &teapots.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    return generate_teapots(teapots, options);
}

Result<SceneModel> make_library(std::string_view source, std::string_view text,
                                const SceneOptions& options)
{
    LibraryOptions library;
    const std::array parameters{
        Parameter{"books", &library.books, 1, 1000000},
        Parameter{"triangles", &library.triangles, 12, 2000},
        Parameter{"seed", &library.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    return generate_library(library, options);
}

Result<SceneModel> make_plant(std::string_view source, std::string_view text,
                              const SceneOptions& options)
{
    PlantOptions plant;
    const std::array parameters{
        Parameter{"triangles", &plant.triangles, 1000, 200000000},
        Parameter{"objects", &plant.objects, 40, 20000},
        Parameter{"seed", &plant.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    auto model = generate_plant(plant, options);
    return model ? std::move(model)
                 : Result<SceneModel>{bad_parameter(source, model.error().message)};
}

Result<SceneModel> make_forest(std::string_view source, std::string_view text,
                               const SceneOptions& options)
{
    ForestOptions forest;
    const std::array parameters{
        Parameter{"triangles", &forest.triangles, 1000, 200000000},
        Parameter{"trees", &forest.trees, 1, 1000000},
        Parameter{"seed", &forest.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    return generate_forest(forest, options);
}

Result<SceneModel> make_bunnies(std::string_view source, std::string_view text,
                                const SceneOptions& options)
{
    BunniesOptions bunnies;
    const std::array parameters{
        Parameter{"count", &bunnies.count, 1, 1000000},
        Parameter{"triangles", &bunnies.triangles, 100, 1000000},
        Parameter{"seed", &bunnies.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    return generate_bunnies(bunnies, options);
}

Result<SceneModel> make_vienna(std::string_view source, std::string_view text,
                               const SceneOptions& options)
{
    ViennaOptions vienna;
    const std::array parameters{
        Parameter{"blocks", &vienna.blocks, 1, 64},
        Parameter{"triangles", &vienna.triangles, 1000, 200000000},
        Parameter{"seed", &vienna.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    auto model = generate_vienna(vienna, options);
    return model ? std::move(model)
                 : Result<SceneModel>{bad_parameter(source, model.error().message)};
}

template <SceneModel (*kGenerate)(const HollowOptions&, const SceneOptions&)>
Result<SceneModel> make_hollow(std::string_view source, std::string_view text,
                               const SceneOptions& options)
{
    HollowOptions hollow;
    const std::array parameters{
        Parameter{"count", &hollow.count, 1, 1000000},
        Parameter{"triangles", &hollow.triangles, 4, 100000},
        Parameter{"seed", &hollow.seed, 0, kMostSeed},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    return kGenerate(hollow, options);
}

/// `count`, `seed` and `triangles` into an options struct of a scene that moves.
template <class Options>
std::optional<Error> parse_moving(std::string_view source, std::string_view text,
                                  uint64_t most_triangles, Options& options)
{
    uint64_t count = options.count;
    const std::array parameters{
        Parameter{"count", &count, 1, 1000000},
        Parameter{"seed", &options.seed, 0, kMostSeed},
        Parameter{"triangles", &options.triangles, 12, most_triangles},
    };
    auto problem = parse_parameters(source, text, parameters);
    options.count = static_cast<uint32_t>(count);
    return problem;
}

Result<SceneModel> make_movers(std::string_view source, std::string_view text,
                               const SceneOptions& options)
{
    MoversOptions movers;
    if (const auto problem = parse_moving(source, text, 200000000, movers)) {
        return *problem;
    }
    return generate_movers(movers, options);
}

Result<SceneModel> make_blobs(std::string_view source, std::string_view text,
                              const SceneOptions& options)
{
    BlobsOptions blobs;
    if (const auto problem = parse_moving(source, text, 1000000, blobs)) {
        return *problem;
    }
    return generate_blobs(blobs, options);
}

struct Generator {
    GeneratorInfo info;
    Result<SceneModel> (*make)(std::string_view source, std::string_view parameters,
                               const SceneOptions& options);
};

std::span<const Generator> registry()
{
    static const std::array kGenerators{
        Generator{{"city", "blocks=16,seed=1,triangles=10m",
                   "streets between blocks of buildings with windows, balconies, roofs and street "
                   "furniture; blocks: per side"},
                  make_city},
        Generator{{"boxes", "count=1000,seed=1", "boxes at random places in a cube of 100 m"},
                  make_boxes},
        Generator{{"movers", "count=2000,seed=1,triangles=500k",
                   "boxes, slabs and lumps that fly and tumble in a cube of 70 m; one in four "
                   "appears and vanishes; triangles: of all together"},
                  make_movers},
        Generator{{"blobs", "count=300,seed=1,triangles=70k",
                   "interpenetrating blobs that move straight in a crowd, as the bunnies of the "
                   "literature do; triangles: of each"},
                  make_blobs},
        Generator{
            {"boxcity", "count=40k,triangles=12,seed=1",
             "a city in which every object is one box: buildings, and blocks and boxes beside "
             "and on them; triangles: of each"},
            make_boxcity},
        Generator{{"teapots", "count=5000,triangles=2304,seed=1",
                   "Utah teapots at random places in a cube, in all orientations; triangles: of "
                   "each"},
                  make_teapots},
        Generator{{"library", "books=40k,triangles=254,seed=1",
                   "rows of shelves without backs, full of books, with reading places; triangles: "
                   "of each book"},
                  make_library},
        Generator{{"plant", "triangles=2m,objects=1185,seed=1",
                   "an industrial plant: floors with boilers, tube bundles, pipe racks, tanks and "
                   "stairs, and a yard"},
                  make_plant},
        Generator{{"bunnies", "count=300,triangles=70k,seed=1",
                   "interpenetrating Stanford bunnies that move straight in a crowd; triangles: of "
                   "each, at most"},
                  make_bunnies},
        Generator{{"forest", "triangles=1.7m,trees=1000,seed=1",
                   "spruces and broad-leaved trees on rolling ground: leaky occluders"},
                  make_forest},
        Generator{{"pyramids", "count=1000,triangles=256,seed=1",
                   "pyramids behind each other: objects whose boxes stand out where they do not; "
                   "triangles: of each"},
                  make_hollow<generate_pyramids>},
        Generator{{"rings", "count=1000,triangles=256,seed=1",
                   "thin rings behind each other: objects that fill little of their boxes; "
                   "triangles: of each"},
                  make_hollow<generate_rings>},
        Generator{{"vienna", "blocks=16,triangles=8m,seed=1",
                   "an old town: narrow, winding streets, courtyards, steep roofs with dormers; "
                   "blocks: per side"},
                  make_vienna},
    };
    return kGenerators;
}

// A scene by its generator or from its file, parted by centroids.
Result<SceneModel> make_scene(const std::string& source, const SceneOptions& options)
{
    const std::string_view text = source;
    const size_t colon = text.find(':');
    const std::string_view kind = text.substr(0, colon);
    for (const Generator& generator : registry()) {
        if (generator.info.name == kind) {
            const std::string_view parameters =
                colon == std::string_view::npos ? std::string_view{} : text.substr(colon + 1);
            return generator.make(text, parameters, options);
        }
    }
    return load_with_assimp(source, options);
}

} // namespace

std::span<const GeneratorInfo> generators()
{
    static const std::vector<GeneratorInfo> kInfos = [] {
        std::vector<GeneratorInfo> infos;
        for (const Generator& generator : registry()) {
            infos.push_back(generator.info);
        }
        return infos;
    }();
    return kInfos;
}

Result<SceneModel> load_scene(const std::string& source, const SceneOptions& options)
{
    auto model = make_scene(source, options);
    if (model) {
        model->uncut_triangles = drawn_triangles(*model);
    }
    if (model && options.split == SceneOptions::Split::exact) {
        for (Mesh& mesh : model->meshes) {
            split_mesh_exactly(mesh, std::max(options.item_triangles, 1u), options.cache_folder);
        }
    }
    if (model) {
        for (Mesh& mesh : model->meshes) {
            make_shapes(mesh);
        }
    }
    return model;
}

} // namespace occlude::tools
