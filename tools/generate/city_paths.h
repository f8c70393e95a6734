// Where the streets of the generated city run, and camera paths along them.
#pragma once

#include "model/scene_model.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace occlude::tools {

/// The street plan: rows of blocks along x, each row shifted against its neighbours. Metres.
class CityStreets {
public:
    static constexpr float kPitch = 76.0f; ///< from the middle of a block to that of the next

    CityStreets(uint32_t blocks, uint64_t seed);

    uint32_t blocks() const { return blocks_; }
    float half_size() const { return 0.5f * kPitch * static_cast<float>(blocks_); }
    glm::vec3 block_center(uint32_t row, uint32_t column) const;
    /// z of the street before row `row`; rows() gives the one after the last.
    float avenue_z(uint32_t row) const;
    /// x of the lane before column `column` in row `row`.
    float lane_x(uint32_t row, uint32_t column) const;

private:
    uint32_t blocks_;
    std::vector<float> shifts_; ///< of each row along x
};

/// "street": a walk of some 170 m at 1.7 m height around corners; "rise": a walk that climbs above
/// the roofs; "roofs": a flight high above with the whole city in view; "teleport": the walk with
/// cuts to other streets and turns by 90 degrees.
std::vector<SceneModel::NamedPath> city_paths(const CityStreets& streets);

/// From a camera in a street straight up by `height` metres, over 48 seconds, while its view
/// reaches 1 + `reach` times as far ahead, always at what stands at the height of the eyes.
std::vector<Keyframe> rise_from(const Camera& street, float height, float reach);

} // namespace occlude::tools
