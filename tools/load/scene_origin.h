// Where the zero of a scene is put, so that single precision is fine where its objects are.
#pragma once

#include "model/scene_model.h"

#include <glm/vec3.hpp>

namespace occlude::tools {

/// What to subtract from a scene that lies more than 16 times its size from zero: the middle of its
/// bulk, rounded to its size. Zero for other scenes.
glm::dvec3 way_to_bulk(const SceneModel& model);

/// Whether single precision tells the corners of the scene's bulk apart where it lies.
bool has_shape(const SceneModel& model);

} // namespace occlude::tools
