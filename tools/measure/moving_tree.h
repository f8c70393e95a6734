// Keeps a tree up to date with a scene whose objects move, come and go.
#pragma once

#include <occlude/hierarchy/hierarchy.h>
#include <occlude/scene/scene.h>
#include <occlude/scene/two_level_scene.h>

#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace occlude::tools {

class MovingTree {
public:
    virtual ~MovingTree() = default;
    MovingTree(const MovingTree&) = delete;
    MovingTree& operator=(const MovingTree&) = delete;

    /// Starts again: `scene` has all its objects in their initial places. The results do not depend
    /// on earlier frames.
    virtual void rewind(const Scene& scene) = 0;
    /// Takes over the state of the scene in `frame`. Call it once per frame, before any view is
    /// culled.
    virtual void update(const Scene& scene, size_t frame) = 0;

protected:
    MovingTree() = default;
};

using BuildHierarchy = std::function<Hierarchy(std::span<const ItemBounds>)>;

/// Any hierarchy, refitted in every frame. All objects exist when it is built, so that every item
/// id has a permanent place in it: a free slot has an empty box, which is outside every frustum. It
/// is rebuilt only when refitting has made it too slow, because cullers forget their state then.
class RefittedTree final : public MovingTree {
public:
    /// Rebuilt when its expected cost (sah_cost()) exceeds the cost of the fresh tree this many
    /// times, but not before this many frames.
    static constexpr double kWorstCost = 1.5;
    static constexpr size_t kRebuildPause = 16;

    /// Keeps a reference. `hierarchy` is the result of `build` for the boxes of `scene`, which has
    /// all its objects.
    RefittedTree(Hierarchy& hierarchy, const Scene& scene, BuildHierarchy build);

    /// Builds the tree again if update() has rebuilt it.
    void rewind(const Scene& scene) override;
    /// O(items + nodes), and occasionally a build.
    void update(const Scene& scene, size_t frame) override;

    /// How often the tree was rebuilt since the last rewind().
    size_t rebuild_count() const { return rebuilds_; }

private:
    void build_tree(size_t frame);

    Hierarchy& hierarchy_;
    BuildHierarchy build_;
    std::vector<ItemBounds> reserved_; ///< by item: the last box that was not empty
    double fresh_cost_ = 0.0;
    size_t built_at_ = 0;
    size_t rebuilds_ = 0;
};

/// The two-level tree, which relinks moved objects.
class RelinkedTree final : public MovingTree {
public:
    /// Keeps a reference.
    RelinkedTree(TwoLevelScene& tree, const TwoLevelOptions& options)
        : tree_(tree)
        , options_(options)
    {
    }

    void rewind(const Scene& scene) override;
    void update(const Scene& scene, size_t frame) override;

private:
    TwoLevelScene& tree_;
    TwoLevelOptions options_;
};

/// Several trees of the same scene, all kept up to date.
class MovingTrees final : public MovingTree {
public:
    explicit MovingTrees(std::vector<std::unique_ptr<MovingTree>> trees)
        : trees_(std::move(trees))
    {
    }

    void rewind(const Scene& scene) override;
    void update(const Scene& scene, size_t frame) override;

private:
    std::vector<std::unique_ptr<MovingTree>> trees_;
};

} // namespace occlude::tools
