#include "measure/moving_tree.h"

#include <occlude/core/assert.h>

namespace occlude::tools {

RefittedTree::RefittedTree(Hierarchy& hierarchy, const Scene& scene, BuildHierarchy build)
    : hierarchy_(hierarchy)
    , build_(std::move(build))
    , reserved_(scene.item_bounds().begin(), scene.item_bounds().end())
    , fresh_cost_(sah_cost(hierarchy))
{
}

void RefittedTree::rewind(const Scene& scene)
{
    reserved_.assign(scene.item_bounds().begin(), scene.item_bounds().end());
    if (rebuilds_ > 0) {
        build_tree(0);
    }
    built_at_ = 0;
    rebuilds_ = 0;
}

void RefittedTree::update(const Scene& scene, size_t frame)
{
    const std::span<const ItemBounds> bounds = scene.item_bounds();
    OCCLUDE_ASSERT(bounds.size() == reserved_.size(), "every item has a slot from the beginning");
    for (size_t i = 0; i < bounds.size(); ++i) {
        if (!bounds[i].box.is_empty()) {
            reserved_[i] = bounds[i];
        }
    }
    hierarchy_.refit(bounds);
    if (frame >= built_at_ + kRebuildPause && sah_cost(hierarchy_) > kWorstCost * fresh_cost_) {
        build_tree(frame);
        hierarchy_.refit(bounds);
        ++rebuilds_;
    }
}

// Free slots keep a place near their last use, so that they do not crowd in one corner of the tree.
void RefittedTree::build_tree(size_t frame)
{
    hierarchy_ = build_(reserved_);
    fresh_cost_ = sah_cost(hierarchy_);
    built_at_ = frame;
}

void RelinkedTree::rewind(const Scene& scene)
{
    tree_ = TwoLevelScene{options_};
    tree_.sync(scene);
}

void RelinkedTree::update(const Scene& scene, size_t)
{
    tree_.sync(scene);
}

void MovingTrees::rewind(const Scene& scene)
{
    for (const auto& tree : trees_) {
        tree->rewind(scene);
    }
}

void MovingTrees::update(const Scene& scene, size_t frame)
{
    for (const auto& tree : trees_) {
        tree->update(scene, frame);
    }
}

} // namespace occlude::tools
