// Pictures of the decisions of a culler in a frame.
#pragma once

#include "render/palette.h"
#include "session/session.h"

#include <occlude/cull/culler.h>

#include <array>
#include <optional>

namespace occlude::tools {

enum class Show {
    visible, ///< the drawn items, in their own colours
    hidden,  ///< the drawn items, and the hidden ones shining through in the colour of
             ///< Decision::hidden
    boxes,   ///< the drawn items, and the boxes of the nodes with a decision
    states,  ///< every item in the colour of its decision
};

/// The decision about every item, indexed by ItemId. For cullers that decide about items instead of
/// nodes, the items that they drew count as drawn.
std::vector<Decision> item_decisions(const Culler& culler, size_t item_count);

/// A camera high above the scene whose image of `size` pixels shows the whole scene; the view
/// direction of `path_camera` points up in the image.
Camera overview_camera(const SceneModel& model, const Camera& path_camera, glm::ivec2 size);

/// The end points of the 12 edges of a box, in pairs.
std::array<glm::vec3, 24> box_edges(const Aabb& box);

/// The end points of the 12 edges of a view's frustum, cut off `reach` world units from the eye.
std::array<glm::vec3, 24> frustum_edges(const View& view, float reach);

/// How many frames are culled before the first picture, so that temporal state is as in a long
/// walk. No algorithm here remembers more frames.
inline constexpr size_t kLeadInFrames = 30;

/// Culls a frame of a path on the session's renderer; tells `opt` and `ideal` what owns a pixel.
void cull_for_picture(Session& session, Culler& culler, const View& view, size_t frame);

/// The picture of the frame that `culler` has just culled for `camera` on the session's renderer:
/// as that camera sees it, or as an observer does, with the camera's frustum in white lines.
Image draw_picture(Session& session, const Culler& culler, const Camera& camera, Show show,
                   const std::optional<Camera>& observer);

} // namespace occlude::tools
