#include "load/glb_writer.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <vector>

static_assert(std::endian::native == std::endian::little, "glTF is little-endian, and so is this");

namespace occlude::tools {
namespace {

using nlohmann::json;

// Numbers that the glTF 2.0 specification gives.
constexpr uint32_t kMagic = 0x46546c67;
constexpr uint32_t kJsonChunk = 0x4e4f534a;
constexpr uint32_t kBinaryChunk = 0x004e4942;
constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

json list_of(const glm::vec3& v)
{
    return json::array({v.x, v.y, v.z});
}

class Writer {
public:
    explicit Writer(const SceneModel& model)
        : model_(model)
    {
    }

    json document()
    {
        json root;
        root["asset"] = {{"version", "2.0"}, {"generator", "occlude"}};
        root["scene"] = 0;
        add_materials(root);
        for (size_t i = 0; i < model_.meshes.size(); ++i) {
            add_mesh(root, model_.meshes[i], i);
        }
        add_nodes(root);
        root["buffers"] = json::array({{{"byteLength", binary_.size()}}});
        return root;
    }

    /// What document() refers to; a multiple of four bytes.
    const std::string& binary() const { return binary_; }

private:
    template <class T>
    size_t add_view(json& root, const std::vector<T>& values, int target)
    {
        const size_t bytes = values.size() * sizeof(T);
        root["bufferViews"].push_back({{"buffer", 0},
                                       {"byteOffset", binary_.size()},
                                       {"byteLength", bytes},
                                       {"target", target}});
        binary_.append(reinterpret_cast<const char*>(values.data()), bytes);
        return root["bufferViews"].size() - 1;
    }

    void add_materials(json& root)
    {
        std::vector<glm::dvec4> sums(model_.meshes.size(), glm::dvec4{0.0});
        std::vector<double> counts(model_.meshes.size(), 0.0);
        std::vector<bool> see_through(model_.meshes.size(), false);
        for (const Instance& instance : model_.instances) {
            sums[instance.mesh] += glm::dvec4{glm::vec4{instance.color, instance.opacity}};
            counts[instance.mesh] += 1.0;
            see_through[instance.mesh] = see_through[instance.mesh] || instance.see_through;
        }
        for (size_t i = 0; i < sums.size(); ++i) {
            const glm::dvec4 mean =
                counts[i] > 0.0 ? sums[i] / counts[i] : glm::dvec4{0.7, 0.7, 0.7, 1.0};
            const auto unit = [](double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; };
            json material{{"pbrMetallicRoughness",
                           {{"baseColorFactor",
                             json::array({unit(mean.x), unit(mean.y), unit(mean.z), unit(mean.w)})},
                            {"metallicFactor", 0.0}}},
                          {"doubleSided", true}};
            if (mean.w < 1.0 || see_through[i]) {
                material["alphaMode"] = "BLEND";
            }
            root["materials"].push_back(std::move(material));
        }
    }

    void add_mesh(json& root, const Mesh& mesh, size_t material)
    {
        Aabb box;
        for (const glm::vec3& p : mesh.positions) {
            box = merge(box, {p, p});
        }
        const size_t first = root.contains("accessors") ? root["accessors"].size() : 0;
        root["accessors"].push_back({{"bufferView", add_view(root, mesh.positions, kArrayBuffer)},
                                     {"componentType", kFloat},
                                     {"count", mesh.positions.size()},
                                     {"type", "VEC3"},
                                     {"min", list_of(box.min)},
                                     {"max", list_of(box.max)}});
        root["accessors"].push_back({{"bufferView", add_view(root, mesh.normals, kArrayBuffer)},
                                     {"componentType", kFloat},
                                     {"count", mesh.normals.size()},
                                     {"type", "VEC3"}});
        root["accessors"].push_back(
            {{"bufferView", add_view(root, mesh.indices, kElementArrayBuffer)},
             {"componentType", kUnsignedInt},
             {"count", mesh.indices.size()},
             {"type", "SCALAR"}});
        const json primitive{{"attributes", {{"POSITION", first}, {"NORMAL", first + 1}}},
                             {"indices", first + 2},
                             {"material", material}};
        root["meshes"].push_back({{"name", mesh.name}, {"primitives", json::array({primitive})}});
    }

    void add_nodes(json& root) const
    {
        json nodes = json::array();
        json roots = json::array();
        for (const Instance& instance : model_.instances) {
            json matrix = json::array();
            for (int column = 0; column < 4; ++column) {
                for (int row = 0; row < 4; ++row) {
                    matrix.push_back(instance.world_from_mesh[column][row]);
                }
            }
            roots.push_back(nodes.size());
            nodes.push_back(
                {{"name", instance.name}, {"mesh", instance.mesh}, {"matrix", std::move(matrix)}});
        }
        if (const std::optional<json> frame = frame_node(roots)) {
            roots = json::array({nodes.size()});
            nodes.push_back(*frame);
        }
        root["nodes"] = std::move(nodes);
        root["scenes"] = json::array({{{"nodes", std::move(roots)}}});
    }

    /// A parent of all nodes that makes metres with +y up of the scene's own frame; none where it
    /// is that already.
    std::optional<json> frame_node(const json& children) const
    {
        const glm::vec3 y_up{0.0f, 1.0f, 0.0f};
        if (model_.unit == 1.0f && model_.up == y_up && model_.origin == glm::dvec3{0.0}) {
            return std::nullopt;
        }
        const glm::dquat turn = turn_to_y(glm::normalize(glm::dvec3{model_.up}));
        const double metres = 1.0 / static_cast<double>(model_.unit);
        const glm::dvec3 place = metres * (turn * model_.origin);
        return json{{"name", "metres, y up"},
                    {"children", children},
                    {"translation", json::array({place.x, place.y, place.z})},
                    {"rotation", json::array({turn.x, turn.y, turn.z, turn.w})},
                    {"scale", json::array({metres, metres, metres})}};
    }

    static glm::dquat turn_to_y(const glm::dvec3& up)
    {
        const glm::dvec3 y_up{0.0, 1.0, 0.0};
        const glm::dvec3 axis = glm::cross(up, y_up);
        const double cosine = glm::dot(up, y_up);
        if (glm::length(axis) < 1e-12) { // already so, or upside down
            return cosine > 0.0 ? glm::dquat{1.0, 0.0, 0.0, 0.0} : glm::dquat{0.0, 1.0, 0.0, 0.0};
        }
        return glm::normalize(glm::dquat{1.0 + cosine, axis.x, axis.y, axis.z});
    }

    const SceneModel& model_;
    std::string binary_;
};

void append(std::string& out, uint32_t value)
{
    char bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    out.append(bytes, sizeof(value));
}

void append_chunk(std::string& out, uint32_t type, const std::string& content)
{
    append(out, static_cast<uint32_t>(content.size()));
    append(out, type);
    out += content;
}

} // namespace

Result<std::string> to_glb(const SceneModel& model)
{
    constexpr size_t kHeader = 12;
    constexpr size_t kChunkHeader = 8;
    Writer writer(model);
    std::string text = writer.document().dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const size_t size = kHeader + 2 * kChunkHeader + text.size() + writer.binary().size();
    if (size > std::numeric_limits<uint32_t>::max()) {
        return Error{
            ErrorCode::unsupported,
            fmt::format("{}: would be {} bytes, and a .glb file has at most 4 GiB; ask for "
                        "fewer triangles or objects",
                        model.name, size)};
    }
    std::string out;
    out.reserve(size);
    append(out, kMagic);
    append(out, 2);
    append(out, static_cast<uint32_t>(size));
    append_chunk(out, kJsonChunk, text);
    append_chunk(out, kBinaryChunk, writer.binary());
    return out;
}

} // namespace occlude::tools
