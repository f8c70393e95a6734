#include <occlude/scene/two_level_scene.h>

#include <occlude/core/assert.h>

namespace occlude {

void TwoLevelScene::take_over(const Scene& scene)
{
    for (uint32_t item = 0; item < scene.item_bounds().size();) {
        const ObjectId id = scene.object_of(ItemId{item});
        if (!id.valid()) {
            ++item;
            continue;
        }
        if (id.index >= known_.size()) {
            known_.resize(id.index + 1);
        }
        Known& known = known_[id.index];
        const uint32_t count = scene.item_count(id);
        const glm::mat4& world_from_object = scene.world_from_object(id);
        if (known.id != id) {
            if (known.id.valid()) {
                tree_.remove(known.slot); // its slot has a new owner
            }
            boxes_.clear();
            for (uint32_t i = item; i < item + count; ++i) {
                boxes_.push_back(scene.local_box(ItemId{i}));
            }
            known.id = id;
            known.slot = tree_.add({.first_item = ItemId{item},
                                    .world_from_object = world_from_object,
                                    .local_boxes = boxes_});
        } else if (known.world_from_object != world_from_object) {
            tree_.move(known.slot, world_from_object);
        }
        known.world_from_object = world_from_object;
        known.seen = syncs_;
        item += count;
    }
    for (Known& known : known_) {
        if (known.id.valid() && known.seen != syncs_) {
            tree_.remove(known.slot);
            known = Known{};
        }
    }
}

// Removes all objects, because they belong to another scene.
void TwoLevelScene::forget_objects()
{
    for (const Known& known : known_) {
        if (known.id.valid()) {
            tree_.remove(known.slot);
        }
    }
    known_.clear();
}

void TwoLevelScene::sync(const Scene& scene)
{
    OCCLUDE_ASSERT(scene_ == nullptr || scene_ == &scene,
                   "TwoLevelScene::sync is always called with the same scene");
    if (scene_ != &scene) {
        forget_objects();
        scene_ = &scene;
    }
    ++syncs_;
    const bool changed = known_.empty() || content_version_ != scene.content_version() ||
                         motion_version_ != scene.motion_version();
    if (changed) {
        take_over(scene);
        content_version_ = scene.content_version();
        motion_version_ = scene.motion_version();
    }
    tree_.update(scene.item_bounds());
    tree_.set_shapes(&scene.shapes());
}

} // namespace occlude
