// All triangles of a SceneModel in one vertex and one index buffer; draws runs of its items.
#pragma once

#include "model/scene_model.h"

#include <occlude/backends/gl/detail/gl_object.h>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace occlude::tools {

/// The result of GlStreamBuffer::write(); throws std::bad_alloc if the driver has no memory.
size_t write_or_throw(GlStreamBuffer& buffer, std::span<const std::byte> bytes);

/// Vertex attributes: 0 position, 1 normal, both in the space of the mesh; per drawn instance 2 to
/// 4 the rows of world_from_mesh, 5 colour and opacity, 6 id.
class GlGeometry {
public:
    /// Uploads everything. `gl_version` (10 * major + minor) decides how items are drawn: by one
    /// multi-draw from 4.3 on, by one draw per run of items otherwise.
    GlGeometry(const SceneModel& model, std::span<const SceneModel::Item> items, int gl_version);

    /// The source of attributes 2 to 6. `item` gives each item its own colour, and its own index as
    /// id, but cannot merge draws.
    enum class Rows : uint8_t { instance, item };

    /// Draws `items` in this order with the current program: one command for each run of items of
    /// one instance whose triangles follow one another. Allocates nothing once buffers have grown.
    void draw(std::span<const ItemId> items, Rows rows);

    void update_transforms(std::span<const glm::mat4> world_from_mesh);

    /// What each item draws, by ItemId. Precondition: `model` is the one that was uploaded.
    void update_items(const SceneModel& model, std::span<const SceneModel::Item> items);

    /// Sets one colour per item for draws with Rows::item; empty gives items the colour of their
    /// instance.
    void set_item_colors(std::span<const glm::vec4> colors);

private:
    // The data of an instance or an item that the vertex shader reads.
    struct Row {
        std::array<glm::vec4, 3> world_from_mesh; ///< affine, row by row
        glm::vec4 color{0.0f};                    ///< and opacity
        uint32_t id = 0;
    };
    static_assert(sizeof(Row) == 68);

    // Laid out as OpenGL reads it (DrawElementsIndirectCommand).
    struct Command {
        uint32_t index_count = 0;
        uint32_t instance_count = 1;
        uint32_t first_index = 0;
        int32_t base_vertex = 0;
        uint32_t row = 0;
    };
    static_assert(sizeof(Command) == 20);

    // A buffer of rows and the vertex array that reads it.
    struct RowBuffer {
        GlVertexArray vertex_array;
        GlBuffer buffer;
        std::vector<Row> rows;
    };

    // The first vertex and index of a mesh in the buffers.
    struct MeshPlace {
        uint32_t index = 0;
        int32_t vertex = 0;
    };

    void upload_meshes(const SceneModel& model);
    void make_row_buffer(RowBuffer& made, std::vector<Row> rows);
    void make_item_rows();
    void collect_commands(std::span<const ItemId> items, Rows rows);
    void draw_one_by_one(const RowBuffer& rows);

    int gl_version_ = 0;
    GlBuffer vertices_;
    GlBuffer indices_;
    GlStreamBuffer indirect_;
    std::vector<MeshPlace> mesh_places_; ///< by mesh
    RowBuffer instance_rows_;
    RowBuffer item_rows_;                ///< made when needed
    std::vector<Command> item_commands_; ///< by ItemId, with the row of the item's instance
    std::vector<Command> commands_;      ///< of the current draw
    std::vector<glm::vec4> item_colors_;
};

} // namespace occlude::tools
