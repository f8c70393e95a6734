#include "model/exact_split.h"

#include "files/temporary_file.h"

#include <occlude/core/rng.h>
#include <occlude/scene/split.h>

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <span>
#include <system_error>
#include <type_traits>
#include <utility>

namespace occlude::tools {
namespace {

namespace fs = std::filesystem;

/// Part of every file name, so that a new number hides old files. Increase it when
/// split_triangles() or the layout of the files changes.
constexpr uint64_t kVersion = 1;
constexpr uint64_t kMagic = 0x31544c505343434full; // "OCCSPLT1"

/// Little-endian words: magic, checksum of all after it, then the counts, then the arrays.
struct Header {
    uint64_t magic = kMagic;
    uint64_t checksum = 0;
    uint64_t positions = 0;
    uint64_t indices = 0;
    uint64_t parts = 0;
};
static_assert(sizeof(Header) == 40);
static_assert(std::endian::native == std::endian::little, "cache files are little-endian");

struct FilePart {
    uint32_t first_index = 0;
    uint32_t index_count = 0;
    glm::vec3 min{0.0f};
    glm::vec3 max{0.0f};
};
static_assert(sizeof(FilePart) == 32 && sizeof(glm::vec3) == 12);

template <class T>
uint64_t hash_bytes(uint64_t seed, std::span<const T> values)
{
    static_assert(std::is_trivially_copyable_v<T>);
    const auto bytes = std::as_bytes(values);
    uint64_t hash = hash64(seed, bytes.size());
    for (size_t i = 0; i < bytes.size(); i += sizeof(uint64_t)) {
        uint64_t word = 0;
        std::memcpy(&word, bytes.data() + i, std::min(sizeof word, bytes.size() - i));
        hash = hash64(hash, word);
    }
    return hash;
}

uint64_t hash_header(const Header& header)
{
    return hash64(header.positions, header.indices, header.parts);
}

uint64_t checksum(const Header& header, const Mesh& mesh, std::span<const FilePart> parts)
{
    uint64_t hash = hash_header(header);
    hash = hash_bytes(hash, std::span<const glm::vec3>{mesh.positions});
    hash = hash_bytes(hash, std::span<const glm::vec3>{mesh.normals});
    hash = hash_bytes(hash, std::span<const uint32_t>{mesh.indices});
    return hash_bytes(hash, parts);
}

template <class T>
void write_array(TemporaryFile& out, std::span<const T> values)
{
    out.write({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

template <class T>
bool read_array(std::ifstream& in, std::vector<T>& values, uint64_t count)
{
    values.resize(count);
    in.read(reinterpret_cast<char*>(values.data()),
            static_cast<std::streamsize>(count * sizeof(T)));
    return static_cast<bool>(in);
}

// A checksum does not detect a file that was written wrongly; no content may crash a renderer.
bool consistent(const Mesh& mesh)
{
    uint64_t next = 0;
    for (const MeshPart& part : mesh.parts) {
        if (part.first_index != next || part.index_count % 3 != 0) {
            return false;
        }
        next += part.index_count;
    }
    bool in_range = next == mesh.indices.size() && !mesh.parts.empty();
    for (const uint32_t index : mesh.indices) {
        in_range = in_range && index < mesh.positions.size();
    }
    return in_range;
}

} // namespace

fs::path default_cache_folder()
{
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
        return fs::path{cache} / "occlude";
    }
    if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
        return fs::path{home} / ".cache" / "occlude";
    }
    return {};
}

std::string split_cache_name(const Mesh& mesh, uint32_t item_triangles)
{
    std::array<uint64_t, 2> name{};
    for (uint64_t half = 0; half < name.size(); ++half) {
        uint64_t hash = hash64(kVersion, half, item_triangles);
        hash = hash_bytes(hash, std::span<const glm::vec3>{mesh.positions});
        hash = hash_bytes(hash, std::span<const glm::vec3>{mesh.normals});
        name[half] = hash_bytes(hash, std::span<const uint32_t>{mesh.indices});
    }
    return fmt::format("{:016x}{:016x}.split", name[0], name[1]);
}

bool write_cut_mesh(const fs::path& file, const Mesh& mesh)
{
    std::vector<FilePart> parts;
    for (const MeshPart& part : mesh.parts) {
        parts.push_back({part.first_index, part.index_count, part.box.min, part.box.max});
    }
    Header header;
    header.positions = mesh.positions.size();
    header.indices = mesh.indices.size();
    header.parts = parts.size();
    header.checksum = checksum(header, mesh, parts);

    std::error_code failed;
    fs::create_directories(file.parent_path(), failed);
    TemporaryFile out{file};
    write_array(out, std::span<const Header>{&header, 1});
    write_array(out, std::span<const glm::vec3>{mesh.positions});
    write_array(out, std::span<const glm::vec3>{mesh.normals});
    write_array(out, std::span<const uint32_t>{mesh.indices});
    write_array(out, std::span<const FilePart>{parts});
    out.rename_to(file);
    return out.failed() == 0;
}

std::optional<Mesh> read_cut_mesh(const fs::path& file)
{
    std::error_code failed;
    const uintmax_t size = fs::file_size(file, failed);
    std::ifstream in(file, std::ios::binary);
    Header header;
    if (failed || size < sizeof header ||
        !in.read(reinterpret_cast<char*>(&header), sizeof header) || header.magic != kMagic) {
        return std::nullopt;
    }
    // The size of the file limits the counts before they allocate anything.
    const uint64_t most = size / sizeof(uint32_t);
    if (header.positions > most || header.indices > most || header.parts > most ||
        sizeof header + header.positions * 2 * sizeof(glm::vec3) +
                header.indices * sizeof(uint32_t) + header.parts * sizeof(FilePart) !=
            size) {
        return std::nullopt;
    }
    Mesh mesh;
    std::vector<FilePart> parts;
    const bool complete = read_array(in, mesh.positions, header.positions) &&
                          read_array(in, mesh.normals, header.positions) &&
                          read_array(in, mesh.indices, header.indices) &&
                          read_array(in, parts, header.parts);
    if (!complete || checksum(header, mesh, parts) != header.checksum) {
        return std::nullopt;
    }
    for (const FilePart& part : parts) {
        mesh.parts.push_back({part.first_index, part.index_count, {part.min, part.max}});
    }
    return consistent(mesh) ? std::optional{std::move(mesh)} : std::nullopt;
}

bool split_mesh_exactly(Mesh& mesh, uint32_t item_triangles, const fs::path& cache_folder)
{
    const bool small = mesh.indices.size() / 3 <= item_triangles;
    const bool cached = !small && !cache_folder.empty();
    const fs::path file =
        cached ? cache_folder / split_cache_name(mesh, item_triangles) : fs::path{};
    if (cached) {
        if (std::optional<Mesh> known = read_cut_mesh(file)) {
            known->name = std::move(mesh.name);
            mesh = std::move(*known);
            return true;
        }
    }
    SplitMesh split = split_triangles(mesh.positions, mesh.normals, mesh.indices, item_triangles);
    mesh.positions = std::move(split.positions);
    mesh.normals = std::move(split.normals);
    mesh.indices = std::move(split.indices);
    mesh.parts.clear();
    for (const PartitionPart& part : split.parts) {
        mesh.parts.push_back({part.first_index, part.index_count, part.box});
    }
    if (cached) {
        write_cut_mesh(file, mesh); // if it fails, the mesh is cut again next time
    }
    return false;
}

} // namespace occlude::tools
