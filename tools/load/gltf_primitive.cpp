#include "load/gltf_primitive.h"

#include "load/gltf_draco.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <numeric>

namespace occlude::tools {
namespace {

using nlohmann::json;

// What mode a primitive has, by the numbers of the specification.
enum Mode : uint32_t {
    kPoints = 0,
    kLines = 1,
    kLineLoop = 2,
    kLineStrip = 3,
    kTriangles = 4,
    kTriangleStrip = 5,
    kTriangleFan = 6,
};

/// Indices in the order of the primitive, each below `vertices`.
std::vector<uint32_t> read_indices(GltfDocument& document, GltfAccessors& accessors,
                                   const json& primitive, size_t vertices)
{
    std::vector<uint32_t> indices;
    if (!primitive.contains("indices")) {
        document.charge(vertices * sizeof(uint32_t));
        indices.resize(vertices);
        std::iota(indices.begin(), indices.end(), 0u);
        return indices;
    }
    const AccessorView& view = accessors.open(index_of(primitive, "indices"), "SCALAR");
    document.charge(view.count() * sizeof(uint32_t));
    indices.reserve(view.count());
    for (size_t i = 0; i < view.count(); ++i) {
        const uint32_t index = view.whole(i, 0);
        if (index >= vertices) {
            throw GltfError{fmt::format("index {} of a mesh names vertex {} of {}; the file is "
                                        "broken, export it again",
                                        i, index, vertices)};
        }
        indices.push_back(index);
    }
    return indices;
}

/// Triangles of strips and fans, with the winding that the specification gives them.
std::vector<uint32_t> unrolled(const std::vector<uint32_t>& indices, uint32_t mode)
{
    std::vector<uint32_t> corners;
    for (size_t i = 0; i + 2 < indices.size(); ++i) {
        if (mode == kTriangleFan) {
            corners.insert(corners.end(), {indices[i + 1], indices[i + 2], indices[0]});
        } else {
            corners.insert(corners.end(),
                           {indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
        }
    }
    return corners;
}

void take_corners(GltfPrimitive& out, std::vector<uint32_t> indices, uint32_t mode)
{
    const size_t count = indices.size();
    switch (mode) {
    case kPoints:
        out.left_out.points += count;
        break;
    case kLines:
        out.left_out.lines += count / 2;
        break;
    case kLineLoop:
        out.left_out.lines += count;
        break;
    case kLineStrip:
        out.left_out.lines += count > 0 ? count - 1 : 0;
        break;
    case kTriangles:
        indices.resize(count / 3 * 3);
        out.corners = std::move(indices);
        break;
    case kTriangleStrip:
    case kTriangleFan:
        out.corners = unrolled(indices, mode);
        break;
    default:
        throw GltfError{fmt::format("a primitive has the mode {}, which glTF does not know; export "
                                    "it again",
                                    mode)};
    }
}

glm::vec3 xyz(const glm::vec4& v)
{
    return {v.x, v.y, v.z};
}

/// The sum of joint matrices for one vertex.
glm::dmat4 skin_matrix(const GltfPrimitive& data, size_t vertex,
                       const std::vector<glm::dmat4>& joints)
{
    glm::dmat4 sum{0.0};
    double total = 0.0;
    for (int set = 0;; ++set) {
        const GltfAttribute* joint = data.find(fmt::format("JOINTS_{}", set));
        const GltfAttribute* weight = data.find(fmt::format("WEIGHTS_{}", set));
        if (joint == nullptr || weight == nullptr) {
            break;
        }
        const glm::vec4 names = joint->at(vertex);
        const glm::vec4 weights = weight->at(vertex);
        for (int i = 0; i < 4; ++i) {
            if (!(weights[i] > 0.0f)) {
                continue;
            }
            const auto name = static_cast<size_t>(std::max(names[i], 0.0f));
            if (name >= joints.size()) {
                throw GltfError{fmt::format("a vertex names joint {} of {}; the file is broken, "
                                            "export it again",
                                            name, joints.size())};
            }
            sum += static_cast<double>(weights[i]) * joints[name];
            total += static_cast<double>(weights[i]);
        }
    }
    if (total > 0.0) {
        return sum * (1.0 / total);
    }
    return joints.empty() ? glm::dmat4{1.0} : joints.front();
}

/// What morph targets with a weight add to an attribute.
class MorphTargets {
public:
    MorphTargets(GltfAccessors& accessors, const json& primitive,
                 const std::vector<double>& weights)
    {
        const auto targets = primitive.find("targets");
        for (size_t i = 0; targets != primitive.end() && i < targets->size(); ++i) {
            const double weight = i < weights.size() ? weights[i] : 0.0;
            if (weight != 0.0 && (*targets)[i].contains("POSITION")) {
                const auto& view = accessors.open(index_of((*targets)[i], "POSITION"), "VEC3");
                moved_.emplace_back(&view, static_cast<float>(weight));
            }
        }
    }
    bool empty() const { return moved_.empty(); }
    glm::vec3 offset(size_t vertex) const
    {
        glm::vec3 sum{0.0f};
        for (const auto& [view, weight] : moved_) {
            sum += vertex < view->count() ? weight * view->vec3(vertex) : glm::vec3{0.0f};
        }
        return sum;
    }

private:
    std::vector<std::pair<const AccessorView*, float>> moved_;
};

} // namespace

glm::vec4 GltfAttribute::at(size_t vertex) const
{
    if (view == nullptr) {
        return decoded[vertex];
    }
    glm::vec4 value{0.0f};
    for (int i = 0; i < std::min(view->components(), 4); ++i) {
        value[i] = view->number(vertex, i);
    }
    return value;
}

const GltfAttribute* GltfPrimitive::find(const std::string& name) const
{
    const auto found = attributes.find(name);
    return found != attributes.end() ? &found->second : nullptr;
}

GltfPrimitive read_primitive(GltfDocument& document, GltfAccessors& accessors,
                             const json& primitive)
{
    GltfPrimitive out;
    const uint32_t mode = index_or(primitive, "mode", kTriangles);
    const json* compressed = extension_of(primitive, "KHR_draco_mesh_compression");
    if (compressed != nullptr) {
        out = read_draco_primitive(document, accessors, *compressed);
    }
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) {
        return {};
    }
    for (const auto& [name, index] : attributes->items()) {
        const bool wanted = name == "POSITION" || name == "NORMAL" || name.starts_with("JOINTS_") ||
                            name.starts_with("WEIGHTS_") || name.starts_with("TEXCOORD_");
        if (wanted && out.attributes.count(name) == 0) {
            out.attributes[name].view = &accessors.open(index_of(*attributes, name.c_str()));
        }
    }
    const GltfAttribute* positions = out.find("POSITION");
    if (positions == nullptr) {
        return {}; // nothing to draw, which glTF allows
    }
    if (positions->view != nullptr && positions->view->components() != 3) {
        throw GltfError{"the positions of a mesh are not of three components; the file is broken, "
                        "export it again"};
    }
    out.vertices = positions->count();
    for (const auto& [name, attribute] : out.attributes) {
        if (attribute.count() < out.vertices) {
            throw GltfError{fmt::format("a mesh has {} positions and only {} of {}; the file is "
                                        "broken, export it again",
                                        out.vertices, attribute.count(), name)};
        }
    }
    if (compressed == nullptr) { // what was compressed is triangles, whatever the mode
        take_corners(out, read_indices(document, accessors, primitive, out.vertices), mode);
    }
    return out;
}

LoadedMesh build_mesh(GltfAccessors& accessors, const json& primitive, const GltfPrimitive& data,
                      const VertexMotion& motion, glm::dvec3& pivot)
{
    constexpr uint32_t kUnused = 0xffffffffu;
    LoadedMesh mesh;
    mesh.left_out = data.left_out;
    std::vector<uint32_t> new_index(data.vertices, kUnused);
    std::vector<uint32_t> used;
    mesh.indices.reserve(data.corners.size());
    for (const uint32_t corner : data.corners) {
        if (new_index[corner] == kUnused) {
            new_index[corner] = static_cast<uint32_t>(used.size());
            used.push_back(corner);
        }
        mesh.indices.push_back(new_index[corner]);
    }
    if (used.empty()) {
        return mesh;
    }
    const GltfAttribute& positions = *data.find("POSITION");
    const MorphTargets morphs(accessors, primitive, motion.morph_weights);
    // Normals of moved vertices are made from the triangles.
    const GltfAttribute* normals =
        motion.joints.empty() && morphs.empty() ? data.find("NORMAL") : nullptr;
    mesh.positions.reserve(used.size());
    for (const uint32_t vertex : used) {
        glm::vec3 position = xyz(positions.at(vertex)) + morphs.offset(vertex);
        if (!motion.joints.empty()) {
            const glm::dvec4 world =
                skin_matrix(data, vertex, motion.joints) * glm::dvec4{position, 1.0};
            if (mesh.positions.empty()) {
                pivot = glm::dvec3{world};
            }
            position = glm::vec3{glm::dvec3{world} - pivot};
        }
        mesh.positions.push_back(position);
        if (normals != nullptr) {
            mesh.normals.push_back(xyz(normals->at(vertex)));
        }
    }
    return mesh;
}

} // namespace occlude::tools
