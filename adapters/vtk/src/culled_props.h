// The prop that stands in a renderer's list for the actors that were taken out of it.
#pragma once

#include "prop_items.h"
#include "prop_view.h"

#include <occlude/vtk/vtk_culling.h>

#include <vtkProp.h>

#include <memory>
#include <vector>

class vtkActor;
class vtkInformation;

namespace occlude {

class CulledProps final : public vtkProp {
public:
    static CulledProps* New();
    vtkTypeMacro(CulledProps, vtkProp);

    /// Before the first frame.
    void set_options(const VtkCullingOptions& options) { options_ = options; }

    /// A new frame, or the other eye of one.
    void begin_frame();
    /// Adds an item that is drawn in this frame, behind those that were added.
    void add(const DrawnItem& item, const Bounds& bounds, double slack, uint32_t triangles);
    /// Makes an item known that this frame does not draw.
    void expect(const vtkProp* prop, const Bounds& bounds, double slack, uint32_t triangles);
    void end_frame();

    bool is_new() const { return items_.tree().size() == 0; }
    VtkCullingStats& stats() { return stats_; }
    const VtkCullingStats& stats() const { return stats_; }

    double* GetBounds() override { return bounds_.data(); }
    vtkTypeBool HasOpaqueGeometry() override { return 1; }
    bool HasKeys(vtkInformation*) override { return true; }
    int RenderOpaqueGeometry(vtkViewport* viewport) override;
    /// Draws the actors that have the keys; without culling, unless all of them have.
    bool RenderFilteredOpaqueGeometry(vtkViewport* viewport, vtkInformation* keys) override;

private:
    CulledProps() = default;
    ~CulledProps() override = default;

    VtkCullingOptions options_;
    PropItems items_;
    std::vector<DrawnItem> drawn_;                 ///< of this frame, in the renderer's order
    std::vector<ItemId> ids_;                      ///< of drawn_
    Bounds bounds_{};                              ///< of all of them
    std::vector<std::unique_ptr<PropView>> views_; ///< by the number of the pass in the frame
    size_t passes_ = 0;                            ///< of this frame
    VtkCullingStats stats_;
};

} // namespace occlude
