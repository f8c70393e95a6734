#include <occlude/cull/parts/object_spaces.h>

#include <occlude/core/assert.h>

namespace occlude {

void ObjectSpaces::start_frame(const Hierarchy& hierarchy)
{
    spaces_.resize(hierarchy.object_nodes().frames.size());
    for (Space& space : spaces_) {
        space.known = false;
    }
}

SpacedBox ObjectSpaces::test_box(const View& view, const Hierarchy& hierarchy, NodeId node)
{
    const Tested at = tested(view, hierarchy, node);
    if (at.space == nullptr) {
        return {view.inflated_for_test(at.box)};
    }
    return {inflated(at.box, at.space->inflation.margin(at.box)), at.world_from_box};
}

ScreenBounds ObjectSpaces::project(const View& view, const Hierarchy& hierarchy, NodeId node)
{
    const Tested at = tested(view, hierarchy, node);
    return occlude::project(at.space != nullptr ? at.space->view : view, at.box);
}

ObjectSpaces::Tested ObjectSpaces::tested(const View& view, const Hierarchy& hierarchy, NodeId node)
{
    OCCLUDE_ASSERT(node.value < hierarchy.nodes().size(), "the node belongs to another tree");
    const ObjectNodes& info = hierarchy.object_nodes();
    const Aabb& world_box = hierarchy.node(node).box;
    if (info.empty()) {
        return {world_box};
    }
    const uint32_t object = info.object[node.value];
    const Aabb& box = info.box[node.value];
    if (object == ObjectNodes::kScene || !info.frames[object].oriented) {
        return {box};
    }
    const Space& space = space_of(view, hierarchy, object);
    if (!space.usable || !box.is_bounded()) {
        return {world_box};
    }
    return {box, &info.frames[object].world_from_object, &space};
}

const ObjectSpaces::Space& ObjectSpaces::space_of(const View& view, const Hierarchy& hierarchy,
                                                  uint32_t object)
{
    OCCLUDE_ASSERT(object < spaces_.size(), "start_frame() was called for another tree");
    Space& space = spaces_[object];
    if (!space.known) {
        const glm::mat4& map = hierarchy.object_nodes().frames[object].world_from_object;
        const float shrink = inverse_stretch(map);
        space.known = true;
        space.usable = shrink > 0.0f;
        space.inflation = view.inflation().in(map, shrink);
        space.view = view.in_object(map);
    }
    return space;
}

} // namespace occlude
