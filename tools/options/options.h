// The requests of the user as plain data. cli.h fills it, the commands read it.
#pragma once

#include "model/scene_options.h"

#include <occlude/core/option_text.h>
#include <occlude/core/result.h>
#include <occlude/hierarchy/builders/bvh_builder.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools {

/// How to read a file; empty texts leave the choice to the file.
struct FileOptions {
    std::string origin; ///< "X,Y,Z"
    std::string unit;   ///< "m", "cm", "mm", "in", "ft", or units per metre
    std::string up;     ///< "x", "+y", "-z"
    uint32_t load_seconds = SceneOptions{}.load_seconds;
    uint64_t load_memory_mib = SceneOptions{}.load_memory_mib;
};

/// Which scene, how it is organised and who draws it: the same for every command.
struct StageOptions {
    std::string hierarchy = "bvh";     ///< hierarchies.h; bench and verify take several
    std::optional<std::string> device; ///< empty: gl, or cpu if there is no OpenGL
    std::string test = "queries";
    std::string path = "auto";
    size_t frames = 100;
    glm::ivec2 size{1280, 720};
    int samples = 1; ///< multisampling
    uint32_t leaf_triangles = BvhOptions{}.leaf_triangles;
    uint32_t item_triangles = SceneOptions{}.item_triangles;
    std::string split = "centroid";
    std::optional<std::string> cache_folder; ///< empty: default_cache_folder()
    std::vector<std::string> sets;           ///< ALGORITHM.OPTION=VALUE, TREE.OPTION=VALUE
    FileOptions file;                        ///< for scenes that are files
    /// Anything in a file that the scene leaves out is an error, and so are coincident surfaces.
    bool strict = false;
};

/// For bench and verify, which take the same options.
struct CompareOptions {
    StageOptions stage;
    std::vector<std::string> scenes;
    bool path_given = false; ///< verify walks several paths unless one is named
    std::string algorithms = "all";
    size_t repeat = 1;
    bool verify = false;
    bool nothing_hidden_is_fine = false; ///< verify: frames in which nothing is hidden are expected
    std::string json;                    ///< file names; empty: not requested
    std::string csv;
    std::string html;
    std::string record; ///< bench only
};

struct ReplayOptions {
    std::string file;
    std::string algorithms = "all";
    std::string json; ///< a file name; empty: not requested
};

/// For bench --suite.
struct SuiteOptions {
    std::string suite;
    std::string scale = "small";
    std::string only; ///< entries between commas; empty: all
    std::optional<std::string> device;
    std::optional<std::string> cache_folder;
    std::string json; ///< file names; empty: not requested
    std::string csv;
    std::string html;
    bool add = false;   ///< keep the entries in `json` that are not measured
    std::string from;   ///< a file of results to report on, instead of measuring
    std::string report; ///< Markdown beside published figures; empty: kDefaultReport
};
inline constexpr const char* kDefaultReport = "out/papers.md";

struct RenderOptions {
    StageOptions stage;
    std::string scene;
    std::string algorithm = "chc_plus_plus";
    std::optional<size_t> frame;
    std::string frame_range; ///< "A:B", both included; empty: one frame
    std::string out;
    std::string show; ///< empty: visible, or states for the overview camera
    std::string camera = "path";
};

/// For the interactive viewer. The size in the stage's options is the size of the window.
struct ViewOptions {
    StageOptions stage;
    std::string scene; ///< empty: none yet
    std::string algorithm;
    bool headless = false;
    std::optional<size_t> frames; ///< ends after this many frames
    std::optional<glm::ivec2> size;
    std::optional<float> scale; ///< scale of panels
    std::string screenshot;     ///< picture of the last frame; empty: none
    std::string script;
};

struct InfoOptions {
    StageOptions stage;
    std::string scene;
    std::string json; ///< a file name; empty: not requested
};

struct GenerateOptions {
    std::string scene;
    std::string out;
};

struct ConvertOptions {
    std::string scene;
    std::string out;
    FileOptions file;
    bool strict = false; ///< what the file holds and the scene does not is an error
};

struct ListOptions {
    std::string what;
    std::string scene; ///< for paths only; may be empty
};

/// "1280x720": both sides from 1 to 16384.
Result<glm::ivec2> parse_size(std::string_view text);

/// Reads the texts of `file` into scene options; errors name the option.
Result<SceneOptions> parse_file_options(const FileOptions& file, SceneOptions options = {});

/// "A:B": first and last frame, first <= last.
struct FrameRange {
    size_t first = 0;
    size_t last = 0;
};
Result<FrameRange> parse_frame_range(std::string_view text);

/// "chc.threshold=20", "lazy_grid@busy.update=busy".
struct SetOption {
    std::string algorithm; ///< with its label
    std::string option;
    std::string value;
};
Result<SetOption> parse_set(std::string_view text);

/// The settings in `sets` for an algorithm, or for a hierarchy by its tree_set_name(). Ignores
/// texts that are not settings, because choose_contenders() reports them.
std::vector<OptionValue> settings_of(std::string_view name, std::span<const std::string> sets);

/// "lazy_grid:update=busy": an entry of a list, with its own options.
struct NamedEntry {
    std::string name;
    std::vector<OptionValue> options;
};
/// Nothing if the name is not followed by OPTION=VALUE between colons.
std::optional<NamedEntry> parse_entry(std::string_view text);

/// The parts between commas; empty parts are kept.
std::vector<std::string> split_commas(std::string_view text);

} // namespace occlude::tools
