#include "commands/cli_options.h"

#include "session/hierarchies.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace occlude::tools {

// Ends parsing with a message of ours.
template <class T>
static T value_or_throw(Result<T> result)
{
    if (!result) {
        throw CLI::ValidationError{result.error().message};
    }
    return std::move(*result);
}

CLI::Validator whole_number(uint64_t low, uint64_t high)
{
    return CLI::Validator{
        [low, high](const std::string& text) {
            constexpr size_t kMaxDigits = 18;
            const bool digits =
                !text.empty() && text.size() <= kMaxDigits &&
                std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
            const uint64_t value = digits ? std::stoull(text) : 0;
            return digits && value >= low && value <= high
                       ? std::string{}
                       : fmt::format("'{}' is not a whole number from {} to {}", text, low, high);
        },
        ""};
}

void add_file_options(CLI::App& app, FileOptions& file)
{
    constexpr uint64_t kMaxSeconds = 1000000;
    constexpr uint64_t kMaxMebibytes = uint64_t{1} << 24;
    const std::string group = kFileGroup;
    app.add_option("--origin", file.origin,
                   "X,Y,Z: the point of the file that becomes (0, 0, 0) (default: moved only where "
                   "single precision would bend it)")
        ->group(group);
    app.add_option("--unit", file.unit,
                   "m, cm, mm, in, ft, or how many units make a metre (default: as the file or its "
                   "format says, else guessed)")
        ->group(group);
    app.add_option("--up", file.up, "x, y, z, or -x, -y, -z (default: as for --unit)")
        ->group(group);
    app.add_option("--load-seconds", file.load_seconds,
                   "How long Assimp may read a file before it is stopped")
        ->capture_default_str()
        ->check(whole_number(1, kMaxSeconds))
        ->group(group);
    app.add_option("--load-memory", file.load_memory_mib,
                   "MiB that reading a file may take (default: half of the machine's)")
        ->check(whole_number(1, kMaxMebibytes))
        ->group(group);
}

CLI::Validator file_name()
{
    return CLI::Validator{[](const std::string& text) {
                              return text.empty() ? std::string{"the file name is empty"}
                                                  : std::string{};
                          },
                          ""};
}

void add_stage_options(CLI::App& app, RawStage& raw, bool several)
{
    constexpr uint64_t kMaxSamples = 64;
    constexpr uint64_t kMaxTriangles = 0xffffffff;
    StageOptions& stage = raw.stage;
    app.add_option("--hierarchy", stage.hierarchy,
                   "How the scene is organised: " + hierarchy_names() +
                       (several ? "; several between commas, or all" : "") +
                       "; NAME:OPTION=VALUE is one with its own option")
        ->capture_default_str();
    app.add_option("--device", raw.device,
                   "Who draws and tests: gl or cpu (default: gl, or cpu where there is no OpenGL)");
    app.add_option("--test", stage.test, "How boxes are tested: queries, raster (gl) or pyramid")
        ->capture_default_str();
    app.add_option("--path", stage.path,
                   "The camera's path: auto, a name of 'occlude list paths', or a FILE.json")
        ->capture_default_str();
    app.add_option("--size", raw.size, "Pixels of the image, WIDTHxHEIGHT")->capture_default_str();
    app.add_option("--msaa", stage.samples, "Samples per pixel")
        ->capture_default_str()
        ->check(whole_number(1, kMaxSamples));
    app.add_option("--set", stage.sets,
                   "An option of an algorithm or a hierarchy: NAME.OPTION=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--leaf-triangles", stage.leaf_triangles,
                   "Triangles up to which a node is a leaf; 0: only real leaves")
        ->capture_default_str()
        ->check(whole_number(0, kMaxTriangles));
    app.add_option("--item-triangles", stage.item_triangles,
                   "Triangles up to which a mesh stays one item")
        ->capture_default_str()
        ->check(whole_number(1, kMaxTriangles));
    app.add_option("--split", stage.split,
                   "Where larger meshes are parted: centroid (between triangles) or exact (planes "
                   "cut triangles)")
        ->capture_default_str();
    app.add_option("--cache", raw.cache_folder,
                   "Where exactly split meshes are kept (default: occlude in the user's cache)")
        ->type_name("DIR");
    add_file_options(app, stage.file);
    app.add_flag("--strict", stage.strict,
                 "Refuse files of which something is left out; coincident surfaces count as "
                 "differences")
        ->group(kFileGroup);
}

void add_frames_option(CLI::App& app, StageOptions& stage)
{
    app.add_option("--frames", stage.frames, "Frames of the path")
        ->capture_default_str()
        ->check(whole_number(1, kMaxFrames));
}

StageOptions finish_stage(const RawStage& raw, const CLI::App& app)
{
    StageOptions stage = raw.stage;
    stage.size = value_or_throw(parse_size(raw.size));
    if (app.count("--device") > 0) {
        stage.device = raw.device;
    }
    if (app.count("--cache") > 0) {
        stage.cache_folder = raw.cache_folder;
    }
    return stage;
}

} // namespace occlude::tools
