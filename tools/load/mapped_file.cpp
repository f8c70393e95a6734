#include "load/mapped_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace occlude::tools {

Result<MappedFile> MappedFile::open(const std::filesystem::path& file)
{
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) {
        return Error{ErrorCode::not_found,
                     fmt::format("{}: cannot be read ({})", file.string(), std::strerror(errno))};
    }
    auto mapped = of_descriptor(descriptor, file.string());
    ::close(descriptor);
    return mapped;
}

Result<MappedFile> MappedFile::of_descriptor(int descriptor, const std::string& name)
{
    struct stat status {};
    if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
        return Error{ErrorCode::bad_data, fmt::format("{}: is not a file", name)};
    }
    MappedFile mapped;
    const auto size = static_cast<size_t>(status.st_size);
    if (size == 0) {
        return mapped;
    }
    void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (data == MAP_FAILED) {
        return Error{ErrorCode::bad_data,
                     fmt::format("{}: cannot be mapped ({})", name, std::strerror(errno))};
    }
    mapped.data_ = static_cast<const uint8_t*>(data);
    mapped.size_ = size;
    return mapped;
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr))
    , size_(std::exchange(other.size_, 0))
{
}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept
{
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
}

MappedFile::~MappedFile()
{
    if (data_ != nullptr) {
        ::munmap(const_cast<uint8_t*>(data_), size_);
    }
}

} // namespace occlude::tools
