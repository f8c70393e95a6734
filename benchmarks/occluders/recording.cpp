#include "recording.h"

#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>

namespace occlude::benchmarks {

namespace {

constexpr uint32_t kMagic = 0xA701B600;
enum RecordKind : uint8_t { render = 0, test_rectangle = 1, test_triangles = 2, clear = 3 };

class Reader {
public:
    explicit Reader(std::vector<char> bytes)
        : bytes_(std::move(bytes))
    {
    }
    template <class T>
    T read()
    {
        T value{};
        if (const auto from = take(sizeof(T)); from.size() == sizeof(T)) {
            std::memcpy(&value, from.data(), sizeof(T));
        }
        return value;
    }
    std::span<const char> take(size_t count)
    {
        if (count > bytes_.size() - at_) {
            good_ = false;
            return {};
        }
        const auto taken = std::span{bytes_}.subspan(at_, count);
        at_ += count;
        return taken;
    }
    bool good() const { return good_; }

private:
    std::vector<char> bytes_;
    size_t at_ = 0;
    bool good_ = true;
};

// Reads the triangles of a record. Only rendered triangles count. False without a matrix.
bool read_triangles(Reader& reader, bool rendered, Recording& recording)
{
    reader.read<int32_t>(); // result
    const auto vertices = reader.read<int32_t>();
    if (vertices <= 0) {
        return reader.good();
    }
    const auto stride = static_cast<size_t>(reader.read<int32_t>());
    const auto positions = reader.take(stride * static_cast<size_t>(vertices));
    const auto triangles = static_cast<size_t>(reader.read<int32_t>());
    const auto index_bytes = reader.take(3 * triangles * sizeof(uint32_t));
    if (!reader.good() || reader.read<uint8_t>() == 0) {
        return false;
    }
    std::array<float, 16> matrix{};
    for (float& m : matrix) {
        m = reader.read<float>();
    }
    reader.take(5 * sizeof(int32_t)); // clip planes, winding, layout
    if (!rendered || !reader.good()) {
        return reader.good();
    }
    std::vector<uint32_t> indices(3 * triangles);
    std::memcpy(indices.data(), index_bytes.data(), index_bytes.size());
    const glm::mat4 clip_from_mesh = glm::make_mat4(matrix.data());
    if (recording.instances.empty()) {
        recording.clip_from_world = clip_from_mesh;
    }
    glm::dmat4 world_from_mesh =
        glm::inverse(glm::dmat4{recording.clip_from_world}) * glm::dmat4{clip_from_mesh};
    for (int column = 0; column < 4; ++column) { // affine but for rounding
        world_from_mesh[column].w = column == 3 ? 1.0 : 0.0;
    }
    const PositionStream stream(positions.data(), static_cast<size_t>(vertices), stride);
    recording.instances.push_back(
        {OccluderMesh::prepare(stream, indices), glm::mat4{world_from_mesh}});
    recording.triangles += triangles;
    return true;
}

} // namespace

std::optional<Recording> read_recording(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    Reader reader({std::istreambuf_iterator<char>(file), {}});
    Recording recording;
    if (!file || reader.read<uint32_t>() != kMagic) {
        return std::nullopt;
    }
    reader.read<float>(); // near
    recording.size_px.x = static_cast<int>(reader.read<uint32_t>());
    recording.size_px.y = static_cast<int>(reader.read<uint32_t>());
    while (reader.good()) {
        const auto kind = reader.read<uint8_t>();
        if (kind == render || kind == test_triangles) {
            if (!read_triangles(reader, kind == render, recording)) {
                return std::nullopt;
            }
        } else if (kind == test_rectangle) {
            reader.take(sizeof(int32_t) + 5 * sizeof(float));
        } else if (kind != clear) {
            break;
        }
    }
    return recording.instances.empty() ? std::nullopt : std::optional{std::move(recording)};
}

} // namespace occlude::benchmarks
