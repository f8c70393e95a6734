// Boxes as occluders.
#pragma once

#include <occlude/backends/cpu_fast/cpu_fast_scene.h>
#include <occlude/core/aabb.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude::test {

inline OccluderMesh box_mesh(const Aabb& box)
{
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i) {
        corners.emplace_back((i & 1) != 0 ? box.max.x : box.min.x,
                             (i & 2) != 0 ? box.max.y : box.min.y,
                             (i & 4) != 0 ? box.max.z : box.min.z);
    }
    const std::vector<uint16_t> indices{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    return OccluderMesh::prepare(PositionStream(corners), indices);
}

class BoxOccluders final : public CpuFastScene {
public:
    void set(std::span<const Aabb> boxes)
    {
        meshes_.clear();
        for (const Aabb& box : boxes) {
            meshes_.push_back(box_mesh(box));
        }
    }
    CpuFastItem item(ItemId item) const override
    {
        return item.value < meshes_.size() ? CpuFastItem{&meshes_[item.value]} : CpuFastItem{};
    }

private:
    std::vector<OccluderMesh> meshes_;
};

} // namespace occlude::test
