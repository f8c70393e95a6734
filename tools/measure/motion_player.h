// Plays the motion of a scene: brings the boxes, the tree and the renderer to the state of a frame,
// as an engine does between frames. An object that vanishes is removed from the Scene, one that
// appears is added. So item ids are reused, mostly by other objects.
#pragma once

#include "measure/moving_tree.h"
#include "model/scene_model.h"
#include "render/scene_renderer.h"

#include <vector>

namespace occlude::tools {

class MotionPlayer {
public:
    /// Keeps references; all must outlive the player and belong together. `scene` is
    /// make_cull_scene(model), unchanged. Does nothing before go_to(). Precondition: the model has
    /// a motion.
    MotionPlayer(const SceneModel& model, CullScene& scene, MovingTree& tree,
                 SceneRenderer& renderer);

    /// Brings everything to the state of `frame`. Frame 0, and any frame before the last one,
    /// starts again from the beginning: the same frames in the same order give the same ids, trees
    /// and images. scene.item_bounds() keeps its address. O(items) plus the cost of the tree.
    void go_to(size_t frame);

    /// The mean time in which the tree followed a frame, since the player was made; NaN before the
    /// first.
    double tree_update_ms() const;

private:
    void rewind();
    void add(uint32_t instance);
    void take_over(size_t frame);

    const SceneModel& model_;
    CullScene& scene_;
    MovingTree& tree_;
    SceneRenderer& renderer_;
    CullScene first_;                   ///< the initial scene: every object has its slots
    std::vector<glm::mat4> transforms_; ///< by instance, in the current frame
    size_t frame_ = 0;
    bool items_changed_ = false;
    double tree_seconds_ = 0.0;
    size_t tree_updates_ = 0;
};

} // namespace occlude::tools
