#include "load/unreadable_files.h"

#include "files/parse_json.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <fstream>
#include <vector>

namespace occlude::tools {
namespace {

using nlohmann::json;

/// Assimp recurses over nodes, with some 600 bytes of stack for each: 1,000 take a tenth of the
/// usual 8 MB. Skeletons, the deepest trees there are, have a few dozen levels.
constexpr uint32_t kDeepestNode = 1000;
/// Assimp makes a node of more than 1 KB for each way to reach one. A node has one parent, but
/// where files do not keep to that, Assimp does not mind, nor do we below this.
constexpr size_t kMostShared = size_t{1} << 20;

/// Walks the nodes of a scene of glTF (named in version 1, numbered in 2) as Assimp will. Throws
/// what JSON does where members are missing or of another kind.
std::optional<std::string> broken_nodes(const json& nodes, const json& scene)
{
    struct Place {
        const json* name;
        uint32_t depth;
    };
    std::vector<Place> open;
    size_t count = 0;
    const auto add = [&](const json& parent, const char* children, uint32_t depth) {
        const auto list = parent.find(children);
        for (size_t i = 0; list != parent.end() && i < list->size(); ++i) {
            open.push_back({&list->at(i), depth});
            ++count;
        }
    };
    add(scene, "nodes", 1);
    while (!open.empty()) {
        const auto [name, depth] = open.back();
        open.pop_back();
        if (depth > kDeepestNode) {
            return fmt::format(
                "node {} lies more than {} nodes deep, or in itself; export it again "
                "with fewer levels",
                name->dump(), kDeepestNode);
        }
        if (count > std::max(kMostShared, nodes.size())) {
            return fmt::format(
                "node {} is one of more than {} there are because nodes have several "
                "parents; export it again as a tree",
                name->dump(), kMostShared);
        }
        const json& node = name->is_string() ? nodes.at(name->get_ref<const std::string&>())
                                             : nodes.at(whole_number(*name, "the index of a node"));
        add(node, "children", depth + 1);
    }
    return std::nullopt;
}

/// Assimp's parser of JSON recurses, too. What is broken otherwise is left to it.
std::optional<std::string> broken_json(std::string_view text)
{
    try {
        const json gltf = parse_json<json>(text);
        for (const json& scene : gltf.at("scenes")) {
            if (const auto problem = broken_nodes(gltf.at("nodes"), scene)) {
                return problem;
            }
        }
        return std::nullopt;
    } catch (const std::length_error& error) {
        return fmt::format("its JSON is {}; export it again, flatter", error.what());
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

/// The JSON of a glTF file is all of it, or a part of a binary one. That says how long it is: what
/// Assimp would make of half of one need not be found out.
std::optional<std::string> broken_gltf(const std::string& file, uintmax_t file_size)
{
    constexpr size_t kHeader = 20;
    std::ifstream in(file, std::ios::binary);
    std::string text(kHeader, '\0');
    const auto read_from = [&](size_t begin, size_t size) {
        text.resize(begin + size);
        in.read(text.data() + begin, static_cast<std::streamsize>(size));
        text.resize(begin + static_cast<size_t>(in.gcount()));
    };
    read_from(0, kHeader);
    if (!text.starts_with("glTF")) {
        const size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n"); // or a byte order mark
        if (first == std::string::npos || (text[first] != '{' && text[first] != '[')) {
            return std::nullopt; // not glTF
        }
        read_from(text.size(), static_cast<size_t>(file_size));
        return broken_json(text);
    }
    if (text.size() < kHeader) {
        return fmt::format("ends after {} bytes, inside the header; export or download it again",
                           file_size);
    }
    const auto word = [&](size_t at) {
        uint32_t value = 0;
        for (size_t i = 0; i < 4; ++i) {
            value |= uint32_t{static_cast<unsigned char>(text[at + i])} << (8 * i);
        }
        return value;
    };
    const uint32_t json_size = word(12);
    const uintmax_t least_size = std::max(uintmax_t{word(8)}, uintmax_t{kHeader} + json_size);
    if (least_size > file_size) {
        return fmt::format("ends after {} bytes, but its header says {}; it was cut off, export or "
                           "download it again",
                           file_size, least_size);
    }
    read_from(0, json_size);
    return broken_json(text);
}

/// Assimp 5.2 looks for the end of a PLY header for ever.
std::optional<std::string> broken_ply(const std::string& file)
{
    constexpr size_t kLongestHeader = 1 << 20;
    std::ifstream in(file, std::ios::binary);
    std::string head(kLongestHeader, '\0');
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<size_t>(in.gcount()));
    const bool is_ply = head.starts_with("ply\n") || head.starts_with("ply\r");
    if (!is_ply) {
        return std::nullopt;
    }
    const size_t end = head.find("\nend_header");
    const size_t after = end == std::string::npos ? end : end + std::strlen("\nend_header");
    if (after >= head.size() || (head[after] != '\n' && head[after] != '\r')) {
        return "has no whole PLY header, the line end_header is missing; export it again";
    }
    return std::nullopt;
}

} // namespace

std::optional<std::string> unreadable_by_assimp(const std::string& file, uintmax_t file_size)
{
    const auto problem = broken_gltf(file, file_size);
    return problem ? problem : broken_ply(file);
}

} // namespace occlude::tools
