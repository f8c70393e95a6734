#include "measure/motion_player.h"

#include "measure/run.h"
#include "measure/timing_device.h"

#include <occlude/core/assert.h>

namespace occlude::tools {

MotionPlayer::MotionPlayer(const SceneModel& model, CullScene& scene, MovingTree& tree,
                           SceneRenderer& renderer)
    : model_(model)
    , scene_(scene)
    , tree_(tree)
    , renderer_(renderer)
    , first_(scene)
    , transforms_(model.instances.size())
{
    OCCLUDE_ASSERT(model.motion.instances.size() == model.instances.size(),
                   "the motion of a scene must have one entry per instance");
}

void MotionPlayer::go_to(size_t frame)
{
    if (frame == 0 || frame < frame_) {
        rewind();
    }
    take_over(frame);
    const SecondsClock clock = steady_seconds_clock();
    const double start = clock();
    tree_.update(scene_.scene, frame);
    tree_seconds_ += clock() - start;
    ++tree_updates_;
    renderer_.update_transforms(transforms_);
    if (items_changed_) {
        renderer_.update_items(scene_.items);
        items_changed_ = false;
    }
    frame_ = frame;
}

double MotionPlayer::tree_update_ms() const
{
    constexpr double kMsPerSecond = 1000.0;
    return tree_updates_ == 0 ? kNotMeasured
                              : kMsPerSecond * tree_seconds_ / static_cast<double>(tree_updates_);
}

void MotionPlayer::rewind()
{
    [[maybe_unused]] const ItemBounds* place = scene_.scene.item_bounds().data();
    scene_ = first_; // the sizes are the same, so that every array keeps its memory
    OCCLUDE_ASSERT(scene_.scene.item_bounds().data() == place, "the boxes of a stage have moved");
    items_changed_ = true;
    tree_.rewind(scene_.scene);
}

void MotionPlayer::add(uint32_t instance)
{
    const std::vector<ItemDesc> items = item_descriptions(model_, instance);
    scene_.objects[instance] = scene_.scene.add(transforms_[instance], items);
    const uint32_t first = scene_.scene.first_item(scene_.objects[instance]).value;
    for (uint32_t part = 0; part < items.size(); ++part) {
        scene_.items[first + part] = {instance, part};
    }
    items_changed_ = true;
}

// First removes everything that vanishes, then adds everything that appears, so that no additional
// slots are needed.
void MotionPlayer::take_over(size_t frame)
{
    const Motion& motion = model_.motion;
    for (uint32_t i = 0; i < transforms_.size(); ++i) {
        transforms_[i] =
            moved(motion.instances[i], motion.box, model_.instances[i].world_from_mesh, frame);
        if (exists(motion.instances[i], frame)) {
            scene_.scene.move(scene_.objects[i], transforms_[i]); // nothing if it has not appeared
                                                                  // yet
        } else {
            scene_.scene.remove(scene_.objects[i]); // nothing if it has vanished
        }
    }
    for (uint32_t i = 0; i < transforms_.size(); ++i) {
        if (exists(motion.instances[i], frame) && !scene_.scene.alive(scene_.objects[i])) {
            add(i);
        }
    }
}

} // namespace occlude::tools
