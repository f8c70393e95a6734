#include "scenes/assimp_loader.h"
#include "scenes/boxes_generator.h"
#include "scenes/city_generator.h"
#include "scenes/exact_split.h"
#include "scenes/moving_generators.h"
#include "scenes/scene_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

namespace occlude::tools {
namespace {

/// A whole number that the user may set: where it goes, and what is allowed.
struct Parameter {
    std::string_view key;
    uint64_t* value;
    uint64_t least;
    uint64_t most;
};

Error bad_parameter(std::string_view source, const std::string& what)
{
    return {ErrorCode::invalid_argument, fmt::format("{}: {}", source, what)};
}

/// A whole number with an optional suffix k (thousand) or m (million): "10m", "1.5m", "250k".
std::optional<uint64_t> parse_count(std::string_view text)
{
    uint64_t scale = 1;
    if (!text.empty() && (text.back() == 'k' || text.back() == 'K')) {
        scale = 1000;
    } else if (!text.empty() && (text.back() == 'm' || text.back() == 'M')) {
        scale = 1000000;
    }
    if (scale > 1) {
        text.remove_suffix(1);
    }
    uint64_t whole = 0;
    const char* end = text.data() + text.size();
    const auto [at, failed] = std::from_chars(text.data(), end, whole);
    constexpr uint64_t kMost = 1000000000000;
    if (failed != std::errc{} || whole > kMost) {
        return std::nullopt;
    }
    uint64_t value = whole * scale;
    if (at != end) {
        if (*at != '.' || scale == 1 || at + 1 == end) {
            return std::nullopt;
        }
        for (const char* digit = at + 1; digit != end; ++digit) {
            if (*digit < '0' || *digit > '9') {
                return std::nullopt;
            }
            scale /= 10;
            value += scale * static_cast<uint64_t>(*digit - '0');
        }
    }
    return value;
}

/// Reads "key=value,key=value" into `parameters`.
std::optional<Error> parse_parameters(std::string_view source, std::string_view text,
                                      std::span<const Parameter> parameters)
{
    std::string known;
    for (const Parameter& parameter : parameters) {
        known += fmt::format("{}{}", known.empty() ? "" : ", ", parameter.key);
    }
    while (!text.empty()) {
        const std::string_view entry = text.substr(0, text.find(','));
        text.remove_prefix(std::min(text.size(), entry.size() + 1));
        const size_t equals = entry.find('=');
        const std::string_view key = entry.substr(0, equals);
        const Parameter* found = nullptr;
        for (const Parameter& parameter : parameters) {
            if (parameter.key == key) {
                found = &parameter;
            }
        }
        if (found == nullptr) {
            return bad_parameter(source,
                                 fmt::format("unknown parameter '{}'; known are {}", key, known));
        }
        const std::string_view digits =
            equals == std::string_view::npos ? std::string_view{} : entry.substr(equals + 1);
        const auto value = parse_count(digits);
        if (!value || *value < found->least || *value > found->most) {
            return bad_parameter(source, fmt::format("'{}' is not a value for {}; give a whole "
                                                     "number from {} to {} (10k, 1.5m allowed)",
                                                     digits, key, found->least, found->most));
        }
        *found->value = *value;
    }
    return std::nullopt;
}

Result<SceneModel> make_city(std::string_view source, std::string_view text,
                             const SceneOptions& options)
{
    CityOptions city;
    uint64_t blocks = city.blocks;
    const std::array parameters{
        Parameter{"blocks", &blocks, 1, 64},
        Parameter{"seed", &city.seed, 0, 1000000000000},
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
        Parameter{"seed", &boxes.seed, 0, 1000000000000},
    };
    if (const auto problem = parse_parameters(source, text, parameters)) {
        return *problem;
    }
    boxes.count = static_cast<uint32_t>(count);
    return generate_boxes(boxes, options);
}

/// `count`, `seed` and `triangles` into an options struct of a scene that moves.
template <class Options>
std::optional<Error> parse_moving(std::string_view source, std::string_view text,
                                  uint64_t most_triangles, Options& options)
{
    uint64_t count = options.count;
    const std::array parameters{
        Parameter{"count", &count, 1, 1000000},
        Parameter{"seed", &options.seed, 0, 1000000000000},
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

const std::array<Generator, 4>& registry()
{
    static const std::array<Generator, 4> kGenerators{
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
    return model;
}

} // namespace occlude::tools
