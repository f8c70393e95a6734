// What a scene says about itself by its shape: where its bulk is, its unit, which way is up.
#pragma once

#include "model/scene_model.h"

#include <occlude/core/aabb.h>

#include <glm/mat4x4.hpp>

#include <optional>
#include <string>

namespace occlude::tools {

/// What is known of a file's unit of length.
enum class UnitSource { metres, unknown };

/// A unit and the reason for it, in words.
struct UnitGuess {
    float units_per_metre = 1.0f;
    std::string reason;
};

/// Units per metre. Objects whose names say that they are doors decide first: they are 2 m high. A
/// file that says metres is believed (1) otherwise, unless the scene were longer than 20 km, or
/// nine of ten triangles larger than 20 m; one that says nothing is taken for metres too, unless it
/// is longer than 1 km with triangles of 8 m and more. Then it is the usual unit (metres, feet,
/// Quake's, inches, centimetres, millimetres) that brings the triangles' median edge nearest to
/// 4 m.
UnitGuess guess_unit(const SceneModel& model, UnitSource source);

/// +y, or +z where the large level surfaces near the bottom of the scene are level in z: ground and
/// floors.
glm::vec3 guess_up(const SceneModel& model);

} // namespace occlude::tools
