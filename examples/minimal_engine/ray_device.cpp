#include "ray_device.h"

#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include <algorithm>

namespace minimal_engine {

using namespace occlude;

constexpr float kNothing = 2.0f; // farther than the far plane

// The depth at which the ray enters the box; kNothing if it misses the box.
static float entry_depth(const Aabb& box, const glm::vec3& origin, const glm::vec3& step)
{
    const glm::vec3 a = (box.min - origin) / step;
    const glm::vec3 b = (box.max - origin) / step;
    const glm::vec3 enter = glm::min(a, b);
    const glm::vec3 leave = glm::max(a, b);
    const float first = std::max({enter.x, enter.y, enter.z, 0.0f});
    const float last = std::min({leave.x, leave.y, leave.z, 1.0f});
    return first <= last ? first : kNothing;
}

void RayDevice::begin_frame(const View& view)
{
    const glm::ivec2 size = view.size_px();
    const glm::mat4 world_from_clip = glm::inverse(view.clip_from_world());
    const auto unproject = [&](glm::vec2 ndc, float z) {
        const glm::vec4 point = world_from_clip * glm::vec4{ndc, z, 1.0f};
        return glm::vec3{point} / point.w;
    };
    rays_.clear();
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            const glm::vec2 center = (glm::vec2{x, y} + 0.5f) / glm::vec2{size};
            const glm::vec3 origin = unproject(2.0f * center - 1.0f, -1.0f);
            rays_.push_back({origin, unproject(2.0f * center - 1.0f, 1.0f) - origin});
        }
    }
    depth_.assign(rays_.size(), kNothing);
    image_.assign(rays_.size(), ItemId{});
}

void RayDevice::draw(std::span<const ItemId> items, DrawPass pass)
{
    if (pass == DrawPass::shade_equal) {
        return; // the image is complete: this engine's depth-only pass shades too
    }
    for (const ItemId item : items) {
        for (size_t pixel = 0; pixel < rays_.size(); ++pixel) {
            const float depth =
                entry_depth(world_[item.value].box, rays_[pixel].origin, rays_[pixel].step);
            if (depth < depth_[pixel]) {
                depth_[pixel] = depth;
                image_[pixel] = item;
            }
        }
    }
}

void RayDevice::query(const QueryBatch& batch, std::span<Ticket> tickets)
{
    size_t box = 0;
    for (size_t test = 0; test < batch.test_ends.size(); ++test) {
        std::vector<bool> seen(rays_.size(), false); // overlapping boxes count as one union
        for (; box < batch.test_ends[test]; ++box) {
            const QueryBox& tested = batch.boxes[box];
            const Aabb world_box = tested.world_from_box
                                       ? transformed(*tested.world_from_box, tested.box)
                                       : tested.box;
            for (size_t pixel = 0; pixel < rays_.size(); ++pixel) {
                const float depth = entry_depth(world_box, rays_[pixel].origin, rays_[pixel].step);
                // LESS or EQUAL: geometry may lie on the face of its own box.
                seen[pixel] = seen[pixel] || (depth < kNothing && depth <= depth_[pixel]);
            }
        }
        if (answers_.size() >= caps_.max_outstanding) {
            tickets[test] = {}; // invalid, so that it answers `lost`: too many tests wait already
            continue;
        }
        const auto samples = std::count(seen.begin(), seen.end(), true);
        tickets[test] = {next_ticket_++, 1};
        answers_[tickets[test].index] = static_cast<uint64_t>(samples);
    }
}

Answer RayDevice::wait(Ticket ticket)
{
    const auto found = answers_.find(ticket.index);
    if (ticket.generation != 1 || found == answers_.end()) {
        return Answer::lost(); // spent or unknown ticket: counts as visible
    }
    const Answer answer = Answer::ready(found->second);
    answers_.erase(found);
    return answer;
}

} // namespace minimal_engine
