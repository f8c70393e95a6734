// Estimates whether culling pays on a scene before it is integrated, by what moving cameras would
// see.
#pragma once

#include "session/session.h"

#include <cstdint>
#include <string>
#include <vector>

namespace occlude::tools {

/// What the frames of a path show, summed over the frames.
struct Occlusion {
    size_t frames = 0;
    uint64_t items = 0; ///< in the frustum
    uint64_t owners = 0;
    uint64_t triangles = 0;
    uint64_t owner_triangles = 0;

    /// How many times fewer triangles a perfect culler draws than frustum culling; 1 if nothing is
    /// in view.
    double limit() const;
    double triangles_per_frame() const;
    double items_per_frame() const;
};

/// Draws every view with everything in its frustum and counts which items own a pixel.
/// Precondition: the session is started.
Occlusion sample_occlusion(Session& session, std::span<const View> views,
                           const ProgressCallback& progress);

enum class Pays {
    yes,
    perhaps,
    no,          ///< nearly everything in the frustum is seen
    small,       ///< frames are so small that tests cost as much as drawing
    nothing,     ///< nothing is in view
    no_such_path ///< the scene has nowhere for such a camera
};
const char* to_string(Pays pays);

/// The estimate from the share that can be saved and the size of frames.
Pays judge(const Occlusion& occlusion);

/// A kind of moving camera.
struct Prospect {
    std::string kind; ///< "inside", "street" or "outside"
    std::string what; ///< what the camera does, in words
    Pays pays = Pays::no_such_path;
    Occlusion seen = {};

    /// One sentence: how much is in the frustum, how much of it is visible, and the conclusion.
    std::string sentence() const;
};

/// Prospects for cameras that fly straight through the middle of the scene ("inside"), walk at eye
/// height if there are floors ("street"), and circle the whole scene ("outside"), `frames` views
/// each. Draws that many frames, and eight more.
std::vector<Prospect> prospects(Session& session, size_t frames, const ProgressCallback& progress);

/// The conclusion for all kinds of cameras together. It does not hold for other cameras.
std::string conclusion(std::span<const Prospect> prospects);

} // namespace occlude::tools
