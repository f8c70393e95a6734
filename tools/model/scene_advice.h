// Finds the properties of a scene that keep culling from paying, and says what to change.
#pragma once

#include "model/scene_model.h"

#include <cstdint>
#include <string>
#include <vector>

namespace occlude::tools {

/// One thing to change.
struct Advice {
    std::string kind;                      ///< one of the names below, for scripts
    std::string sentence;                  ///< the problem, with names, and what to do
    uint64_t count = 0;                    ///< number of objects concerned
    std::vector<std::string> objects = {}; ///< their names, the worst first; at most ten
};

/// Changes that would help culling, the most important first; empty if there are none:
///
/// - "one_mesh": one object holds most of the triangles and reaches through most of the scene;
/// - "large_objects": heavy objects that are longer than a quarter of the scene;
/// - "few_objects": so few objects that there is little to leave out;
/// - "small_objects": most objects have so few triangles that a draw or a test costs more;
/// - "empty_boxes": large objects that fill little of their boxes, which show where they do not;
/// - "see_through": much of the scene has a material that lets light through, so it hides nothing.
///
/// `item_triangles` is the size of the pieces into which this program cuts meshes. O(objects +
/// triangles of all meshes).
std::vector<Advice> advise(const SceneModel& model, uint32_t item_triangles);

/// The share of a mesh's box that its triangles fill, seen along the axis along which they fill
/// most: 1 for a box, one half for a sheet across it, near 0 for a pole along its diagonal.
float box_fill(const Mesh& mesh);

} // namespace occlude::tools
