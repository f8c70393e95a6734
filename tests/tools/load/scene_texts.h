// Small scene files as text, complete and damaged, and checks of the scenes made of them.
#pragma once

#include "generate/scene_source.h"
#include "support/source_dir.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

namespace occlude::tools {

inline const std::string kCastle = source_dir() + "/assets/castle/castle.glb";

inline const std::string kQuadObj = "mtllib none.mtl\n"
                                    "o quad\n"
                                    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                    "f 1 2 3 4\n";

/// Two nodes, one of them turned and moved, that share a mesh of one triangle.
inline std::string two_instances_gltf(const std::string& buffer_uri)
{
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"name":"a","mesh":0},{"name":"b","mesh":0,"translation":[10,0,0],"scale":[2,2,2]}],
"meshes":[{"name":"tri","primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1]}}],
"buffers":[{"byteLength":42)" +
           buffer_uri + R"(}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})";
}

inline std::string triangle_buffer()
{
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint16_t indices[3] = {0, 1, 2};
    std::string bytes(42, '\0');
    std::memcpy(bytes.data(), positions, 36);
    std::memcpy(bytes.data() + 36, indices, 6);
    return bytes;
}

inline std::string little_endian(size_t value)
{
    std::string bytes;
    for (int i = 0; i < 4; ++i) {
        bytes.push_back(static_cast<char>((value >> (8 * i)) & 0xff));
    }
    return bytes;
}

inline std::string glb_of(std::string json, std::string binary)
{
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    return "glTF" + little_endian(2) + little_endian(28 + json.size() + binary.size()) +
           little_endian(json.size()) + "JSON" + json + little_endian(binary.size()) +
           std::string("BIN\0", 4) + binary;
}

inline std::string two_instances_glb()
{
    return glb_of(two_instances_gltf(""), triangle_buffer());
}

inline std::string repeated(const std::string& text, size_t times)
{
    std::string all;
    for (size_t i = 0; i < times; ++i) {
        all += text;
    }
    return all;
}

/// The scene of two_instances_gltf(), with other nodes. The first of them is its root.
inline std::string gltf_with_nodes(const std::string& nodes, const std::string& buffer_uri)
{
    std::string gltf = two_instances_gltf(buffer_uri);
    const size_t begin = gltf.find("\"nodes\":[{");
    gltf.replace(begin, gltf.find("\"meshes\"") - begin, "\"nodes\":" + nodes + ",\n");
    return gltf.replace(gltf.find("[0,1]"), 5, "[0]");
}

/// `times` nodes, each but the last with the next as its child.
inline std::string chain_of_nodes(size_t count, size_t times = 1)
{
    std::string nodes = "[";
    for (size_t next = 1; next < count; ++next) {
        const std::string child = std::to_string(next);
        nodes += "{\"children\":[" + child + repeated("," + child, times - 1) + "]},";
    }
    return nodes + "{\"mesh\":0}]";
}

inline std::string contents(const std::string& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline void expect_two_instances(const Result<SceneModel>& model)
{
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_EQ(model->meshes.size(), 1u);
    ASSERT_EQ(model->instances.size(), 2u);
    EXPECT_EQ(model->instances[0].mesh, model->instances[1].mesh);
    EXPECT_EQ(model->instances[0].name, "a");
    EXPECT_EQ(drawn_triangles(*model), 2u);
    const Aabb bounds = world_bounds(*model);
    EXPECT_NEAR(bounds.min.x, 0.0f, 1e-4f);
    EXPECT_NEAR(bounds.max.x, 12.0f, 1e-4f);
    EXPECT_NEAR(bounds.max.y, 2.0f, 1e-4f);
    EXPECT_NEAR(model->instances[0].color.g, 0.25f, 1e-3f);
    EXPECT_EQ(model->unit, 1.0f);
}

/// Expects everything that renderers rely on.
inline void expect_sound(const SceneModel& model)
{
    ASSERT_FALSE(model.instances.empty());
    for (const Instance& instance : model.instances) {
        ASSERT_LT(instance.mesh, model.meshes.size());
    }
    for (const Mesh& mesh : model.meshes) {
        ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
        ASSERT_FALSE(mesh.parts.empty());
        uint32_t next = 0;
        for (const MeshPart& part : mesh.parts) {
            ASSERT_EQ(part.first_index, next);
            next += part.index_count;
            ASSERT_TRUE(part.box.is_bounded());
        }
        ASSERT_EQ(next, mesh.indices.size());
        for (uint32_t index : mesh.indices) {
            ASSERT_LT(index, mesh.positions.size());
            ASSERT_NEAR(glm::length(mesh.normals[index]), 1.0f, 1e-3f);
        }
    }
}

inline void expect_error(const std::string& file, ErrorCode code, const std::string& part)
{
    const auto model = load_scene(file);
    ASSERT_FALSE(model) << file;
    EXPECT_EQ(model.error().code, code) << model.error().message;
    EXPECT_NE(model.error().message.find(file), std::string::npos) << model.error().message;
    EXPECT_NE(model.error().message.find(part), std::string::npos) << model.error().message;
}

} // namespace occlude::tools
