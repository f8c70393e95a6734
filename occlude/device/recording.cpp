#include <occlude/device/recording.h>

#include <occlude/device/detail/recorded_calls.h>

#include <bit>
#include <istream>
#include <iterator>
#include <ostream>
#include <string_view>
#include <type_traits>

namespace occlude {

namespace {

// The format: this mark, the caps, the calls, and the FNV-1a hash of all bytes before it. Numbers
// are little-endian; lists start with their length in 32 bits.
constexpr std::string_view kMark = "occlrec4";

using Bytes = std::string;

uint64_t fnv1a(std::string_view bytes)
{
    uint64_t hash = 0xcbf29ce484222325ull;
    for (const char c : bytes) {
        hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001b3ull;
    }
    return hash;
}

class Writer {
public:
    Bytes bytes;

    void number(const uint64_t& value, int size)
    {
        for (int i = 0; i < size; ++i) {
            bytes.push_back(static_cast<char>(value >> (8 * i) & 0xff));
        }
    }
    template <class T>
    void list(const std::vector<T>& values, auto&& transfer_one)
    {
        number(values.size(), 4);
        for (const T& value : values) {
            transfer_one(value);
        }
    }
};

/// Reads numbers until the bytes end or are invalid; after that it has failed and reads zeros.
class Reader {
public:
    explicit Reader(std::string_view bytes)
        : bytes_(bytes)
    {
    }

    bool failed = false;

    bool at_end() const { return at_ == bytes_.size(); }

    void number(uint64_t& value, int size)
    {
        value = 0;
        failed = failed || bytes_.size() - at_ < static_cast<size_t>(size);
        for (int i = 0; !failed && i < size; ++i) {
            value |= uint64_t{static_cast<uint8_t>(bytes_[at_++])} << (8 * i);
        }
    }
    template <class T>
    void list(std::vector<T>& values, auto&& transfer_one)
    {
        uint64_t count = 0;
        number(count, 4);
        values.clear();
        // Grows one by one, so that a wrong count ends with the bytes and not with the memory.
        for (uint64_t i = 0; !failed && i < count; ++i) {
            transfer_one(values.emplace_back());
        }
    }

private:
    std::string_view bytes_;
    size_t at_ = 0;
};

/// Writes or reads values field by field, so that both agree on the order.
template <class Stream>
class Archive {
public:
    explicit Archive(Stream& stream)
        : stream_(stream)
    {
    }

    template <class T>
    void whole(T& value)
    {
        uint64_t bits = static_cast<uint64_t>(value);
        stream_.number(bits, static_cast<int>(sizeof(T)));
        assign(value, bits);
    }

    /// An enum or a flag: an error if it is above `last`.
    template <class T>
    void choice(T& value, std::remove_const_t<T> last)
    {
        uint64_t bits = static_cast<uint64_t>(value);
        stream_.number(bits, 1);
        if constexpr (kReads) {
            stream_.failed = stream_.failed || bits > static_cast<uint64_t>(last);
        }
        assign(value, bits);
    }

    template <class T>
    void real(T& value)
    {
        using Real = std::remove_const_t<T>;
        using Bits = std::conditional_t<std::is_same_v<Real, double>, uint64_t, uint32_t>;
        uint64_t bits = std::bit_cast<Bits>(value);
        stream_.number(bits, static_cast<int>(sizeof(Bits)));
        if constexpr (kReads) {
            value = std::bit_cast<Real>(static_cast<Bits>(bits));
        }
    }

    template <class T>
    void matrix(T& m)
    {
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 4; ++row) {
                real(m[column][row]);
            }
        }
    }

    template <class T>
    void list(T& values, auto&& transfer_one)
    {
        stream_.list(values, transfer_one);
    }

private:
    static constexpr bool kReads = std::is_same_v<Stream, Reader>;

    template <class T>
    void assign([[maybe_unused]] T& value, [[maybe_unused]] uint64_t bits)
    {
        if constexpr (kReads) {
            value = static_cast<T>(bits);
        }
    }

    Stream& stream_;
};

template <class Stream, class Box>
void transfer_box(Archive<Stream>& archive, Box& box)
{
    for (int axis = 0; axis < 3; ++axis) {
        archive.real(box.box.min[axis]);
        archive.real(box.box.max[axis]);
    }
    archive.whole(box.subject.value);
    bool has_matrix = box.world_from_box.has_value();
    archive.choice(has_matrix, true);
    if (!has_matrix) {
        return;
    }
    if constexpr (!std::is_const_v<Box>) {
        box.world_from_box.emplace(1.0f);
    }
    archive.matrix(*box.world_from_box);
}

template <class Stream, class Call>
void transfer_view(Archive<Stream>& archive, Call& call)
{
    archive.matrix(call.clip_from_world);
    archive.matrix(call.clip_from_relative);
    for (int axis = 0; axis < 3; ++axis) {
        archive.real(call.origin[axis]);
    }
    archive.whole(call.size_px.x);
    archive.whole(call.size_px.y);
    archive.choice(call.convention.range, DepthRange::zero_to_one);
    archive.choice(call.convention.order, DepthOrder::near_is_large);
    archive.whole(call.view_options.viewport_origin_px.x);
    archive.whole(call.view_options.viewport_origin_px.y);
    archive.whole(call.view_options.tag);
    archive.choice(call.view_options.ignores_near_plane, true);
}

template <class Stream, class Call>
void transfer_question(Archive<Stream>& archive, Call& call)
{
    archive.choice(call.verb, DeviceVerb::read_depth_tiles);
    archive.choice(call.pass, DrawPass::shade_equal);
    archive.choice(call.method, TestMethod::pyramid);
    if (call.verb == DeviceVerb::begin_frame) {
        transfer_view(archive, call);
    }
    archive.list(call.items, [&](auto& item) { archive.whole(item.value); });
    archive.list(call.boxes, [&](auto& box) { transfer_box(archive, box); });
    archive.list(call.test_ends, [&](auto& end) { archive.whole(end); });
    archive.whole(call.asked_test);
    if (call.verb == DeviceVerb::read_depth) {
        archive.whole(call.rect.x);
        archive.whole(call.rect.y);
        archive.whole(call.rect.width);
        archive.whole(call.rect.height);
    }
    if (call.verb == DeviceVerb::read_depth_tiles) {
        archive.whole(call.tile_px);
    }
}

template <class Stream, class Call>
void transfer_call(Archive<Stream>& archive, Call& call)
{
    transfer_question(archive, call);
    archive.list(call.issued_tests, [&](auto& test) { archive.whole(test); });
    archive.choice(call.answer.state, AnswerState::lost);
    archive.whole(call.answer.samples);
    archive.list(call.depth, [&](auto& depth) { archive.real(depth); });
}

template <class Stream, class Caps>
void transfer_caps(Archive<Stream>& archive, Caps& caps)
{
    std::vector<char> name(caps.name.begin(), caps.name.end());
    archive.list(name, [&](auto& letter) { archive.whole(letter); });
    if constexpr (!std::is_const_v<Caps>) {
        caps.name.assign(name.begin(), name.end());
    }
    archive.choice(caps.same_frame_results, true);
    archive.choice(caps.exact_counts, true);
    archive.choice(caps.draw_and_query, true);
    archive.choice(caps.read_depth, true);
    archive.choice(caps.samples_at_pixel_centers, true);
    archive.whole(caps.max_outstanding);
    archive.list(caps.methods, [&](auto& cost) {
        archive.choice(cost.method, TestMethod::pyramid);
        archive.real(cost.us_per_batch);
        archive.real(cost.us_per_test);
        archive.real(cost.us_per_box);
        archive.choice(cost.exact_counts, true);
    });
    archive.real(caps.us_per_triangle);
    archive.real(caps.us_per_item);
    archive.list(caps.depth_reads, [&](auto& read) {
        archive.whole(read.tile_px);
        archive.real(read.us_per_read);
        archive.real(read.us_per_pixel);
        archive.real(read.us_per_value);
    });
}

// The caps that begin_frame has changed, which are in the file and not in the hash.
template <class Stream, class Call>
void transfer_new_caps(Archive<Stream>& archive, Call& call)
{
    bool changed = call.new_caps.has_value();
    archive.choice(changed, true);
    if (!changed) {
        return;
    }
    if constexpr (!std::is_const_v<Call>) {
        call.new_caps.emplace();
    }
    transfer_caps(archive, *call.new_caps);
}

} // namespace

std::string detail::question_bytes(const RecordedCall& call)
{
    Writer writer;
    Archive archive{writer};
    transfer_question(archive, call);
    return std::move(writer.bytes);
}

std::string detail::caps_bytes(const DeviceCaps& caps)
{
    Writer writer;
    Archive archive{writer};
    transfer_caps(archive, caps);
    return std::move(writer.bytes);
}

uint64_t Recording::hash() const
{
    Writer writer;
    Archive archive{writer};
    archive.list(calls, [&](const RecordedCall& call) { transfer_call(archive, call); });
    return fnv1a(writer.bytes);
}

Result<size_t> save_recording(const Recording& recording, std::ostream& out)
{
    Writer writer;
    writer.bytes = kMark;
    Archive archive{writer};
    transfer_caps(archive, recording.caps);
    archive.list(recording.calls, [&](const RecordedCall& call) {
        transfer_call(archive, call);
        transfer_new_caps(archive, call);
    });
    const uint64_t checksum = fnv1a(writer.bytes);
    archive.whole(checksum);
    out.write(writer.bytes.data(), static_cast<std::streamsize>(writer.bytes.size()));
    if (!out) {
        return Error{ErrorCode::device_failed, "the recording could not be written: is the disk "
                                               "full, or the file read-only?"};
    }
    return writer.bytes.size();
}

Result<Recording> load_recording(std::istream& in)
{
    const Bytes bytes{std::istreambuf_iterator<char>{in}, std::istreambuf_iterator<char>{}};
    const auto broken = [](const char* how) {
        return Error{ErrorCode::bad_data,
                     std::string("the recording ") + how + ": record it again"};
    };
    constexpr size_t kChecksumSize = 8;
    if (!bytes.starts_with(kMark) || bytes.size() < kMark.size() + kChecksumSize) {
        return broken("does not start like a recording of this version");
    }
    const std::string_view body{bytes.data(), bytes.size() - kChecksumSize};
    Reader checksum_reader{std::string_view{bytes}.substr(body.size())};
    uint64_t checksum = 0;
    checksum_reader.number(checksum, kChecksumSize);
    if (checksum != fnv1a(body)) {
        return broken("is cut off or was changed (its checksum differs)");
    }

    Recording recording;
    Reader reader{body.substr(kMark.size())};
    Archive archive{reader};
    transfer_caps(archive, recording.caps);
    archive.list(recording.calls, [&](RecordedCall& call) {
        transfer_call(archive, call);
        transfer_new_caps(archive, call);
    });
    if (reader.failed || !reader.at_end()) {
        return broken("holds invalid calls");
    }
    return recording;
}

} // namespace occlude
