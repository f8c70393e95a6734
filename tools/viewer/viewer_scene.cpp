// The objects of the viewer's scene: selecting, explaining, moving, adding and deleting them.
#include "viewer/viewer.h"

#include <fmt/format.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cctype>

namespace occlude::tools::viewer {

float Viewer::suggested_speed() const
{
    constexpr float kSecondsToCross = 20.0f;
    const Aabb bounds = world_bounds(session_->model());
    return bounds.is_bounded() ? glm::length(bounds.extent()) / kSecondsToCross
                               : session_->model().unit;
}

void Viewer::note_instances()
{
    instance_of_.clear();
    for (const SceneModel::Item& item : session_->scene().items) {
        instance_of_.push_back(item.instance);
    }
}

std::string Viewer::instance_name(uint32_t instance) const
{
    return object_name(session_->model(), instance);
}

bool Viewer::is_deleted(uint32_t instance) const
{
    const auto& motion = session_->model().motion;
    return !motion.empty() &&
           motion.instances[instance].first_frame > motion.instances[instance].last_frame;
}

void Viewer::select(std::optional<uint32_t> instance)
{
    state_.selection.instance = instance;
    state_.selection.coverage.reset();
    state_.selection.item = {};
    pending_.redraw = true;
    if (instance) {
        const auto found = std::find(instance_of_.begin(), instance_of_.end(), *instance);
        state_.selection.item = ItemId{static_cast<size_t>(found - instance_of_.begin())};
        state_.panels.show_inspector();
    }
}

void Viewer::pick(glm::ivec2 pixel)
{
    if (!session_ || pixel.x < 0 || pixel.y < 0 || pixel.x >= pictures_.size.x ||
        pixel.y >= pictures_.size.y) {
        return;
    }
    const Stage stage = session_->stage();
    const View view = shown_view();
    const Culler* culler = panes_[0]->culler();
    std::vector<ItemId> items = items_in_frustum(view, stage.item_bounds);
    if (state_.picture.fill == Fill::visible && culler != nullptr) {
        items.assign(culler->drawn_items().begin(), culler->drawn_items().end());
    }
    const std::vector<uint32_t> ids = stage.renderer.render_ids(view, items);
    const ItemId item{ids[static_cast<size_t>(pixel.y) * static_cast<size_t>(pictures_.size.x) +
                          static_cast<size_t>(pixel.x)]};
    if (!item.valid()) {
        select(std::nullopt);
        return;
    }
    select(instance_of_[item.value]);
    state_.selection.item = item;
}

std::optional<uint32_t> Viewer::find_by_name(const std::string& text) const
{
    const auto lower = [](std::string name) {
        std::transform(name.begin(), name.end(), name.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        return name;
    };
    const std::string wanted = lower(text);
    const auto count = static_cast<uint32_t>(session_->model().instances.size());
    const uint32_t first = state_.selection.instance ? *state_.selection.instance + 1 : 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t instance = (first + i) % count;
        if (lower(instance_name(instance)).find(wanted) != std::string::npos) {
            return instance;
        }
    }
    return std::nullopt;
}

void Viewer::find_occluders()
{
    if (!state_.selection.instance) {
        say("Select an object first: click it, or search its name.");
        return;
    }
    const uint32_t instance = *state_.selection.instance;
    const Stage stage = session_->stage();
    const View view = culling_view();
    const std::vector<ItemId> all = items_in_frustum(view, stage.item_bounds);
    std::vector<ItemId> own;
    std::copy_if(all.begin(), all.end(), std::back_inserter(own),
                 [&](ItemId item) { return instance_of_[item.value] == instance; });
    const std::vector<uint32_t> alone = stage.renderer.render_ids(view, own);
    const std::vector<uint32_t> together = stage.renderer.render_ids(view, all);
    state_.selection.coverage = coverage(alone, together, instance_of_, instance);
    state_.panels.show_inspector();
}

void Viewer::move_selected(const glm::vec3& by)
{
    if (!session_ || !state_.selection.instance) {
        return;
    }
    Instance& instance = session_->editable_model().instances[*state_.selection.instance];
    instance.world_from_mesh = glm::translate(glm::mat4{1.0f}, by) * instance.world_from_mesh;
    pending_.redraw = true;
}

void Viewer::delete_selected()
{
    if (!state_.selection.instance) {
        say("Select an object first: click it, or search its name.");
        return;
    }
    const uint32_t instance = *state_.selection.instance;
    InstanceMotion& motion = session_->editable_model().motion.instances[instance];
    const bool deleted = is_deleted(instance);
    motion.first_frame = deleted ? 0 : 1;
    motion.last_frame = deleted ? 0xffffffffu : 0;
    pending_.redraw = true;
    say(instance_name(instance) +
        (deleted ? " is back." : " is deleted; Delete again brings it back."));
}

void Viewer::duplicate_selected()
{
    if (!state_.selection.instance) {
        say("Select an object first: click it, or search its name.");
        return;
    }
    SceneModel model = session_->model();
    const uint32_t original = *state_.selection.instance;
    const Aabb box = session_->scene().scene.item_bounds()[state_.selection.item.value].box;
    Instance copy = model.instances[original];
    copy.name = instance_name(original) + " copy";
    if (box.is_bounded() && !box.is_empty()) {
        const glm::vec3 beside = state_.camera.fly.right() * glm::length(box.extent());
        copy.world_from_mesh = glm::translate(glm::mat4{1.0f}, beside) * copy.world_from_mesh;
    }
    model.instances.push_back(copy);
    if (!model.motion.empty()) {
        model.motion.instances.push_back(model.motion.instances[original]);
    }
    const auto instance = static_cast<uint32_t>(model.instances.size() - 1);
    remake(std::move(model));
    select(instance);
    say(fmt::format("{} stands beside it.", copy.name));
}

std::optional<Viewer::Flare> Viewer::flare() const
{
    if (!session_ || !state_.picture.flare || state_.camera.frozen ||
        light_.visibility.light_count() == 0) {
        return std::nullopt;
    }
    const glm::vec4 clip = shown_view().clip_from_world() * light_.light.position_world;
    if (clip.w <= 0.0f) {
        return std::nullopt;
    }
    return Flare{0.5f + 0.5f * glm::vec2{clip} / clip.w,
                 static_cast<float>(light_.visibility.brightness(0))};
}

} // namespace occlude::tools::viewer
