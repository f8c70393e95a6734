// Pictures of what a culler decided in a frame.
#pragma once

#include "render/palette.h"
#include "session/session.h"

#include <occlude/cull/culler.h>

#include <array>
#include <optional>

namespace occlude::tools {

enum class Show {
    visible, ///< the items drawn, in their own colours
    hidden,  ///< ... with the hidden items shining through in the colour of Decision::hidden
    boxes,   ///< ... with the boxes of the nodes that were decided
    states,  ///< every item in the colour of its decision
};

/// The decision of every item, indexed by ItemId, also for cullers that decide for items rather
/// than nodes: what they drew counts as drawn.
std::vector<Decision> item_decisions(const Culler& culler, size_t item_count);

/// A camera from high above whose image of `size` pixels shows the whole scene, with the way that
/// `path_camera` looks going up.
Camera overview_camera(const SceneModel& model, const Camera& path_camera, glm::ivec2 size);

/// The end points of the 12 edges of a box, in pairs.
std::array<glm::vec3, 24> box_edges(const Aabb& box);

/// The end points of the 12 edges of a view's frustum, cut off `reach` world units from the eye.
std::array<glm::vec3, 24> frustum_edges(const View& view, float reach);

/// Frames to cull before the first picture, so that temporal state is what it would be there. Every
/// algorithm here has forgotten what happened longer ago.
inline constexpr size_t kLeadInFrames = 30;

/// Culls a frame of a path on the session's renderer, telling yardsticks what owns a pixel.
void cull_for_picture(Session& session, Culler& culler, const View& view, size_t frame);

/// The picture of the frame that `culler` has just culled for `camera` on the session's renderer:
/// as that camera sees it, or as an observer does, with the camera's frustum in white lines.
Image draw_picture(Session& session, const Culler& culler, const Camera& camera, Show show,
                   const std::optional<Camera>& observer);

} // namespace occlude::tools
