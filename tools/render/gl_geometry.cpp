#include "render/gl_geometry.h"

#include <occlude/core/assert.h>

#include <glm/common.hpp>
#include <glm/gtc/matrix_access.hpp>

#include <cmath>
#include <cstddef>
#include <new>
#include <optional>

namespace occlude::tools {

namespace {

constexpr size_t kFirstCommands = 4096;
constexpr int kMultiDrawVersion = 43;
constexpr GLuint kFirstRowAttribute = 2;
constexpr GLuint kRowAttributes = 5;

struct Vertex {
    glm::vec3 position;
    uint32_t normal; ///< GL_INT_2_10_10_10_REV
};
static_assert(sizeof(Vertex) == 16);

uint32_t packed_normal(const glm::vec3& normal)
{
    const auto bits = [](float value) {
        const float scaled = std::round(glm::clamp(value, -1.0f, 1.0f) * 511.0f);
        return static_cast<uint32_t>(static_cast<int32_t>(scaled)) & 0x3ffu;
    };
    return bits(normal.x) | bits(normal.y) << 10 | bits(normal.z) << 20;
}

std::array<glm::vec4, 3> affine_rows(const glm::mat4& matrix)
{
    return {glm::row(matrix, 0), glm::row(matrix, 1), glm::row(matrix, 2)};
}

const void* at(size_t offset)
{
    return reinterpret_cast<const void*>(offset);
}

} // namespace

size_t write_or_throw(GlStreamBuffer& buffer, std::span<const std::byte> bytes)
{
    const std::optional<size_t> offset = buffer.write(bytes);
    if (!offset) {
        throw std::bad_alloc();
    }
    return *offset;
}

GlGeometry::GlGeometry(const SceneModel& model, std::span<const SceneModel::Item> items,
                       int gl_version)
    : gl_version_(gl_version)
    , vertices_(GlBuffer::make())
    , indices_(GlBuffer::make())
    , indirect_(sizeof(Command), kFirstCommands)
{
    upload_meshes(model);
    update_items(model, items);
    std::vector<Row> rows;
    for (const Instance& instance : model.instances) {
        rows.push_back({affine_rows(instance.world_from_mesh),
                        glm::vec4{instance.color, instance.opacity},
                        static_cast<uint32_t>(rows.size())});
    }
    make_row_buffer(instance_rows_, std::move(rows));
}

void GlGeometry::update_items(const SceneModel& model, std::span<const SceneModel::Item> items)
{
    item_commands_.clear();
    for (const SceneModel::Item& item : items) {
        const uint32_t mesh = model.instances[item.instance].mesh;
        const MeshPart& part = model.meshes[mesh].parts[item.part];
        item_commands_.push_back({part.index_count, 1, mesh_places_[mesh].index + part.first_index,
                                  mesh_places_[mesh].vertex, item.instance});
    }
    item_rows_ = {};
}

void GlGeometry::upload_meshes(const SceneModel& model)
{
    size_t vertex_count = 0;
    size_t index_count = 0;
    for (const Mesh& mesh : model.meshes) {
        mesh_places_.push_back(
            {static_cast<uint32_t>(index_count), static_cast<int32_t>(vertex_count)});
        vertex_count += mesh.positions.size();
        index_count += mesh.indices.size();
    }
    glBindVertexArray(0);
    // Not GL_ELEMENT_ARRAY_BUFFER, which belongs to a vertex array.
    glBindBuffer(GL_COPY_WRITE_BUFFER, indices_.name());
    glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(index_count * sizeof(uint32_t)),
                 nullptr, GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertex_count * sizeof(Vertex)), nullptr,
                 GL_STATIC_DRAW);

    size_t vertex_offset = 0;
    size_t index_offset = 0;
    std::vector<Vertex> vertices;
    for (const Mesh& mesh : model.meshes) {
        vertices.clear();
        for (size_t i = 0; i < mesh.positions.size(); ++i) {
            vertices.push_back({mesh.positions[i], packed_normal(mesh.normals[i])});
        }
        const size_t vertex_bytes = vertices.size() * sizeof(Vertex);
        const size_t index_bytes = mesh.indices.size() * sizeof(uint32_t);
        glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(vertex_offset),
                        static_cast<GLsizeiptr>(vertex_bytes), vertices.data());
        glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(index_offset),
                        static_cast<GLsizeiptr>(index_bytes), mesh.indices.data());
        vertex_offset += vertex_bytes;
        index_offset += index_bytes;
    }
}

void GlGeometry::make_row_buffer(RowBuffer& made, std::vector<Row> rows)
{
    made.rows = std::move(rows);
    made.vertex_array = GlVertexArray::make();
    glBindVertexArray(made.vertex_array.name());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), at(offsetof(Vertex, position)));
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 4, GL_INT_2_10_10_10_REV, GL_TRUE, sizeof(Vertex),
                          at(offsetof(Vertex, normal)));

    made.buffer = GlBuffer::make();
    glBindBuffer(GL_ARRAY_BUFFER, made.buffer.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(made.rows.size() * sizeof(Row)),
                 made.rows.data(), GL_DYNAMIC_DRAW);
    if (gl_version_ >= kMultiDrawVersion) {
        for (GLuint row = 0; row < 3; ++row) {
            glVertexAttribPointer(kFirstRowAttribute + row, 4, GL_FLOAT, GL_FALSE, sizeof(Row),
                                  at(offsetof(Row, world_from_mesh) + row * sizeof(glm::vec4)));
        }
        glVertexAttribPointer(5, 4, GL_FLOAT, GL_FALSE, sizeof(Row), at(offsetof(Row, color)));
        glVertexAttribIPointer(6, 1, GL_UNSIGNED_INT, sizeof(Row), at(offsetof(Row, id)));
        for (GLuint i = 0; i < kRowAttributes; ++i) {
            glEnableVertexAttribArray(kFirstRowAttribute + i);
            glVertexAttribDivisor(kFirstRowAttribute + i, 1);
        }
    }
    glBindVertexArray(0);
}

void GlGeometry::make_item_rows()
{
    std::vector<Row> rows;
    rows.reserve(item_commands_.size());
    for (const Command& command : item_commands_) {
        Row row = instance_rows_.rows[command.row];
        row.id = static_cast<uint32_t>(rows.size());
        if (!item_colors_.empty()) {
            row.color = glm::vec4{glm::vec3{item_colors_[rows.size()]}, row.color.a};
        }
        rows.push_back(row);
    }
    make_row_buffer(item_rows_, std::move(rows));
}

void GlGeometry::update_transforms(std::span<const glm::mat4> world_from_mesh)
{
    OCCLUDE_ASSERT(world_from_mesh.size() == instance_rows_.rows.size(),
                   "update_transforms(): one matrix per instance");
    for (size_t i = 0; i < world_from_mesh.size(); ++i) {
        instance_rows_.rows[i].world_from_mesh = affine_rows(world_from_mesh[i]);
    }
    glBindBuffer(GL_ARRAY_BUFFER, instance_rows_.buffer.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(instance_rows_.rows.size() * sizeof(Row)),
                 instance_rows_.rows.data(), GL_DYNAMIC_DRAW);
    item_rows_ = {};
}

void GlGeometry::set_item_colors(std::span<const glm::vec4> colors)
{
    OCCLUDE_ASSERT(colors.empty() || colors.size() == item_commands_.size(),
                   "set_item_colors(): one colour per item");
    item_colors_.assign(colors.begin(), colors.end());
    item_rows_ = {};
}

void GlGeometry::collect_commands(std::span<const ItemId> items, Rows rows)
{
    commands_.clear();
    for (const ItemId item : items) {
        Command command = item_commands_[item.value];
        if (rows == Rows::item) {
            command.row = item.value;
        } else if (!commands_.empty()) {
            Command& last = commands_.back();
            if (last.row == command.row &&
                last.first_index + last.index_count == command.first_index) {
                last.index_count += command.index_count;
                continue;
            }
        }
        commands_.push_back(command);
    }
}

void GlGeometry::draw(std::span<const ItemId> items, Rows rows)
{
    if (items.empty()) {
        return;
    }
    if (rows == Rows::item && item_rows_.rows.empty()) {
        make_item_rows();
    }
    collect_commands(items, rows);
    const RowBuffer& buffer = rows == Rows::item ? item_rows_ : instance_rows_;
    glBindVertexArray(buffer.vertex_array.name());
    if (gl_version_ < kMultiDrawVersion) {
        draw_one_by_one(buffer);
        return;
    }
    const size_t offset =
        write_or_throw(indirect_, std::as_bytes(std::span<const Command>(commands_)));
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, indirect_.name());
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, at(offset),
                                static_cast<GLsizei>(commands_.size()), 0);
}

// OpenGL 3.3 has no base instance, so the attributes of rows are constants that are set between
// draws.
void GlGeometry::draw_one_by_one(const RowBuffer& rows)
{
    uint32_t current = 0xffffffffu;
    for (const Command& command : commands_) {
        if (command.row != current) {
            current = command.row;
            const Row& row = rows.rows[current];
            for (GLuint i = 0; i < 3; ++i) {
                glVertexAttrib4fv(kFirstRowAttribute + i, &row.world_from_mesh[i].x);
            }
            glVertexAttrib4fv(5, &row.color.x);
            glVertexAttribI1ui(6, row.id);
        }
        glDrawElementsBaseVertex(
            GL_TRIANGLES, static_cast<GLsizei>(command.index_count), GL_UNSIGNED_INT,
            at(static_cast<size_t>(command.first_index) * sizeof(uint32_t)), command.base_vertex);
    }
}

} // namespace occlude::tools
