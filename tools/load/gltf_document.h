// A glTF 2.0 file as JSON and bytes: .gltf with its buffers, or .glb.
#pragma once

#include "load/mapped_file.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace occlude::tools {

/// What is wrong with a glTF file; caught by the loader.
class GltfError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// The file is glTF of version 1, which another reader must read.
class GltfVersion1 : public GltfError {
public:
    using GltfError::GltfError;
};

using Bytes = std::span<const uint8_t>;

/// The JSON of a glTF file, parsed, and its buffers, opened when they are asked for.
class GltfDocument {
public:
    /// Throws GltfError for what is no glTF 2.0, or cut off. `memory_budget`: bytes that decoding
    /// may allocate in all.
    GltfDocument(const std::filesystem::path& file, uint64_t memory_budget);

    const nlohmann::json& root() const { return root_; }
    /// The list `key` of the root; an empty one if there is none.
    const nlohmann::json& list(const char* key) const;
    /// The entry of a list. Throws GltfError if there is none.
    const nlohmann::json& entry(const char* list, size_t index) const;

    /// The bytes of a buffer. Throws GltfError if it has none or too few.
    Bytes buffer(size_t index);
    /// The bytes of an image that is a file or a data URI. Throws GltfError.
    Bytes uri_bytes(const std::string& uri);

    /// Counts bytes that are about to be allocated. Throws GltfError beyond the budget.
    void charge(uint64_t bytes);

private:
    void parse(std::string_view text);

    std::filesystem::path file_;
    MappedFile mapped_;
    nlohmann::json root_;
    Bytes binary_chunk_;
    std::vector<std::optional<Bytes>> buffers_;
    std::vector<MappedFile> external_;
    std::vector<std::vector<uint8_t>> decoded_; ///< of data URIs
    uint64_t budget_left_;
};

/// Whether a file starts like glTF of version 2: as JSON, or as a binary file of that version.
bool looks_like_gltf_2(const std::filesystem::path& file);

/// A member as a whole number below 2^32. Throws GltfError if it is of another kind.
uint32_t index_of(const nlohmann::json& object, const char* key);
/// The same, or `otherwise` if there is no such member.
uint32_t index_or(const nlohmann::json& object, const char* key, uint32_t otherwise);
/// A number, or `otherwise` if there is none.
double number_or(const nlohmann::json& object, const char* key, double otherwise);
/// A text, or an empty one.
std::string text_of(const nlohmann::json& object, const char* key);
/// The extension of an object, or null.
const nlohmann::json* extension_of(const nlohmann::json& object, const char* name);

/// %20 and the like as the bytes they stand for.
std::string unescaped_uri(std::string_view uri);

} // namespace occlude::tools
