// Items that fill their boxes, for the CPU device.
#pragma once

#include <occlude/backends/cpu/cpu_device.h>
#include <occlude/hierarchy/hierarchy.h>

#include <array>
#include <span>
#include <vector>

namespace occlude::test {

class BoxCpuScene final : public CpuScene {
public:
    /// Item i is the box bounds[i]: twelve triangles, whatever `triangles` says.
    explicit BoxCpuScene(std::span<const ItemBounds> bounds)
    {
        for (const ItemBounds& item : bounds) {
            auto& corners = positions_.emplace_back();
            for (size_t c = 0; c < corners.size(); ++c) {
                corners[c] = {(c & 1) != 0 ? item.box.max.x : item.box.min.x,
                              (c & 2) != 0 ? item.box.max.y : item.box.min.y,
                              (c & 4) != 0 ? item.box.max.z : item.box.min.z};
            }
        }
    }

    CpuItem item(ItemId item) const override
    {
        return {.positions = positions_[item.value], .indices = indices_};
    }

private:
    std::vector<std::array<glm::vec3, 8>> positions_;
    std::vector<uint32_t> indices_{0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7, 0, 4, 1, 1, 4, 5,
                                   2, 3, 6, 6, 3, 7, 0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};
};

/// One frame that draws items 0 to items - 1.
inline void draw_everything(QueryDevice& device, size_t items, const View& view)
{
    std::vector<ItemId> all;
    for (size_t i = 0; i < items; ++i) {
        all.push_back(ItemId{i});
    }
    device.begin_frame(view);
    device.draw(all, DrawPass::shade);
    device.end_frame();
}

/// The item that each pixel shows.
inline std::vector<uint32_t> owners(const CpuDevice& device)
{
    std::vector<uint32_t> all;
    for (size_t pixel = 0; pixel < device.depth().size(); ++pixel) {
        all.push_back(device.owner(pixel).item.value);
    }
    return all;
}

} // namespace occlude::test
