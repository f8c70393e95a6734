// Software occlusion culling by itself: an engine that rasterises a few walls on the CPU and asks
// which of its objects it can leave out, without a graphics card, a hierarchy or a device.
#include <occlude/occluder_buffer.h>

#include <glm/gtc/matrix_transform.hpp>

#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

// A street: a row of houses on both sides, objects before and behind them.
struct Town {
    std::vector<glm::mat4> houses; ///< world from the unit cube
    std::vector<occlude::Aabb> objects;
};

Town make_town()
{
    Town town;
    for (int i = 0; i < 12; ++i) {
        for (const float side : {-1.0f, 1.0f}) {
            const glm::vec3 corner{side > 0.0f ? 4.0f : -12.0f, 0.0f, -9.0f * float(i) - 8.0f};
            town.houses.push_back(
                glm::scale(glm::translate(glm::mat4{1.0f}, corner), glm::vec3{8.0f, 10.0f, 9.0f}));
            const glm::vec3 behind{side * 16.0f, 0.0f, corner.z + 3.0f};
            town.objects.push_back({behind, behind + glm::vec3{1.0f, 2.0f, 1.0f}});
            const glm::vec3 before{side * 2.0f, 0.0f, corner.z + 3.0f};
            town.objects.push_back({before, before + glm::vec3{0.5f, 2.0f, 0.5f}});
        }
    }
    return town;
}

} // namespace

int main()
{
    // Once: a mesh that may hide things. Any positions and indices; here a cube.
    const std::vector<glm::vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                         {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    const std::vector<uint16_t> indices{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    const auto house = occlude::OccluderMesh::prepare(occlude::PositionStream(corners), indices);
    const Town town = make_town();
    const glm::mat4 clip_from_world =
        glm::perspective(1.0f, 16.0f / 9.0f, 0.1f, 300.0f) *
        glm::lookAt(glm::vec3{0.0f, 1.7f, 0.0f}, glm::vec3{0.0f, 1.7f, -1.0f},
                    glm::vec3{0.0f, 1.0f, 0.0f});
    const auto view = occlude::View::from_clip(clip_from_world, {1280, 720});

    // Every frame.
    occlude::OccluderBuffer buffer;
    buffer.begin(view);
    for (const glm::mat4& world_from_house : town.houses) {
        buffer.add(house, world_from_house);
    }
    buffer.rasterize();
    std::vector<occlude::Visibility> results(town.objects.size());
    buffer.test(town.objects, results);

    int hidden = 0;
    int visible = 0;
    for (size_t i = 0; i < results.size(); ++i) {
        hidden += results[i] == occlude::Visibility::hidden ? 1 : 0;
        visible += results[i] == occlude::Visibility::visible ? 1 : 0;
    }
    std::printf("%zu objects: %d to draw, %d hidden by houses, the rest outside of the view\n",
                results.size(), visible, hidden);
    const bool as_expected = hidden >= 10 && visible >= 10;
    return as_expected ? 0 : 1;
}
