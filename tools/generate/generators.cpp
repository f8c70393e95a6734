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
#include "load/load_progress.h"
#include "load/scene_loader.h"
#include "model/exact_split.h"
#include "model/mesh_tools.h"
#include "model/scene_options.h"

#include <occlude/scene/split.h>

#include <fmt/format.h>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace occlude::tools {
namespace {

/// A number that the user may set: a member of the options of a generator, and its range.
template <class Options>
struct Field {
    std::string_view key;
    uint64_t (*get)(const Options&);
    void (*set)(Options&, uint64_t);
    uint64_t least;
    uint64_t most;
};

/// Precondition: `most` fits the member.
template <auto kMember, class Options, class Number>
Field<Options> field_of(Number Options::*, std::string_view key, uint64_t least, uint64_t most)
{
    return {key, [](const Options& options) { return uint64_t{options.*kMember}; },
            [](Options& options, uint64_t value) { options.*kMember = static_cast<Number>(value); },
            least, most};
}
template <auto kMember>
auto field(std::string_view key, uint64_t least, uint64_t most)
{
    return field_of<kMember>(kMember, key, least, most);
}

struct Generator {
    GeneratorInfo info;
    std::function<Result<SceneModel>(std::string_view source, std::string_view parameters,
                                     const SceneOptions& options)>
        make;
};

/// "40k" for 40000, "1.7m" for 1700000, "254" for 254: as parse_parameters() reads it.
std::string short_count(uint64_t value)
{
    if (value >= 1000000 && value % 100000 == 0) {
        return fmt::format("{}m", static_cast<double>(value) / 1e6);
    }
    return value >= 10000 && value % 1000 == 0 ? fmt::format("{}k", value / 1000)
                                               : std::to_string(value);
}

template <class Options>
std::optional<Error> read_fields(std::string_view source, std::string_view text,
                                 std::span<const Field<Options>> fields, Options& options)
{
    std::vector<uint64_t> values;
    for (const Field<Options>& field : fields) {
        values.push_back(field.get(options));
    }
    std::vector<Parameter> parameters;
    for (size_t i = 0; i < fields.size(); ++i) {
        parameters.push_back({fields[i].key, &values[i], fields[i].least, fields[i].most});
    }
    auto problem = parse_parameters(source, text, parameters);
    for (size_t i = 0; i < fields.size(); ++i) {
        fields[i].set(options, values[i]);
    }
    return problem;
}

/// One line of the table: `generate` makes the scene from the options, which are `fields`.
template <class Options>
Generator describe(std::string name, std::string description, std::vector<Field<Options>> fields,
                   auto generate)
{
    const Options defaults;
    std::string parameters;
    for (const Field<Options>& field : fields) {
        parameters += fmt::format("{}{}={}", parameters.empty() ? "" : ",", field.key,
                                  short_count(field.get(defaults)));
    }
    const auto make = [fields = std::move(fields),
                       generate](std::string_view source, std::string_view text,
                                 const SceneOptions& scene_options) -> Result<SceneModel> {
        Options options;
        if (auto problem = read_fields<Options>(source, text, fields, options)) {
            return *problem;
        }
        Result<SceneModel> model = generate(options, scene_options);
        const bool bad_options = !model && model.error().code == ErrorCode::invalid_argument;
        return bad_options ? Result<SceneModel>{bad_parameter(source, model.error().message)}
                           : std::move(model);
    };
    return {{std::move(name), std::move(parameters), std::move(description)}, make};
}

constexpr uint64_t kMostTriangles = 200000000; // of a whole scene
constexpr uint64_t kMostObjects = 1000000;

// Streets and houses.
void add_towns(std::vector<Generator>& table)
{
    using City = CityOptions;
    using BoxCity = BoxCityOptions;
    using Vienna = ViennaOptions;
    table.push_back(describe<City>(
        "city",
        "streets between blocks of buildings with windows, balconies, roofs and street furniture; "
        "blocks: per side",
        {field<&City::blocks>("blocks", 1, 64), field<&City::seed>("seed", 0, kMostSeed),
         field<&City::triangles>("triangles", 1000, kMostTriangles)},
        generate_city));
    table.push_back(describe<BoxCity>(
        "boxcity",
        "a city in which every object is one box: buildings, and blocks and boxes beside and on "
        "them; triangles: of each",
        {field<&BoxCity::count>("count", 100, kMostObjects),
         field<&BoxCity::triangles>("triangles", 12, 10000),
         field<&BoxCity::seed>("seed", 0, kMostSeed)},
        generate_boxcity));
    table.push_back(describe<Vienna>(
        "vienna",
        "an old town: narrow, winding streets, courtyards, steep roofs with dormers; blocks: per "
        "side",
        {field<&Vienna::blocks>("blocks", 1, 64),
         field<&Vienna::triangles>("triangles", 1000, kMostTriangles),
         field<&Vienna::seed>("seed", 0, kMostSeed)},
        generate_vienna));
}

// Places that people have measured in: halls, plants, woods.
void add_places(std::vector<Generator>& table)
{
    using Library = LibraryOptions;
    using Plant = PlantOptions;
    using Forest = ForestOptions;
    table.push_back(describe<Library>(
        "library",
        "rows of shelves without backs, full of books, with reading places; triangles: of each "
        "book",
        {field<&Library::books>("books", 1, kMostObjects),
         field<&Library::triangles>("triangles", 12, 2000),
         field<&Library::seed>("seed", 0, kMostSeed)},
        generate_library));
    table.push_back(describe<Plant>(
        "plant",
        "an industrial plant: floors with boilers, tube bundles, pipe racks, tanks and stairs, "
        "and a yard",
        {field<&Plant::triangles>("triangles", 1000, kMostTriangles),
         field<&Plant::objects>("objects", 40, 20000), field<&Plant::seed>("seed", 0, kMostSeed)},
        generate_plant));
    table.push_back(describe<Forest>(
        "forest", "spruces and broad-leaved trees on rolling ground: leaky occluders",
        {field<&Forest::triangles>("triangles", 1000, kMostTriangles),
         field<&Forest::trees>("trees", 1, kMostObjects),
         field<&Forest::seed>("seed", 0, kMostSeed)},
        generate_forest));
}

// Many objects of one kind.
void add_crowds(std::vector<Generator>& table)
{
    using Boxes = BoxesOptions;
    using Movers = MoversOptions;
    using Blobs = BlobsOptions;
    using Teapots = TeapotsOptions;
    using Bunnies = BunniesOptions;
    using Hollow = HollowOptions;
    table.push_back(describe<Boxes>(
        "boxes", "boxes at random places in a cube of 100 m",
        {field<&Boxes::count>("count", 1, 10000000), field<&Boxes::seed>("seed", 0, kMostSeed)},
        generate_boxes));
    table.push_back(describe<Movers>(
        "movers",
        "boxes, slabs and lumps that fly and tumble in a cube of 70 m; one in four appears and "
        "vanishes; triangles: of all together",
        {field<&Movers::count>("count", 1, kMostObjects),
         field<&Movers::seed>("seed", 0, kMostSeed),
         field<&Movers::triangles>("triangles", 12, kMostTriangles)},
        generate_movers));
    table.push_back(describe<Blobs>(
        "blobs",
        "interpenetrating blobs that move straight in a crowd, as the bunnies of the literature "
        "do; triangles: of each",
        {field<&Blobs::count>("count", 1, kMostObjects), field<&Blobs::seed>("seed", 0, kMostSeed),
         field<&Blobs::triangles>("triangles", 12, 1000000)},
        generate_blobs));
    table.push_back(describe<Bunnies>(
        "bunnies",
        "interpenetrating Stanford bunnies that move straight in a crowd; triangles: of each, at "
        "most",
        {field<&Bunnies::count>("count", 1, kMostObjects),
         field<&Bunnies::triangles>("triangles", 100, 1000000),
         field<&Bunnies::seed>("seed", 0, kMostSeed)},
        generate_bunnies));
    table.push_back(describe<Teapots>(
        "teapots",
        "Utah teapots at random places in a cube, in all orientations; triangles: of each",
        {field<&Teapots::count>("count", 1, kMostObjects),
         field<&Teapots::triangles>("triangles", 64, 1000000),
         field<&Teapots::seed>("seed", 0, kMostSeed)},
        generate_teapots));
    const std::vector<Field<Hollow>> hollow{field<&Hollow::count>("count", 1, kMostObjects),
                                            field<&Hollow::triangles>("triangles", 4, 100000),
                                            field<&Hollow::seed>("seed", 0, kMostSeed)};
    table.push_back(describe<Hollow>(
        "pyramids",
        "pyramids behind each other: objects whose boxes stand out where they do not; triangles: "
        "of each",
        hollow, generate_pyramids));
    table.push_back(describe<Hollow>(
        "rings",
        "thin rings behind each other: objects that fill little of their boxes; triangles: of each",
        hollow, generate_rings));
}

std::span<const Generator> registry()
{
    static const std::vector<Generator> kGenerators = [] {
        std::vector<Generator> table;
        add_towns(table);
        add_places(table);
        add_crowds(table);
        return table;
    }();
    return kGenerators;
}

// Cuts all meshes exactly, and notes those of which a part stayed more than twice as large as
// asked.
void split_exactly(SceneModel& model, const SceneOptions& options)
{
    const uint32_t most = std::max(options.item_triangles, 1u);
    for (Mesh& mesh : model.meshes) {
        split_mesh_exactly(mesh, most, options.cache_folder);
        const auto large = std::ranges::count_if(mesh.parts, [&](const MeshPart& part) {
            return part.index_count / 3 > 2 * uint64_t{most};
        });
        if (large > 0) {
            model.load_notes.push_back(
                fmt::format("{} of {} items of mesh '{}' stayed larger than --item-triangles {}: "
                            "no plane parts "
                            "them, or cutting on would make the mesh more than {} times as large",
                            large, mesh.parts.size(), mesh.name, most, kMaxSplitGrowth));
        }
    }
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
    return load_scene_file(source, options);
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
        split_exactly(*model, options);
    }
    if (model) {
        LoadProgress progress{options.progress, kCleanShare, 1.0, model->meshes.size()};
        oneapi::tbb::parallel_for(size_t{0}, model->meshes.size(), [&](size_t i) {
            make_shapes(model->meshes[i]);
            progress.advance(1);
        });
    }
    return model;
}

} // namespace occlude::tools
