// Writes and reads fields in the same order: one function describes both.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace occlude::tools {

class ByteWriter {
public:
    static constexpr bool kReads = false;

    std::string bytes;

    template <class T>
    void number(const T& value)
    {
        if constexpr (std::is_same_v<T, float>) {
            number(std::bit_cast<uint32_t>(value));
        } else if constexpr (std::is_same_v<T, double>) {
            number(std::bit_cast<uint64_t>(value));
        } else {
            for (size_t i = 0; i < sizeof(T); ++i) {
                bytes.push_back(static_cast<char>(static_cast<uint64_t>(value) >> (8 * i) & 0xff));
            }
        }
    }
    /// An enum or a flag.
    template <class T>
    void choice(const T& value, T)
    {
        number(static_cast<uint8_t>(value));
    }
    void text(const std::string& value)
    {
        number(uint64_t{value.size()});
        bytes += value;
    }
    template <class T>
    void list(const std::vector<T>& values, auto&& transfer_one)
    {
        number(uint64_t{values.size()});
        for (const T& value : values) {
            transfer_one(value);
        }
    }
};

/// Reads until the bytes end or are invalid; after that it has failed and leaves values unchanged.
class ByteReader {
public:
    static constexpr bool kReads = true;

    explicit ByteReader(std::string_view bytes)
        : rest_(bytes)
    {
    }

    bool failed() const { return failed_; }
    bool at_end() const { return rest_.empty(); }

    template <class T>
    void number(T& value)
    {
        if constexpr (std::is_same_v<T, float>) {
            uint32_t bits = 0;
            number(bits);
            value = std::bit_cast<float>(bits);
        } else if constexpr (std::is_same_v<T, double>) {
            uint64_t bits = 0;
            number(bits);
            value = std::bit_cast<double>(bits);
        } else {
            failed_ = failed_ || rest_.size() < sizeof(T);
            if (failed_) {
                return;
            }
            uint64_t bits = 0;
            for (size_t i = 0; i < sizeof(T); ++i) {
                bits |= uint64_t{static_cast<uint8_t>(rest_[i])} << (8 * i);
            }
            value = static_cast<T>(bits);
            rest_.remove_prefix(sizeof(T));
        }
    }
    /// Fails if it is above `last`.
    template <class T>
    void choice(T& value, T last)
    {
        uint8_t bits = 0;
        number(bits);
        failed_ = failed_ || bits > static_cast<uint8_t>(last);
        if (!failed_) {
            value = static_cast<T>(bits);
        }
    }
    void text(std::string& value)
    {
        uint64_t size = 0;
        number(size);
        failed_ = failed_ || size > rest_.size();
        if (!failed_) {
            value.assign(rest_.substr(0, size));
            rest_.remove_prefix(size);
        }
    }
    template <class T>
    void list(std::vector<T>& values, auto&& transfer_one)
    {
        uint64_t count = 0;
        number(count);
        // Grows one by one, so that a wrong count ends with the bytes and not with the memory.
        for (uint64_t i = 0; i < count && !failed_; ++i) {
            if (rest_.empty()) {
                failed_ = true;
                return;
            }
            transfer_one(values.emplace_back());
        }
    }

private:
    std::string_view rest_;
    bool failed_ = false;
};

} // namespace occlude::tools
