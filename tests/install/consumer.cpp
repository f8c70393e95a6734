// A minimal user of the installed library: two objects, a hierarchy, a view.
#include <occlude/core/view.h>
#include <occlude/hierarchy/builders/bvh_builder.h>
#include <occlude/scene/scene.h>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <array>
#include <cstdio>

#ifdef HAS_CONFORMANCE
#include <occlude/conformance/conformance.h>
#include <occlude/device/scripted_device.h>

namespace {

// A device to which everything is visible keeps the contract.
struct SeesEverything : occlude::conformance::Host {
    occlude::QueryDevice& device() override { return scripted; }
    void set_items(std::span<const occlude::Aabb>) override {}
    occlude::ScriptedDevice scripted;
};

bool conforms()
{
    SeesEverything host;
    return check_device(host, {.worlds = 1, .must_find_hidden = false}).passed();
}

} // namespace
#else
static bool conforms()
{
    return true;
}
#endif

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
    return hierarchy.items().size() == 2 && seen == 1 && conforms() ? 0 : 1;
}
