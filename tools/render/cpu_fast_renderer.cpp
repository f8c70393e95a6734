#include "render/cpu_fast_renderer.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace occlude::tools {

namespace {

/// A SceneModel in the form that CpuFastDevice needs: each part of a mesh is prepared once.
class OccluderScene final : public CpuFastScene {
public:
    OccluderScene(const SceneModel& model, std::span<const SceneModel::Item> items)
        : model_(model)
    {
        for (const Instance& instance : model.instances) {
            world_from_mesh_.push_back(instance.world_from_mesh);
        }
        set_items(items);
    }

    CpuFastItem item(ItemId item) const override
    {
        if (!item.valid() || item.value >= items_.size()) {
            return {};
        }
        return {meshes_[item.value], world_from_mesh_[items_[item.value].instance]};
    }

    void set_transforms(std::span<const glm::mat4> world_from_mesh)
    {
        const size_t count = std::min(world_from_mesh.size(), world_from_mesh_.size());
        std::copy_n(world_from_mesh.begin(), count, world_from_mesh_.begin());
    }

    void set_items(std::span<const SceneModel::Item> items)
    {
        items_.assign(items.begin(), items.end());
        meshes_.assign(items.size(), nullptr);
        for (size_t i = 0; i < items.size(); ++i) {
            const Instance& instance = model_.instances[items[i].instance];
            if (!instance.translucent()) {
                meshes_[i] = &prepared(instance.mesh, items[i].part);
            }
        }
    }

private:
    const OccluderMesh& prepared(uint32_t mesh_index, uint32_t part_index)
    {
        const auto [entry, added] = prepared_.try_emplace({mesh_index, part_index});
        if (added) {
            const Mesh& mesh = model_.meshes[mesh_index];
            const MeshPart& part = mesh.parts[part_index];
            entry->second = OccluderMesh::prepare(
                PositionStream(mesh.positions),
                std::span(mesh.indices).subspan(part.first_index, part.index_count));
        }
        return entry->second;
    }

    const SceneModel& model_;
    std::vector<SceneModel::Item> items_;
    std::vector<const OccluderMesh*> meshes_; ///< by ItemId; null: hides nothing
    std::vector<glm::mat4> world_from_mesh_;  ///< by instance
    std::map<std::pair<uint32_t, uint32_t>, OccluderMesh> prepared_; ///< by mesh and part
};

class CpuFastRenderer final : public SceneRenderer {
public:
    CpuFastRenderer(std::unique_ptr<SceneRenderer> renderer, const SceneModel& model,
                    std::span<const SceneModel::Item> items, const CpuFastDeviceOptions& options)
        : renderer_(std::move(renderer))
        , scene_(model, items)
        , device_(&renderer_->device(), scene_, options)
    {
    }

    std::string api() const override { return renderer_->api(); }
    std::string renderer_name() const override { return renderer_->renderer_name(); }
    QueryDevice& device() override { return device_; }
    Result<bool> use_test_method(TestMethod method) override { return device_.use_method(method); }
    Result<bool> resize(glm::ivec2 size, int samples) override
    {
        return renderer_->resize(size, samples);
    }
    void finish() override { renderer_->finish(); }
    void warm_up() override { renderer_->warm_up(); }
    void render(const View& view, std::span<const ItemId> items) override
    {
        renderer_->render(view, items);
    }
    Capture capture() override { return renderer_->capture(); }
    std::vector<uint32_t> render_ids(const View& view, std::span<const ItemId> items) override
    {
        return renderer_->render_ids(view, items);
    }
    void set_item_colors(std::span<const glm::vec4> colors) override
    {
        renderer_->set_item_colors(colors);
    }
    void draw_lines(const View& view, std::span<const glm::vec3> points, glm::vec4 color,
                    bool on_top) override
    {
        renderer_->draw_lines(view, points, color, on_top);
    }
    void update_transforms(std::span<const glm::mat4> world_from_mesh) override
    {
        scene_.set_transforms(world_from_mesh);
        renderer_->update_transforms(world_from_mesh);
    }
    void update_items(std::span<const SceneModel::Item> items) override
    {
        scene_.set_items(items);
        renderer_->update_items(items);
    }

private:
    std::unique_ptr<SceneRenderer> renderer_;
    OccluderScene scene_;
    CpuFastDevice device_;
};

} // namespace

std::unique_ptr<SceneRenderer> make_cpu_fast_renderer(std::unique_ptr<SceneRenderer> renderer,
                                                      const SceneModel& model,
                                                      std::span<const SceneModel::Item> items,
                                                      const CpuFastDeviceOptions& options)
{
    return std::make_unique<CpuFastRenderer>(std::move(renderer), model, items, options);
}

} // namespace occlude::tools
