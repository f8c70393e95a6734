// Which actor, or block of one, is which item from frame to frame, and the hierarchy over them.
//
// An item is known by the addresses of its actor and by the number of its block. Actors are looked
// up first in the order in which they came in the last frame, then in a table. Nothing but speed
// depends on an address that another actor has got: each item's box is that of the present frame.
#pragma once

#include "item_tree.h"

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

class vtkProp;

namespace occlude {

/// Bounds of VTK: least and greatest x, y, z. In double.
using Bounds = std::array<double, 6>;

/// The bounds in float, never smaller, and grown by `slack`. Unknown bounds are everything.
Aabb box_of(const Bounds& bounds, double slack);

class PropItems {
public:
    void begin_frame();

    /// The item of a block of `prop`, with that box in this frame. `slack`: by how much positions
    /// may be off because they are transformed in float.
    ItemId find(const vtkProp* prop, uint32_t block, const Bounds& bounds, double slack,
                uint32_t triangles);

    /// Once per frame, when all items were found.
    void end_frame();

    const ItemTree& tree() const { return tree_; }

private:
    struct Key {
        const vtkProp* prop = nullptr;
        uint32_t block = 0;

        bool operator==(const Key&) const = default;
    };
    struct Hash {
        size_t operator()(const Key& key) const;
    };
    struct Item {
        Key key;
        Bounds bounds{};
        uint64_t last_seen = 0;
    };

    uint32_t look_up(const Key& key);
    void forget_missing();

    ItemTree tree_;
    std::vector<Item> items_; ///< by ItemId
    std::unordered_map<Key, uint32_t, Hash> ids_;
    std::vector<uint32_t> sequence_; ///< the ids of the last frame, in order
    std::vector<uint32_t> present_;  ///< ... and of this one
    size_t next_ = 0;                ///< in sequence_
    uint64_t frame_ = 0;
};

} // namespace occlude
