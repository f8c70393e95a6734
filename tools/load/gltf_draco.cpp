#include "load/gltf_draco.h"

#include <fmt/format.h>

#include <draco/compression/decode.h>

namespace occlude::tools {
namespace {

GltfAttribute decode_attribute(const draco::Mesh& mesh, const std::string& name, uint32_t id)
{
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id);
    if (attribute == nullptr) {
        throw GltfError{fmt::format("the compressed attribute {} is missing; the file is broken, "
                                    "export it again",
                                    name)};
    }
    GltfAttribute out;
    out.decoded.resize(mesh.num_points(), glm::vec4{0.0f});
    for (uint32_t point = 0; point < mesh.num_points(); ++point) {
        const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(point));
        if (!attribute->ConvertValue<float, 4>(value, &out.decoded[point].x)) {
            throw GltfError{fmt::format("the compressed attribute {} cannot be read; the file is "
                                        "broken, export it again",
                                        name)};
        }
    }
    return out;
}

} // namespace

GltfPrimitive read_draco_primitive(GltfDocument& document, GltfAccessors& accessors,
                                   const nlohmann::json& extension)
{
    const Bytes bytes = accessors.buffer_view(index_of(extension, "bufferView"));
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) {
        throw GltfError{fmt::format("a mesh cannot be decompressed (KHR_draco_mesh_compression: "
                                    "{}); the file is broken, export it again",
                                    decoded.status().error_msg_string())};
    }
    const draco::Mesh& mesh = *decoded.value();
    GltfPrimitive primitive;
    primitive.vertices = mesh.num_points();
    document.charge((primitive.vertices * 4 + mesh.num_faces() * 3) * sizeof(float));
    for (const auto& [name, id] : extension.at("attributes").items()) {
        primitive.attributes[name] = decode_attribute(mesh, name, id.get<uint32_t>());
    }
    primitive.corners.reserve(size_t{mesh.num_faces()} * 3);
    for (uint32_t face = 0; face < mesh.num_faces(); ++face) {
        for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(face))) {
            primitive.corners.push_back(corner.value());
        }
    }
    return primitive;
}

} // namespace occlude::tools
