#include "load/scene_cache.h"

#include "files/temporary_file.h"
#include "load/mapped_file.h"
#include "load/scene_bytes.h"

#include <occlude/core/rng.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <system_error>

#include <unistd.h>

namespace occlude::tools {

namespace fs = std::filesystem;

namespace {

fs::path cached_file(const fs::path& folder, uint64_t hash)
{
    return folder / fmt::format("scene-{:016x}", hash);
}

} // namespace

uint64_t content_hash(const fs::path& file)
{
    const auto mapped = MappedFile::open(file);
    if (!mapped) {
        return 0;
    }
    const std::span<const uint8_t> bytes = mapped->bytes();
    // Four lanes, because one multiplication waits for the other.
    uint64_t lanes[4] = {1, 2, 3, bytes.size()};
    size_t at = 0;
    for (; at + sizeof lanes <= bytes.size(); at += sizeof lanes) {
        uint64_t words[4];
        std::memcpy(words, bytes.data() + at, sizeof words);
        for (int i = 0; i < 4; ++i) {
            lanes[i] = (lanes[i] ^ words[i]) * 0x9e3779b97f4a7c15ull;
            lanes[i] ^= lanes[i] >> 32;
        }
    }
    for (; at < bytes.size(); ++at) {
        lanes[0] = hash64(lanes[0], bytes[at]);
    }
    return hash64(lanes[0], lanes[1], lanes[2], lanes[3]);
}

std::optional<LoadedScene> find_cached_scene(const fs::path& folder, const std::string& file)
{
    std::error_code failed;
    if (folder.empty() || !fs::is_directory(folder, failed)) {
        return std::nullopt;
    }
    const auto mapped = MappedFile::open(cached_file(folder, content_hash(file)));
    auto scene = mapped ? read_scene(mapped->bytes()) : std::nullopt;
    if (!scene) {
        return std::nullopt;
    }
    const auto as_before = [](const SourceFile& source) {
        return content_hash(source.path) == source.hash;
    };
    const bool same = !scene->sources.empty() && scene->sources.front().path == file &&
                      std::all_of(scene->sources.begin(), scene->sources.end(), as_before);
    return same ? std::move(scene) : std::nullopt;
}

void keep_scene(const fs::path& folder, const LoadedScene& scene)
{
    std::error_code failed;
    if (folder.empty() || scene.sources.empty()) {
        return;
    }
    fs::create_directories(folder, failed);
    const fs::path file = cached_file(folder, scene.sources.front().hash);
    TemporaryFile unfinished{file}; // nobody sees half of it, not even after Ctrl-C
    const int copy = ::dup(unfinished.descriptor());
    std::FILE* out = copy >= 0 ? ::fdopen(copy, "wb") : nullptr;
    if (out == nullptr) {
        return;
    }
    const bool written = write_scene(out, scene);
    if (std::fclose(out) == 0 && written) {
        unfinished.rename_to(file);
    }
}

} // namespace occlude::tools
