#include "measure/motion_player.h"

#include <occlude/core/assert.h>

#include <algorithm>
#include <numeric>

namespace occlude::tools {

MotionPlayer::MotionPlayer(const SceneModel& model, CullScene& scene, Hierarchy& hierarchy,
                           SceneRenderer& renderer, BuildHierarchy build)
    : model_(model)
    , scene_(scene)
    , hierarchy_(&hierarchy)
    , renderer_(renderer)
    , build_(std::move(build))
    , reserved_(scene.scene.item_bounds().begin(), scene.scene.item_bounds().end())
    , fresh_cost_(sah_cost(hierarchy))
{
    OCCLUDE_ASSERT(model.motion.instances.size() == model.instances.size(),
                   "the motion of a scene says something of every instance");
    for (const Instance& instance : model.instances) {
        transforms_.push_back(instance.world_from_mesh);
    }
}

MotionPlayer::MotionPlayer(const SceneModel& model, CullScene& scene, TwoLevelScene& two_level,
                           const TwoLevelOptions& options, SceneRenderer& renderer)
    : model_(model)
    , scene_(scene)
    , two_level_(&two_level)
    , two_level_options_(options)
    , renderer_(renderer)
{
    OCCLUDE_ASSERT(model.motion.instances.size() == model.instances.size(),
                   "the motion of a scene says something of every instance");
    for (const Instance& instance : model.instances) {
        transforms_.push_back(instance.world_from_mesh);
    }
}

void MotionPlayer::go_to(size_t frame)
{
    if (frame == 0 || frame < frame_) {
        rewind();
    }
    take_over(frame);
    update_tree(frame);
    renderer_.update_transforms(transforms_);
    if (items_changed_) {
        renderer_.update_items(scene_.items);
        items_changed_ = false;
    }
    frame_ = frame;
}

void MotionPlayer::add(uint32_t instance)
{
    descriptions_ = item_descriptions(model_, instance);
    scene_.objects[instance] = scene_.scene.add(transforms_[instance], descriptions_);
    const uint32_t first = scene_.scene.first_item(scene_.objects[instance]).value;
    for (uint32_t part = 0; part < descriptions_.size(); ++part) {
        scene_.items[first + part] = {instance, part};
    }
    items_changed_ = true;
}

void MotionPlayer::remove(uint32_t instance)
{
    scene_.scene.remove(scene_.objects[instance]);
}

// The scene gives free ids of one length out in the reverse order in which they became free: so all
// objects are removed by descending ids, and get the ids back that they had at first.
void MotionPlayer::rewind()
{
    std::vector<uint32_t> instances(model_.instances.size());
    std::iota(instances.begin(), instances.end(), 0u);
    for (const uint32_t i : instances) {
        transforms_[i] = model_.instances[i].world_from_mesh;
        if (!scene_.scene.alive(scene_.objects[i])) {
            add(i);
        }
    }
    std::sort(instances.begin(), instances.end(), [&](uint32_t a, uint32_t b) {
        return scene_.scene.first_item(scene_.objects[b]) <
               scene_.scene.first_item(scene_.objects[a]);
    });
    for (const uint32_t i : instances) {
        remove(i);
    }
    for (uint32_t i = 0; i < model_.instances.size(); ++i) {
        add(i);
    }
    if (two_level_ != nullptr) {
        *two_level_ = TwoLevelScene{two_level_options_};
        return;
    }
    std::copy(scene_.scene.item_bounds().begin(), scene_.scene.item_bounds().end(),
              reserved_.begin());
    if (!as_built_) {
        build_tree(0);
    }
    as_built_ = true;
    built_at_ = 0;
    rebuilds_ = 0;
}

// First all that vanishes, then all that appears, so that no more slots are needed than there are.
void MotionPlayer::take_over(size_t frame)
{
    const Motion& motion = model_.motion;
    for (uint32_t i = 0; i < transforms_.size(); ++i) {
        transforms_[i] =
            moved(motion.instances[i], motion.box, model_.instances[i].world_from_mesh, frame);
        if (!scene_.scene.alive(scene_.objects[i])) {
            continue;
        }
        if (exists(motion.instances[i], frame)) {
            scene_.scene.move(scene_.objects[i], transforms_[i]);
        } else {
            remove(i);
        }
    }
    for (uint32_t i = 0; i < transforms_.size(); ++i) {
        if (exists(motion.instances[i], frame) && !scene_.scene.alive(scene_.objects[i])) {
            add(i);
        }
    }
}

void MotionPlayer::update_tree(size_t frame)
{
    if (two_level_ != nullptr) {
        two_level_->sync(scene_.scene);
        return;
    }
    const std::span<const ItemBounds> bounds = scene_.scene.item_bounds();
    OCCLUDE_ASSERT(bounds.size() == reserved_.size(), "every item has a slot from the beginning");
    for (size_t i = 0; i < bounds.size(); ++i) {
        if (!bounds[i].box.is_empty()) {
            reserved_[i] = bounds[i];
        }
    }
    hierarchy_->refit(bounds);
    if (frame >= built_at_ + kRebuildPause && sah_cost(*hierarchy_) > kWorstCost * fresh_cost_) {
        build_tree(frame);
        hierarchy_->refit(bounds);
        as_built_ = false;
        ++rebuilds_;
    }
}

// Free slots keep a place near where they were last used, rather than all in one corner of the tree.
void MotionPlayer::build_tree(size_t frame)
{
    *hierarchy_ = build_(reserved_);
    fresh_cost_ = sah_cost(*hierarchy_);
    built_at_ = frame;
}

} // namespace occlude::tools
