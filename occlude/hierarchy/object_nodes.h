// What a builder that knows objects adds to its nodes: the object that a node belongs to, a tighter
// box to test it by, and a key that survives a new layout.
#pragma once

#include <occlude/core/aabb.h>

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <vector>

namespace occlude {

/// All vectors are empty for a tree whose builder knows no objects.
struct ObjectNodes {
    static constexpr uint32_t kScene = 0xffffffffu; ///< the node belongs to no single object

    /// The transform of an object.
    struct ObjectFrame {
        glm::mat4 world_from_object{1.0f};
        bool oriented = false; ///< rotated or sheared: its boxes are kept in its own space
    };

    std::vector<uint32_t> object; ///< per node: an index into `frames`, or kScene
    std::vector<Aabb> box;        ///< per node: the box to test, in the object's own space if that
                                  ///< is oriented, else in the world; bounds the whole subtree
    std::vector<uint32_t> key;    ///< per node: its place in what algorithms remember. A node keeps
                                  ///< its key while others come and go; a free key is used again.
    std::vector<ObjectFrame> frames;
    uint32_t key_count = 0; ///< every key is smaller
    uint64_t lineage = 0;   ///< constant while keys keep their meaning; 0: there are no keys

    bool empty() const { return lineage == 0; }
};

} // namespace occlude
