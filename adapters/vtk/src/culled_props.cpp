#include "culled_props.h"

#include <vtkActor.h>
#include <vtkInformation.h>
#include <vtkObjectFactory.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <limits>

namespace occlude {

vtkStandardNewMacro(CulledProps);

void CulledProps::begin_frame()
{
    items_.begin_frame();
    drawn_.clear();
    ids_.clear();
    passes_ = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
        bounds_[2 * axis] = std::numeric_limits<double>::max();
        bounds_[2 * axis + 1] = std::numeric_limits<double>::lowest();
    }
}

void CulledProps::add(const DrawnItem& item, const Bounds& bounds, double slack, uint32_t triangles)
{
    drawn_.push_back(item);
    ids_.push_back(items_.find(item.actor, item.block_number, bounds, slack, triangles));
    for (size_t axis = 0; axis < 3; ++axis) {
        bounds_[2 * axis] = std::min(bounds_[2 * axis], bounds[2 * axis]);
        bounds_[2 * axis + 1] = std::max(bounds_[2 * axis + 1], bounds[2 * axis + 1]);
    }
}

void CulledProps::expect(const vtkProp* prop, const Bounds& bounds, double slack,
                         uint32_t triangles)
{
    items_.find(prop, 0, bounds, slack, triangles);
}

void CulledProps::end_frame()
{
    items_.end_frame();
    stats_.items = drawn_.size();
    stats_.moved_items = items_.tree().moved();
    stats_.rebuilds = items_.tree().rebuilds();
}

int CulledProps::RenderOpaqueGeometry(vtkViewport* viewport)
{
    vtkRenderer* renderer = vtkRenderer::SafeDownCast(viewport);
    if (renderer == nullptr || drawn_.empty()) {
        return 0;
    }
    if (passes_ == views_.size()) {
        views_.push_back(std::make_unique<PropView>(options_, items_.tree()));
    }
    PropView& view = *views_[passes_++];
    if (drawn_.size() < options_.min_items ||
        !view.draw(*renderer, GetPropertyKeys(), drawn_, ids_, stats_)) {
        stats_.hidden_items = 0;
        ItemPainter painter;
        painter.start(*renderer, GetPropertyKeys());
        for (const DrawnItem& item : drawn_) {
            painter.draw(item);
        }
        painter.finish();
    }
    return static_cast<int>(drawn_.size() - stats_.hidden_items);
}

bool CulledProps::RenderFilteredOpaqueGeometry(vtkViewport* viewport, vtkInformation* keys)
{
    const auto has_keys = [keys](const DrawnItem& item) { return item.actor->HasKeys(keys); };
    if (std::ranges::all_of(drawn_, has_keys)) {
        return RenderOpaqueGeometry(viewport) > 0;
    }
    bool drew = false;
    ItemPainter painter;
    painter.start(static_cast<vtkRenderer&>(*viewport), GetPropertyKeys());
    for (const DrawnItem& item : drawn_) {
        if (has_keys(item)) {
            painter.draw(item);
            drew = true;
        }
    }
    painter.finish();
    return drew;
}

} // namespace occlude
