#include "load/scene_bytes.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace occlude::tools {
namespace {

/// Change it with every change of what is written.
constexpr std::string_view kMagic = "occlude scene 2\n";
constexpr std::string_view kEnd = "end of scene\n";

class Writer {
public:
    explicit Writer(std::FILE* out)
        : out_(out)
    {
    }
    void raw(const void* data, size_t size)
    {
        good_ = good_ && (size == 0 || std::fwrite(data, 1, size, out_) == size);
    }
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void field(const T& value) { raw(&value, sizeof value); }
    void field(const std::string& text)
    {
        field(uint64_t{text.size()});
        raw(text.data(), text.size());
    }
    template <class T>
    void field(const std::vector<T>& values)
    {
        field(uint64_t{values.size()});
        if constexpr (std::is_trivially_copyable_v<T>) {
            raw(values.data(), values.size() * sizeof(T));
        } else {
            for (const T& value : values) {
                entry(*this, value);
            }
        }
    }
    template <class T>
    void field(const std::optional<T>& value)
    {
        field(uint8_t{value.has_value()});
        field(value.value_or(T{}));
    }
    bool good() const { return good_; }

private:
    std::FILE* out_;
    bool good_ = true;
};

class Reader {
public:
    explicit Reader(std::span<const uint8_t> bytes)
        : bytes_(bytes)
    {
    }
    void raw(void* data, size_t size)
    {
        if (size > bytes_.size()) {
            good_ = false;
            bytes_ = {};
        }
        if (good_ && size > 0) {
            std::memcpy(data, bytes_.data(), size);
            bytes_ = bytes_.subspan(size);
        }
    }
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void field(T& value) { raw(&value, sizeof value); }
    void field(bool& value)
    {
        uint8_t byte = 0;
        field(byte);
        value = byte != 0;
    }
    void field(std::string& text)
    {
        text.resize(count(1));
        raw(text.data(), text.size());
    }
    template <class T>
    void field(std::vector<T>& values)
    {
        if constexpr (std::is_trivially_copyable_v<T>) {
            values.resize(count(sizeof(T)));
            raw(values.data(), values.size() * sizeof(T));
        } else {
            values.resize(count(1));
            for (T& value : values) {
                entry(*this, value);
            }
        }
    }
    template <class T>
    void field(std::optional<T>& value)
    {
        uint8_t has_value = 0;
        T content{};
        field(has_value);
        field(content);
        value = has_value != 0 ? std::optional{content} : std::nullopt;
    }
    bool good() const { return good_; }

private:
    // Elements that are left can be no more than bytes are.
    size_t count(size_t element_size)
    {
        uint64_t value = 0;
        field(value);
        if (value > bytes_.size() / element_size) {
            good_ = false;
            value = 0;
        }
        return value;
    }

    std::span<const uint8_t> bytes_;
    bool good_ = true;
};

template <class Archive, class... Fields>
void fields(Archive& archive, Fields&... all)
{
    (archive.field(all), ...);
}

template <class T, class Kind>
concept Is = std::is_same_v<std::remove_const_t<T>, Kind>;

// The same list of fields writes and reads: `archive` is a Writer with a const record, or a Reader.

template <class Archive>
void entry(Archive& archive, Is<std::string> auto& text)
{
    archive.field(text);
}

template <class Archive>
void entry(Archive& archive, Is<LoadedMesh> auto& mesh)
{
    fields(archive, mesh.name, mesh.positions, mesh.normals, mesh.indices, mesh.material,
           mesh.left_out);
}

template <class Archive>
void entry(Archive& archive, Is<LoadedInstance> auto& instance)
{
    fields(archive, instance.name, instance.mesh, instance.world_from_mesh);
}

template <class Archive>
void entry(Archive& archive, Is<LoadedMaterial> auto& material)
{
    fields(archive, material.name, material.color, material.opacity, material.surface);
}

template <class Archive>
void entry(Archive& archive, Is<SourceFile> auto& source)
{
    fields(archive, source.path, source.hash);
}

template <class Archive>
void entry(Archive& archive, Is<LoadedCamera> auto& camera)
{
    fields(archive, camera.name, camera.eye, camera.forward, camera.up, camera.fov_y, camera.near,
           camera.far);
}

template <class Archive>
void entry(Archive& archive, Is<LoadedScene> auto& scene)
{
    fields(archive, scene.meshes, scene.instances, scene.materials, scene.cameras,
           scene.units_per_metre, scene.up, scene.format_is_metric, scene.notes, scene.sources);
}

bool consistent(const LoadedScene& scene)
{
    const auto is_known = [](const LoadedMaterial& material) {
        return material.surface <= Surface::transmissive;
    };
    if (!std::all_of(scene.materials.begin(), scene.materials.end(), is_known)) {
        return false;
    }
    for (const LoadedMesh& mesh : scene.meshes) {
        const bool whole = mesh.indices.size() % 3 == 0 &&
                           (mesh.normals.empty() || mesh.normals.size() == mesh.positions.size()) &&
                           (mesh.material == kNoMaterial || mesh.material < scene.materials.size());
        const auto inside = [&](uint32_t index) { return index < mesh.positions.size(); };
        if (!whole || !std::all_of(mesh.indices.begin(), mesh.indices.end(), inside)) {
            return false;
        }
    }
    return std::all_of(
        scene.instances.begin(), scene.instances.end(),
        [&](const LoadedInstance& instance) { return instance.mesh < scene.meshes.size(); });
}

} // namespace

bool write_scene(std::FILE* out, const LoadedScene& scene)
{
    Writer writer(out);
    writer.raw(kMagic.data(), kMagic.size());
    entry(writer, scene);
    writer.raw(kEnd.data(), kEnd.size());
    return writer.good();
}

std::optional<LoadedScene> read_scene(std::span<const uint8_t> bytes)
{
    Reader reader(bytes);
    std::string magic(kMagic.size(), '\0');
    std::string end(kEnd.size(), '\0');
    reader.raw(magic.data(), magic.size());
    if (!reader.good() || magic != kMagic) {
        return std::nullopt;
    }
    LoadedScene scene;
    entry(reader, scene);
    reader.raw(end.data(), end.size());
    return reader.good() && end == kEnd && consistent(scene) ? std::optional{std::move(scene)}
                                                             : std::nullopt;
}

} // namespace occlude::tools
