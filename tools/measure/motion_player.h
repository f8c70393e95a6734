// Plays the motion of a scene: brings the boxes, the tree and the renderer to the state of a frame,
// as an engine does between frames.
//
// An object that vanishes is removed from the Scene, one that appears is added, so item ids are used
// again, mostly by other objects. As many slots as the scene has items were given out when the tree
// was built, so every id is in the tree for ever: a free slot has an empty box, which is outside of
// every frustum. The tree is refitted in every frame and built anew only when refitting has made it
// too bad, because cullers forget what they know of a tree that was rebuilt.
#pragma once

#include "render/scene_renderer.h"
#include "scenes/scene_model.h"

#include <occlude/hierarchy/hierarchy.h>
#include <occlude/scene/two_level_scene.h>

#include <functional>
#include <span>
#include <vector>

namespace occlude::tools {

using BuildHierarchy = std::function<Hierarchy(std::span<const ItemBounds>)>;

class MotionPlayer {
public:
    /// The tree is rebuilt when its expected cost (sah_cost()) exceeds that of the fresh tree this
    /// many times, but not before so many frames.
    static constexpr double kWorstCost = 1.5;
    static constexpr size_t kRebuildPause = 16;

    /// Keeps references; all must outlive the player and belong together: `scene` is
    /// make_cull_scene(model), `hierarchy` is `build` of its boxes. Nothing is changed before
    /// go_to(). Precondition: the model has a motion.
    MotionPlayer(const SceneModel& model, CullScene& scene, Hierarchy& hierarchy,
                 SceneRenderer& renderer, BuildHierarchy build);

    /// The same for a two-level tree, which follows the objects by itself and is never rebuilt:
    /// `two_level` has been synced with the scene, and keeps `options` when it begins anew.
    MotionPlayer(const SceneModel& model, CullScene& scene, TwoLevelScene& two_level,
                 const TwoLevelOptions& options, SceneRenderer& renderer);

    /// Brings everything to the state of `frame`. Frame 0, and any frame before the last one, begins
    /// anew: the same frames in the same order give the same ids, trees and images. O(items +
    /// nodes), and a build now and then. scene.item_bounds() stays where it is.
    void go_to(size_t frame);

    /// How often the tree was rebuilt because it had become too bad.
    size_t rebuild_count() const { return rebuilds_; }

private:
    void rewind();
    void add(uint32_t instance);
    void remove(uint32_t instance);
    void take_over(size_t frame);
    void update_tree(size_t frame);
    void build_tree(size_t frame);

    const SceneModel& model_;
    CullScene& scene_;
    Hierarchy* hierarchy_ = nullptr;     ///< refitted and rebuilt, or ...
    TwoLevelScene* two_level_ = nullptr; ///< ... synced
    TwoLevelOptions two_level_options_;
    SceneRenderer& renderer_;
    BuildHierarchy build_;
    std::vector<glm::mat4> transforms_;  ///< by instance, in the current frame
    std::vector<ItemBounds> reserved_;   ///< by item: the last box that was not empty
    std::vector<ItemDesc> descriptions_; ///< scratch
    size_t frame_ = 0;
    size_t built_at_ = 0;
    double fresh_cost_ = 0.0;
    size_t rebuilds_ = 0;
    bool as_built_ = true; ///< the structure is that of frame 0
    bool items_changed_ = false;
};

} // namespace occlude::tools
