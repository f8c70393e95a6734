#include "load/scene_loader.h"

#include "load/assimp_reader.h"
#include "load/finish_scene.h"
#include "load/gltf_document.h"
#include "load/gltf_loader.h"
#include "load/guarded_child.h"
#include "load/load_progress.h"
#include "load/scene_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <fstream>
#include <optional>
#include <string_view>

#include <unistd.h>

namespace occlude::tools {
namespace {

namespace fs = std::filesystem;

/// Files that take longer to read are kept as they were read.
constexpr double kSecondsWorthKeeping = 2.0;

Error bad_file(const std::string& file, const std::string& what)
{
    return {ErrorCode::bad_data, fmt::format("{}: {}", file, what)};
}

/// Why a file cannot be read whatever is in it.
std::optional<Error> check_file(const std::string& file)
{
    std::error_code failed;
    if (!fs::exists(file, failed)) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: no such file; give the path of a scene file, or a generated "
                                 "scene such as city:blocks=16,seed=1",
                                 file)};
    }
    if (!fs::is_regular_file(file, failed)) {
        return bad_file(file, "is not a file; give a scene file such as scene.glb");
    }
    if (!std::ifstream(file, std::ios::binary)) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: cannot be read; check its permissions", file)};
    }
    const uintmax_t size = fs::file_size(file, failed);
    if (failed || size == 0) {
        return bad_file(file, "is empty; export or download it again");
    }
    return std::nullopt;
}

/// Assimp looks for the end of a PLY header for ever: the reason is better than its time limit.
std::optional<std::string> broken_ply(const std::string& file)
{
    constexpr size_t kLongestHeader = 1 << 20;
    constexpr std::string_view kEnd = "\nend_header";
    std::ifstream in(file, std::ios::binary);
    std::string head(kLongestHeader, '\0');
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<size_t>(in.gcount()));
    if (!head.starts_with("ply\n") && !head.starts_with("ply\r")) {
        return std::nullopt;
    }
    const size_t end = head.find(kEnd);
    const size_t after = end == std::string::npos ? end : end + kEnd.size();
    if (after >= head.size() || (head[after] != '\n' && head[after] != '\r')) {
        return "has no whole PLY header, the line end_header is missing; export it again";
    }
    return std::nullopt;
}

/// Kinds of files whose reason is lost in Assimp.
std::optional<std::string> unreadable_kind(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    char head[8] = {};
    in.read(head, sizeof head);
    if (std::string_view{head, 4} == "glTF") { // not of version 2
        return "is a binary glTF file of version 1, which is not read; convert it to glTF 2.0";
    }
    return broken_ply(file);
}

uint64_t memory_limit_mib(const SceneOptions& options)
{
    if (options.load_memory_mib > 0) {
        return options.load_memory_mib;
    }
    const auto pages = static_cast<uint64_t>(std::max(::sysconf(_SC_PHYS_PAGES), 1L));
    const auto page = static_cast<uint64_t>(std::max(::sysconf(_SC_PAGESIZE), 1L));
    return std::max<uint64_t>((pages * page >> 20) / 2, 256);
}

Result<LoadedScene> read_file(const std::string& file, const SceneOptions& options)
{
    const ChildLimits limits{options.load_seconds, memory_limit_mib(options)};
    const ReadProgress progress = [&](double share) {
        if (options.progress) {
            options.progress(kReadShare * share);
        }
    };
    if (looks_like_gltf_2(file)) {
        const auto read = [&](const ReadProgress& told) {
            return load_gltf(file, limits.memory_mib << 20, told);
        };
        auto scene = gltf_needs_guard(file) ? read_in_child(file, "a decoder of meshes or images",
                                                            limits, progress, read)
                                            : read(progress);
        if (scene || scene.error().code != ErrorCode::unsupported) {
            return scene; // unsupported: glTF of version 1, which Assimp reads
        }
    }
    if (const auto problem = unreadable_kind(file)) {
        return bad_file(file, *problem);
    }
    if (auto kept = find_cached_scene(options.cache_folder, file)) {
        return std::move(*kept);
    }
    const auto start = std::chrono::steady_clock::now();
    auto scene = read_in_child(file, "Assimp", limits, progress, [&](const ReadProgress& told) {
        return read_with_assimp(file, told);
    });
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    if (scene && taken.count() > kSecondsWorthKeeping) {
        keep_scene(options.cache_folder, *scene);
    }
    return scene;
}

} // namespace

Result<SceneModel> load_scene_file(const std::string& file, const SceneOptions& options)
{
    if (const auto problem = check_file(file)) {
        return *problem;
    }
    auto loaded = read_file(file, options);
    return loaded ? finish_scene(std::move(*loaded), file, options)
                  : Result<SceneModel>{loaded.error()};
}

} // namespace occlude::tools
