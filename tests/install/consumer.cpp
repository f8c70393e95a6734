// The least a user of the installed library does: two objects, a hierarchy, a view.
#include <occlude/core/view.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/scene/scene.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <array>
#include <cstdio>

int main()
{
    const std::array item{
        occlude::ItemDesc{{glm::vec3{-1.0f}, glm::vec3{1.0f}}, 12, occlude::ItemFlags::none}};
    occlude::Scene scene;
    scene.add(glm::mat4{1.0f}, item);
    scene.add(glm::translate(glm::mat4{1.0f}, {0.0f, 0.0f, 50.0f}), item);

    const occlude::Hierarchy hierarchy = occlude::build_bvh(scene.item_bounds());
    const glm::mat4 clip_from_world = glm::perspective(1.0f, 4.0f / 3.0f, 0.1f, 100.0f) *
                                      glm::translate(glm::mat4{1.0f}, {0.0f, 0.0f, -10.0f});
    const occlude::View view = occlude::View::from_clip(clip_from_world, {640, 480});

    int seen = 0;
    for (const occlude::ItemBounds& bounds : scene.item_bounds()) {
        seen += view.frustum().classify(bounds.box) != occlude::Containment::outside ? 1 : 0;
    }
    std::printf("%zu items, %d in front of the camera\n", hierarchy.items().size(), seen);
    return hierarchy.items().size() == 2 && seen == 1 ? 0 : 1;
}
