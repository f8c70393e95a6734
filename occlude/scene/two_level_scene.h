// Keeps a two-level tree up to date with a scene whose objects come, go and move.
#pragma once

#include <occlude/hierarchy/builders/two_level.h>
#include <occlude/scene/scene.h>

namespace occlude {

/// The two-level tree of one scene:
///
///     TwoLevelScene tree;
///     every frame:  scene.move(...); tree.sync(scene); culler.cull(view, device);
///
/// Make the culler over tree.hierarchy().
class TwoLevelScene {
public:
    explicit TwoLevelScene(const TwoLevelOptions& options = {})
        : tree_(options)
    {
    }

    /// Takes over the objects that were added, moved and removed since the last call, and updates
    /// the tree. Call it once per frame, always with the same scene, which must keep its address
    /// because the tree refers to its shapes. O(1) if nothing moved, else O(items) plus the cost of
    /// TwoLevelTree::update().
    void sync(const Scene& scene);

    const TwoLevelTree& tree() const { return tree_; }
    const Hierarchy& hierarchy() const { return tree_.hierarchy(); }

private:
    /// The state of one object slot of the scene.
    struct Known {
        ObjectId id;
        TwoLevelTree::Slot slot = 0;
        glm::mat4 world_from_object{1.0f};
        uint64_t seen = 0; ///< the last sync() that found it
    };
    void forget_objects();
    void take_over(const Scene& scene);

    TwoLevelTree tree_;
    std::vector<Known> known_; ///< by ObjectId::index
    std::vector<Aabb> boxes_;  ///< scratch
    const Scene* scene_ = nullptr;
    uint64_t syncs_ = 0;
    uint64_t content_version_ = 0;
    uint64_t motion_version_ = 0;
};

} // namespace occlude
