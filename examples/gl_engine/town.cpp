#include "town.h"

#include <occlude/core/rng.h>

#include <glm/ext/matrix_transform.hpp>

#include <cmath>

namespace gl_engine {

namespace {

constexpr int kBlocks = 14; // along a side
constexpr float kBlock = Town::kSide / kBlocks;
constexpr int kCars = 60;

Draw box(uint32_t material, glm::vec3 low, glm::vec3 high)
{
    const glm::mat4 place = glm::translate(glm::mat4{1.0f}, 0.5f * (low + high));
    return {Draw::Mesh::cube, material, glm::scale(place, high - low)};
}

glm::vec3 car_position(int car, double seconds)
{
    const float along = static_cast<float>(std::fmod(3.0 * seconds + 17.0 * car, Town::kSide));
    const float street = kBlock * static_cast<float>(car % kBlocks) - 0.5f * Town::kSide + 1.0f;
    const float x = along - 0.5f * Town::kSide;
    return car % 2 == 0 ? glm::vec3{x, 0.6f, street} : glm::vec3{street, 0.6f, x};
}

} // namespace

Town::Town()
{
    occlude::Rng rng{5};
    draws_.push_back(
        box(3, {-0.5f * kSide, -1.0f, -0.5f * kSide}, {0.5f * kSide, 0.0f, 0.5f * kSide}));
    for (int i = 0; i < kBlocks * kBlocks; ++i) {
        const glm::vec3 corner{kBlock * static_cast<float>(i % kBlocks) - 0.5f * kSide + 2.5f, 0.0f,
                               kBlock * static_cast<float>(i / kBlocks) - 0.5f * kSide + 2.5f};
        const glm::vec3 size{kBlock - 4.0f, rng.range(4.0f, 18.0f), kBlock - 4.0f};
        draws_.push_back(box(static_cast<uint32_t>(i) % 2, corner, corner + size));
        const glm::vec3 lamp = corner - glm::vec3{0.6f, 0.0f, 0.6f};
        draws_.push_back(box(2, lamp, lamp + glm::vec3{0.2f, 4.0f, 0.2f}));
    }
    first_car_ = draws_.size();
    for (int car = 0; car < kCars; ++car) {
        draws_.push_back({Draw::Mesh::sphere, 2, glm::mat4{1.0f}});
    }
    move_to(0.0);
}

void Town::move_to(double seconds)
{
    for (size_t i = first_car_; i < draws_.size(); ++i) {
        const glm::vec3 at = car_position(static_cast<int>(i - first_car_), seconds);
        draws_[i].world_from_mesh =
            glm::scale(glm::translate(glm::mat4{1.0f}, at), glm::vec3{1.2f});
    }
}

std::vector<occlude::ItemBounds> Town::bounds() const
{
    const occlude::Aabb unit{glm::vec3{-0.5f}, glm::vec3{0.5f}};
    std::vector<occlude::ItemBounds> bounds;
    for (const Draw& draw : draws_) {
        bounds.push_back(
            {occlude::transformed(draw.world_from_mesh, unit), triangle_count(draw.mesh)});
    }
    return bounds;
}

} // namespace gl_engine
