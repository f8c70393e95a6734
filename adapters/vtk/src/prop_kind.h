// What a prop is to culling, as of the frame that is drawn.
#pragma once

#include <cstdint>
#include <vector>

class vtkActor;
class vtkMapper;
class vtkPolyData;
class vtkProp;

namespace occlude {

enum class PropKind : uint8_t {
    testable, ///< an actor of opaque surfaces alone: hidden wherever its box is
    kept,     ///< an actor that writes depth like those, but may show outside of its box
    absent,   ///< draws nothing where opaque things are drawn
    ordered,  ///< may blend, or do anything else: nothing is drawn across its place in the order
};

/// Call it when the bounds of the prop are up to date. A fraction of a microsecond.
PropKind kind_of(vtkProp& prop);

/// True if the surfaces of the actor lie within its bounds, and have the depth of their place.
/// Precondition: it is a plain vtkActor with a mapper.
bool stays_in_its_box(vtkActor& actor);

/// What the mapper draws: its surface, or those of a composite data set. Null where a leaf is none.
std::vector<vtkPolyData*> leaves_of(vtkMapper& mapper);

/// Of its polygons and strips; at least 1.
uint32_t triangles_of(vtkPolyData& surface);

} // namespace occlude
