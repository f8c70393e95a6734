// Everything that algorithms run on: a tree, the boxes of its items and a renderer; and the two
// sets of items that all results are compared with.
#pragma once

#include "render/scene_renderer.h"

#include <occlude/core/result.h>
#include <occlude/core/view.h>
#include <occlude/cull/culler.h>
#include <occlude/hierarchy/hierarchy.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace occlude::tools {

struct Stage {
    const Hierarchy& hierarchy;              ///< the tree of contenders that name no other
    std::span<const ItemBounds> item_bounds; ///< indexed by ItemId
    SceneRenderer& renderer;
    /// Brings all of these to a frame of the scene's motion (MotionPlayer::go_to); empty if nothing
    /// moves.
    std::function<void(size_t frame)> go_to = {};
};

/// Brings a stage to a frame of its motion, for all algorithms at once, outside timed sections.
inline void set_frame(const Stage& stage, size_t frame)
{
    if (stage.go_to) {
        stage.go_to(frame);
    }
}

/// An algorithm with its options and its tree, from which cullers can be made.
struct Contender {
    std::string name; ///< name of the algorithm, with a label if there are several runs of it
    std::function<Result<std::unique_ptr<Culler>>(const Hierarchy&)> make;
    std::string hierarchy = {};      ///< as in --hierarchy, for reports
    const Hierarchy* tree = nullptr; ///< null: the tree of the stage
    bool remembers = true;           ///< AlgorithmInfo::remembers: it must see every frame
    /// Whether a culler made from this has ever read the clock; null: they have no clock.
    std::shared_ptr<const bool> asked_time = {};
};

/// One culler per contender, in order; or the error of the first that cannot be made.
Result<std::vector<std::unique_ptr<Culler>>> make_cullers(const Stage& stage,
                                                          std::span<const Contender> contenders);

/// The items of the reference image, in ascending order: those whose boxes touch the frustum, and
/// those that are never culled.
std::vector<ItemId> items_in_frustum(const View& view, std::span<const ItemBounds> item_bounds);

/// `items` in a valid drawing order: the opaque ones in their order, then the translucent ones back
/// to front.
std::vector<ItemId> in_draw_order(const View& view, std::span<const ItemBounds> item_bounds,
                                  std::span<const ItemId> items);

/// The distinct items in an id buffer, in ascending order.
std::vector<ItemId> owners_of_pixels(std::span<const uint32_t> ids);

/// Tells the culler what is visible if it must know it beforehand; does nothing for others.
void record_answer(Culler& culler, const View& view, QueryDevice& device,
                   std::span<const ItemId> owners);

/// True if the culler is one that record_answer() tells something.
bool needs_answer(const Culler& culler);

/// Called during long work with the share that is done (0 to 1).
using ProgressCallback = std::function<void(double share)>;

} // namespace occlude::tools
