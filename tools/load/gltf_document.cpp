#include "load/gltf_document.h"

#include "files/parse_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>

namespace occlude::tools {
namespace {

using nlohmann::json;

constexpr size_t kHeader = 12;
constexpr size_t kChunkHeader = 8;
constexpr uint32_t kJsonChunk = 0x4e4f534a;
constexpr uint32_t kBinaryChunk = 0x004e4942;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

uint32_t word_at(Bytes bytes, size_t at)
{
    uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value); // glTF is little-endian, and so are we
    return value;
}

std::string_view as_text(Bytes bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Throws GltfError if a character is not of base64.
std::vector<uint8_t> from_base64(std::string_view text)
{
    std::array<int8_t, 256> value_of{};
    value_of.fill(-1);
    constexpr std::string_view kAlphabet =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < kAlphabet.size(); ++i) {
        value_of[static_cast<unsigned char>(kAlphabet[i])] = static_cast<int8_t>(i);
    }
    std::vector<uint8_t> bytes;
    bytes.reserve(text.size() / 4 * 3);
    uint32_t bits = 0;
    int bit_count = 0;
    for (const char c : text) {
        if (c == '=') {
            break;
        }
        const int8_t value = value_of[static_cast<unsigned char>(c)];
        if (value < 0) {
            throw GltfError{"a data URI holds a character that is not of base64"};
        }
        bits = (bits << 6) | static_cast<uint32_t>(value);
        bit_count += 6;
        if (bit_count >= 8) {
            bit_count -= 8;
            bytes.push_back(static_cast<uint8_t>(bits >> bit_count));
        }
    }
    return bytes;
}

} // namespace

bool looks_like_gltf_2(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    std::string start(4096, '\0');
    in.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<size_t>(in.gcount()));
    if (start.starts_with("glTF")) {
        return start.size() < 8 || start[4] == 2; // what is cut off: let the reader say so
    }
    const size_t first = start.find_first_not_of("\xEF\xBB\xBF \t\r\n");
    if (first == std::string::npos || (start[first] != '{' && start[first] != '[')) {
        return false;
    }
    return true;
}

GltfDocument::GltfDocument(const std::filesystem::path& file, uint64_t memory_budget)
    : file_(file)
    , budget_left_(memory_budget)
{
    auto mapped = MappedFile::open(file);
    if (!mapped) {
        throw GltfError{mapped.error().message};
    }
    mapped_ = std::move(*mapped);
    const Bytes all = mapped_.bytes();
    if (!as_text(all).starts_with("glTF")) {
        std::string_view text = as_text(all);
        if (text.starts_with(kByteOrderMark)) {
            text.remove_prefix(kByteOrderMark.size());
        }
        parse(text);
        return;
    }
    if (all.size() < kHeader + kChunkHeader) {
        throw GltfError{fmt::format("ends after {} bytes, inside the header; export or download it "
                                    "again",
                                    all.size())};
    }
    const uint64_t json_size = word_at(all, kHeader);
    const uint64_t needed = std::max<uint64_t>(word_at(all, 8), kHeader + kChunkHeader + json_size);
    if (needed > all.size()) {
        throw GltfError{fmt::format("ends after {} bytes, but its header says {}; it was cut off, "
                                    "export or download it again",
                                    all.size(), needed)};
    }
    if (word_at(all, kHeader + 4) != kJsonChunk) {
        throw GltfError{"its first chunk is not JSON; export it again"};
    }
    const size_t after_json = kHeader + kChunkHeader + json_size;
    if (after_json + kChunkHeader <= all.size() && word_at(all, after_json + 4) == kBinaryChunk) {
        const size_t size = word_at(all, after_json);
        if (size > all.size() - after_json - kChunkHeader) {
            throw GltfError{"its binary chunk is cut off; export or download it again"};
        }
        binary_chunk_ = all.subspan(after_json + kChunkHeader, size);
    }
    parse(as_text(all.subspan(kHeader + kChunkHeader, json_size)));
}

void GltfDocument::parse(std::string_view text)
{
    try {
        root_ = parse_json<json>(text);
    } catch (const std::length_error& error) {
        throw GltfError{fmt::format("its JSON is {}; export it again, flatter", error.what())};
    } catch (const json::exception& error) {
        throw GltfError{fmt::format("cannot be read as a scene: its JSON is broken ({}); export or "
                                    "download it again",
                                    error.what())};
    }
    const std::string version =
        root_.contains("asset") ? text_of(root_["asset"], "version") : std::string{};
    if (!version.starts_with("2")) {
        const auto meshes = root_.is_object() ? root_.find("meshes") : root_.end();
        const auto nodes = root_.is_object() ? root_.find("nodes") : root_.end();
        const bool names_entries =
            (root_.is_object() && meshes != root_.end() && meshes->is_object()) ||
            (root_.is_object() && nodes != root_.end() && nodes->is_object());
        if (version.starts_with("1") || names_entries) {
            throw GltfVersion1{"is glTF of version 1"};
        }
        throw GltfError{
            "cannot be read as a scene: it is JSON, but no glTF 2.0 (its \"asset\" does "
            "not say so); export it as glTF 2.0"};
    }
    buffers_.resize(list("buffers").size());
}

const json& GltfDocument::list(const char* key) const
{
    static const json kEmpty = json::array();
    const auto found = root_.find(key);
    if (found == root_.end()) {
        return kEmpty;
    }
    if (!found->is_array()) {
        throw GltfError{fmt::format("\"{}\" is not a list; export it again", key)};
    }
    return *found;
}

const json& GltfDocument::entry(const char* key, size_t index) const
{
    const json& entries = list(key);
    if (index >= entries.size() || !entries[index].is_object()) {
        throw GltfError{
            fmt::format("names entry {} of \"{}\", which has {}; the file is broken, export it "
                        "again",
                        index, key, entries.size())};
    }
    return entries[index];
}

Bytes GltfDocument::uri_bytes(const std::string& uri)
{
    if (uri.starts_with("data:")) {
        const size_t comma = uri.find(',');
        if (comma == std::string::npos ||
            uri.substr(0, comma).find(";base64") == std::string::npos) {
            throw GltfError{"has a data URI that is not base64; export it again"};
        }
        charge(uri.size());
        return decoded_.emplace_back(from_base64(std::string_view{uri}.substr(comma + 1)));
    }
    auto mapped = MappedFile::open(file_.parent_path() / unescaped_uri(uri));
    if (!mapped) { // some exporters escape nothing, not even a percent sign
        mapped = MappedFile::open(file_.parent_path() / uri);
    }
    if (!mapped) {
        throw GltfError{fmt::format("needs the file '{}' beside it, which cannot be read; copy it "
                                    "there, or export as GLB",
                                    unescaped_uri(uri))};
    }
    return external_.emplace_back(std::move(*mapped)).bytes();
}

Bytes GltfDocument::buffer(size_t index)
{
    const json& description = entry("buffers", index);
    std::optional<Bytes>& known = buffers_[index];
    if (known) {
        return *known;
    }
    const std::string uri = text_of(description, "uri");
    const Bytes bytes = uri.empty() ? (index == 0 ? binary_chunk_ : Bytes{}) : uri_bytes(uri);
    const uint32_t length = index_of(description, "byteLength");
    if (bytes.size() < length) {
        throw GltfError{fmt::format("buffer {} should have {} bytes and has {}; the file was cut "
                                    "off, export or download it again",
                                    index, length, bytes.size())};
    }
    known = bytes.first(length);
    return *known;
}

void GltfDocument::charge(uint64_t bytes)
{
    if (bytes > budget_left_) {
        throw GltfError{"needs more memory than it may use; raise --load-memory, or give a smaller "
                        "scene"};
    }
    budget_left_ -= bytes;
}

uint32_t index_of(const json& object, const char* key)
{
    const auto found = object.find(key);
    if (found == object.end()) {
        throw GltfError{
            fmt::format("an entry has no \"{}\"; the file is broken, export it again", key)};
    }
    const bool whole = found->is_number_unsigned() ||
                       (found->is_number_float() && found->get<double>() >= 0.0 &&
                        found->get<double>() == static_cast<double>(found->get<uint64_t>()));
    if (!whole || found->get<uint64_t>() >= UINT32_MAX) {
        throw GltfError{
            fmt::format("\"{}\" is {}, which is no index; the file is broken, export it "
                        "again",
                        key, found->dump())};
    }
    return static_cast<uint32_t>(found->get<uint64_t>());
}

uint32_t index_or(const json& object, const char* key, uint32_t otherwise)
{
    return object.contains(key) ? index_of(object, key) : otherwise;
}

double number_or(const json& object, const char* key, double otherwise)
{
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<double>() : otherwise;
}

std::string text_of(const json& object, const char* key)
{
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string{};
}

const json* extension_of(const json& object, const char* name)
{
    const auto extensions = object.is_object() ? object.find("extensions") : object.end();
    if (extensions == object.end() || !extensions->is_object()) {
        return nullptr;
    }
    const auto found = extensions->find(name);
    return found != extensions->end() && found->is_object() ? &*found : nullptr;
}

std::string unescaped_uri(std::string_view uri)
{
    const auto digit = [](char c) {
        return c >= '0' && c <= '9'   ? c - '0'
               : c >= 'a' && c <= 'f' ? c - 'a' + 10
               : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                      : -1;
    };
    std::string text;
    for (size_t i = 0; i < uri.size(); ++i) {
        const bool escape =
            uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0;
        text.push_back(escape ? static_cast<char>(16 * digit(uri[i + 1]) + digit(uri[i + 2]))
                              : uri[i]);
        i += escape ? 2 : 0;
    }
    return text;
}

} // namespace occlude::tools
