// The smallest complete QueryDevice: an "engine" whose world consists of boxes, drawn by casting
// one ray per pixel. Two loops stand for the draw calls and occlusion queries of a real engine; the
// verbs and their order are the same.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/hierarchy/hierarchy.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace minimal_engine {

class RayDevice final : public occlude::QueryDevice {
public:
    /// Draws the boxes of `world`, which is indexed by ItemId and outlives the device.
    explicit RayDevice(std::span<const occlude::ItemBounds> world)
        : world_(world)
    {
        caps_.name = "minimal engine";
        caps_.methods = {{occlude::TestMethod::queries, 0.0f, 0.0f, 50.0f}};
    }

    const occlude::DeviceCaps& caps() const override { return caps_; }
    void begin_frame(const occlude::View& view) override;
    void draw(std::span<const occlude::ItemId> items, occlude::DrawPass pass) override;
    void query(const occlude::QueryBatch& batch, std::span<occlude::Ticket> tickets) override;
    void flush() override {} // all work is done in the calls themselves
    occlude::Answer poll(occlude::Ticket ticket) override { return wait(ticket); }
    occlude::Answer wait(occlude::Ticket ticket) override;
    void end_frame() override {}

    /// The visible item at each pixel; an invalid id where there is none.
    const std::vector<occlude::ItemId>& image() const { return image_; }

private:
    struct Ray {
        glm::vec3 origin; ///< on the near plane
        glm::vec3 step;   ///< to the far plane: depth 0 is near, 1 is far
    };

    occlude::DeviceCaps caps_;
    std::span<const occlude::ItemBounds> world_;
    std::vector<Ray> rays_; ///< one per pixel, as are depth_ and image_
    std::vector<float> depth_;
    std::vector<occlude::ItemId> image_;
    std::unordered_map<uint32_t, uint64_t> answers_; ///< of unspent tickets, by Ticket::index
    uint32_t next_ticket_ = 0;
};

} // namespace minimal_engine
