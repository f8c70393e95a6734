#include "prop_states.h"

#include <occlude/core/rng.h>

#include <vtkActor.h>
#include <vtkMapper.h>
#include <vtkMath.h>
#include <vtkMatrix4x4.h>
#include <vtkOpenGLActor.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkTexture.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <typeinfo>

namespace occlude {

namespace {

// Positions are multiplied by a matrix in float: each coordinate of the mesh may be off by a few of
// these shares of the largest.
constexpr double kFloatShare = 0x1p-21;

constexpr uint64_t kForgetAfterFrames = 300;

double slack_of(vtkActor& actor)
{
    const double* bounds = actor.GetMapper()->GetBounds();
    double reach = 0.0;
    for (int i = 0; i < 6; ++i) {
        reach = std::max(reach, std::abs(bounds[i]));
    }
    double scale = 0.0;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            scale = std::max(scale, std::abs(actor.GetMatrix()->GetElement(row, column)));
        }
    }
    return kFloatShare * reach * scale;
}

PropState look_at(vtkProp& prop)
{
    PropState state;
    const double* bounds = prop.GetUseBounds() ? prop.GetBounds() : nullptr;
    state.kind = kind_of(prop);
    if (state.kind != PropKind::testable) {
        return state;
    }
    if (bounds == nullptr || vtkMath::AreBoundsInitialized(bounds) == 0) {
        state.kind = PropKind::kept;
        return state;
    }
    auto& actor = static_cast<vtkActor&>(prop);
    std::copy_n(bounds, state.bounds.size(), state.bounds.begin());
    state.slack = slack_of(actor);
    for (vtkPolyData* leaf : leaves_of(*actor.GetMapper())) {
        state.triangles += triangles_of(*leaf);
    }
    return state;
}

// A texture tells of its own changes, and not of those of its image.
uint64_t version_of(vtkTexture* texture)
{
    vtkDataObject* image = texture != nullptr ? texture->GetInputDataObject(0, 0) : nullptr;
    return image != nullptr ? hash64(texture->GetMTime(), image->GetMTime()) : 0;
}

uint64_t version_of_textures(vtkActor& actor)
{
    uint64_t version = version_of(actor.GetTexture());
    for (const auto& [name, texture] : actor.GetProperty()->GetAllTextures()) {
        version = hash64(version, version_of(texture));
    }
    return version;
}

// What has several surfaces depends on more than is worth following.
bool is_simple(vtkProp& prop)
{
    if (typeid(prop) != typeid(vtkOpenGLActor)) {
        return false;
    }
    auto& actor = static_cast<vtkActor&>(prop);
    vtkMapper* mapper = actor.GetMapper();
    return mapper != nullptr && typeid(*mapper) == typeid(vtkOpenGLPolyDataMapper);
}

} // namespace

void PropStates::begin_frame()
{
    ++frame_;
    if (frame_ % kForgetAfterFrames == 0) {
        std::erase_if(entries_, [this](const auto& entry) {
            return entry.second.last_seen + kForgetAfterFrames < frame_;
        });
    }
}

const PropState& PropStates::of(vtkProp& prop, bool up_to_date)
{
    Entry& entry = entries_[&prop];
    entry.last_seen = frame_;
    if (!is_simple(prop)) {
        entry.version = {};
        entry.state = look_at(prop);
        return entry.state;
    }
    auto& actor = static_cast<vtkActor&>(prop);
    if (!up_to_date) {
        actor.GetBounds();
    }
    vtkDataObject* surface = actor.GetMapper()->GetInputDataObject(0, 0);
    const Version version{actor.GetMTime(),
                          actor.GetMapper()->GetMTime(),
                          surface != nullptr ? surface->GetMTime() : 0,
                          actor.GetShaderProperty()->GetMTime(),
                          static_cast<uint64_t>(vtkMapper::GetResolveCoincidentTopology()),
                          version_of_textures(actor)};
    if (entry.version != version) {
        entry.version = version;
        entry.state = look_at(prop);
    }
    return entry.state;
}

} // namespace occlude
