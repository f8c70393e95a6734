// The bytes of a file, mapped into memory.
#pragma once

#include <occlude/core/result.h>

#include <cstdint>
#include <filesystem>
#include <span>

namespace occlude::tools {

class MappedFile {
public:
    /// Maps a regular file. Errors name the file and the reason.
    static Result<MappedFile> open(const std::filesystem::path& file);
    /// Maps what a descriptor refers to, which may be closed afterwards.
    static Result<MappedFile> of_descriptor(int descriptor, const std::string& name);

    MappedFile() = default;
    MappedFile(MappedFile&& other) noexcept;
    MappedFile& operator=(MappedFile&& other) noexcept;
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    ~MappedFile();

    std::span<const uint8_t> bytes() const { return {data_, size_}; }

private:
    const uint8_t* data_ = nullptr;
    size_t size_ = 0;
};

} // namespace occlude::tools
