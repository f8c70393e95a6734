// What culling must know of each prop, remembered while nothing of it has changed: VTK answers such
// questions slowly.
#pragma once

#include "prop_items.h"
#include "prop_kind.h"

#include <array>
#include <cstdint>
#include <unordered_map>

class vtkProp;

namespace occlude {

struct PropState {
    PropKind kind = PropKind::ordered;
    // Of testable props:
    Bounds bounds{};
    double slack = 0.0;     ///< by how much positions may be off because of float
    uint32_t triangles = 0; ///< all in all
};

class PropStates {
public:
    void begin_frame();

    /// The state of a prop in this frame. `up_to_date`: somebody has asked for its bounds since the
    /// scene changed, as VTK's frustum culling does. The answer stays where it is until the next
    /// frame.
    const PropState& of(vtkProp& prop, bool up_to_date);

private:
    /// When what the state depends on was changed last. Later objects have later times, also at
    /// the same address.
    using Version = std::array<uint64_t, 6>;
    struct Entry {
        Version version{};
        uint64_t last_seen = 0;
        PropState state;
    };

    uint64_t frame_ = 0;
    std::unordered_map<const vtkProp*, Entry> entries_;
};

} // namespace occlude
