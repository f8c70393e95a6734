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

/// Units per metre. Objects whose names say that they are doors decide first: they are 2 m high.
/// Then storeys, where at least four level surfaces lie evenly above each other: they are 3 m high;
/// a spacing that a metre allows says nothing. A file that says metres is believed (1) otherwise,
/// unless the scene were longer than 20 km, or nine of ten triangles larger than 20 m; one that
/// says nothing is taken for metres too, unless it is longer than 1 km with triangles of 8 m and
/// more. Then it is the usual unit (metres, feet, Quake's, inches, centimetres, millimetres) that
/// brings the triangles' median edge nearest to 2 m.
UnitGuess guess_unit(const SceneModel& model, UnitSource source);

/// The distance of the large level surfaces of a building from one to the next, in units along
/// model.up; nothing where there are not four of them, evenly spaced.
std::optional<float> storey_height(const SceneModel& model);

/// +y, or +z where the large level surfaces near the bottom of the scene are level in z: ground and
/// floors.
glm::vec3 guess_up(const SceneModel& model);

} // namespace occlude::tools
