#include "prop_kind.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCompositeDataDisplayAttributes.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkCompositePolyDataMapper2.h>
#include <vtkImageData.h>
#include <vtkOpenGLActor.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkSmartPointer.h>
#include <vtkTexture.h>
#include <vtkVolume.h>

#include <algorithm>
#include <typeinfo>

namespace occlude {

namespace {

// In the smaller images of such a texture, opaque and transparent texels become one that blends.
// (An interpolated one is not opaque to VTK.)
bool may_blend(vtkTexture* texture)
{
    if (texture == nullptr || !texture->GetMipmap()) {
        return false;
    }
    const vtkImageData* image = texture->GetInput();
    const int components =
        image != nullptr ? const_cast<vtkImageData*>(image)->GetNumberOfScalarComponents() : 4;
    return components == 2 || components == 4;
}

bool may_blend(vtkActor& actor)
{
    vtkProperty& property = *actor.GetProperty();
    if (actor.GetForceOpaque() || may_blend(actor.GetTexture())) {
        return true;
    }
    if (vtkProperty* back = actor.GetBackfaceProperty();
        back != nullptr && back->GetOpacity() < 1.0) {
        return true;
    }
    for (const auto& [name, texture] : property.GetAllTextures()) {
        if (may_blend(texture)) {
            return true;
        }
    }
    return false;
}

// Shaders of the program's own may put vertices anywhere, and write any depth.
bool has_own_shaders(vtkActor& actor)
{
    vtkShaderProperty& shaders = *actor.GetShaderProperty();
    return shaders.HasVertexShaderCode() || shaders.HasGeometryShaderCode() ||
           shaders.HasFragmentShaderCode() || shaders.GetNumberOfShaderReplacements() > 0;
}

// Offsets that move surfaces toward the viewer.
bool is_moved_forward(vtkMapper& mapper)
{
    if (vtkMapper::GetResolveCoincidentTopology() == VTK_RESOLVE_OFF) {
        return false;
    }
    double factor = 0.0;
    double units = 0.0;
    mapper.GetCoincidentTopologyPolygonOffsetParameters(factor, units);
    return factor < 0.0 || units < 0.0 ||
           vtkMapper::GetResolveCoincidentTopology() != VTK_RESOLVE_POLYGON_OFFSET;
}

bool has_polygons_alone(vtkPolyData* surface)
{
    return surface != nullptr && surface->GetNumberOfVerts() == 0 &&
           surface->GetNumberOfLines() == 0;
}

// No block has a colour, an opacity or a visibility of its own.
bool draws_blocks_alike(vtkCompositePolyDataMapper2& mapper)
{
    const vtkCompositeDataDisplayAttributes* blocks = mapper.GetCompositeDataDisplayAttributes();
    return blocks == nullptr || (!blocks->HasBlockVisibilities() && !blocks->HasBlockColors() &&
                                 !blocks->HasBlockOpacities() && !blocks->HasBlockMaterials());
}

PropKind kind_of_other(vtkProp& prop)
{
    if (prop.IsA("vtkVolume") != 0 || prop.HasOpaqueGeometry() == 0) {
        return PropKind::absent;
    }
    vtkActor* actor = vtkActor::SafeDownCast(&prop);
    return actor != nullptr && !may_blend(*actor) ? PropKind::kept : PropKind::ordered;
}

} // namespace

PropKind kind_of(vtkProp& prop)
{
    if (typeid(prop) != typeid(vtkOpenGLActor)) {
        return kind_of_other(prop);
    }
    auto& actor = static_cast<vtkActor&>(prop);
    if (actor.GetMapper() == nullptr || actor.HasOpaqueGeometry() == 0) {
        return PropKind::absent;
    }
    if (may_blend(actor)) {
        return PropKind::ordered;
    }
    return stays_in_its_box(actor) && actor.HasTranslucentPolygonalGeometry() == 0
               ? PropKind::testable
               : PropKind::kept;
}

bool stays_in_its_box(vtkActor& actor)
{
    vtkMapper& mapper = *actor.GetMapper();
    bool polygons = false;
    if (typeid(mapper) == typeid(vtkOpenGLPolyDataMapper)) {
        polygons = has_polygons_alone(static_cast<vtkPolyDataMapper&>(mapper).GetInput());
    } else if (typeid(mapper) == typeid(vtkCompositePolyDataMapper2)) {
        polygons = draws_blocks_alike(static_cast<vtkCompositePolyDataMapper2&>(mapper)) &&
                   std::ranges::all_of(leaves_of(mapper), has_polygons_alone);
    }
    vtkProperty& looks = *actor.GetProperty();
    return polygons && looks.GetRepresentation() == VTK_SURFACE && looks.GetEdgeVisibility() == 0 &&
           looks.GetVertexVisibility() == 0 && !is_moved_forward(mapper) && !has_own_shaders(actor);
}

std::vector<vtkPolyData*> leaves_of(vtkMapper& mapper)
{
    vtkDataObject* data = mapper.GetInputDataObject(0, 0);
    auto* composite = vtkCompositeDataSet::SafeDownCast(data);
    if (composite == nullptr) {
        return {vtkPolyData::SafeDownCast(data)};
    }
    std::vector<vtkPolyData*> leaves;
    const auto at = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
    for (at->InitTraversal(); at->IsDoneWithTraversal() == 0; at->GoToNextItem()) {
        leaves.push_back(vtkPolyData::SafeDownCast(at->GetCurrentDataObject()));
    }
    return leaves;
}

uint32_t triangles_of(vtkPolyData& surface)
{
    const vtkIdType corners = surface.GetPolys()->GetNumberOfConnectivityIds() +
                              surface.GetStrips()->GetNumberOfConnectivityIds();
    const vtkIdType cells = surface.GetNumberOfPolys() + surface.GetNumberOfStrips();
    return static_cast<uint32_t>(std::clamp<vtkIdType>(corners - 2 * cells, 1, 1 << 30));
}

} // namespace occlude
