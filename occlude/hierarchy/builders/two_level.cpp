#include <occlude/hierarchy/builders/two_level.h>

#include <occlude/hierarchy/builders/detail/scene_bsp.h>
#include <occlude/hierarchy/builders/detail/two_level_layout.h>

#include <set>

namespace occlude {

struct TwoLevelTree::Parts {
    explicit Parts(const TwoLevelOptions& options)
        : bsp(options)
        , layout(options)
        , quiet_frames(options.quiet_frames)
    {
    }

    detail::SceneBsp bsp;
    detail::TwoLevelLayout layout;
    uint32_t quiet_frames;
    uint64_t restless_until = 0; ///< the last update at which some test box may still change
};

TwoLevelTree::TwoLevelTree(const TwoLevelOptions& options)
    : parts_(std::make_unique<Parts>(options))
{
}

TwoLevelTree::TwoLevelTree(TwoLevelTree&&) noexcept = default;

// Moves the contents, not the parts: cullers keep a reference to the hierarchy inside.
TwoLevelTree& TwoLevelTree::operator=(TwoLevelTree&& other) noexcept
{
    if (this != &other && parts_ != nullptr && other.parts_ != nullptr) {
        *parts_ = std::move(*other.parts_);
    } else if (this != &other) {
        parts_ = std::move(other.parts_);
    }
    return *this;
}

TwoLevelTree::~TwoLevelTree() = default;

TwoLevelTree::Slot TwoLevelTree::add(const TwoLevelObject& object)
{
    return parts_->bsp.add(object);
}

void TwoLevelTree::move(Slot slot, const glm::mat4& world_from_object)
{
    parts_->bsp.move(slot, world_from_object);
}

void TwoLevelTree::remove(Slot slot)
{
    parts_->bsp.remove(slot);
}

void TwoLevelTree::update(std::span<const ItemBounds> bounds_by_item)
{
    detail::SceneBsp& bsp = parts_->bsp;
    const bool changed = bsp.update(bounds_by_item);
    if (changed) { // the cells of a rebuilt subtree are restless, too
        parts_->restless_until = bsp.updates() + parts_->quiet_frames;
    }
    if (bsp.needs_layout()) {
        parts_->layout.lay_out(bsp, bounds_by_item);
        bsp.finish_layout();
    } else if (changed || bsp.updates() <= parts_->restless_until) {
        parts_->layout.refit(bsp, bounds_by_item);
    }
    bsp.finish_update();
}

void TwoLevelTree::set_shapes(const ItemShapes* shapes)
{
    parts_->layout.set_shapes(shapes);
}

const Hierarchy& TwoLevelTree::hierarchy() const
{
    return parts_->layout.hierarchy();
}

uint64_t TwoLevelTree::relink_count() const
{
    return parts_->bsp.relinks();
}

uint64_t TwoLevelTree::rebuild_count() const
{
    return parts_->bsp.rebuilds();
}

std::string TwoLevelTree::check() const
{
    const Hierarchy& tree = hierarchy();
    const ObjectNodes& nodes = tree.object_nodes();
    if (std::string problem = validate(tree); !problem.empty()) {
        return problem;
    }
    std::set<uint32_t> keys;
    for (size_t i = 0; i < tree.nodes().size(); ++i) {
        if (!keys.insert(nodes.key[i]).second || nodes.key[i] >= nodes.key_count) {
            return "node " + std::to_string(i) + " shares its key or has none";
        }
        if (nodes.object[i] == ObjectNodes::kScene &&
            !contains(nodes.box[i], tree.nodes()[i].box)) {
            return "scene node " + std::to_string(i) + " has a test box that does not contain it";
        }
    }
    size_t items = 0;
    for (const detail::SceneBsp::Object& object : parts_->bsp.objects()) {
        items += object.item_count;
    }
    if (items != tree.items().size()) {
        return "an item is missing from the tree";
    }
    return parts_->bsp.check();
}

Hierarchy build_two_level(std::span<const ItemBounds> items, const TwoLevelOptions& options)
{
    TwoLevelTree tree(options);
    for (uint32_t i = 0; i < items.size(); ++i) {
        const Aabb box = sanitized(items[i].box);
        tree.add({.first_item = ItemId{i}, .local_boxes = {&box, 1}});
    }
    tree.update(items);
    return tree.hierarchy();
}

} // namespace occlude
