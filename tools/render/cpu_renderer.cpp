#include "render/cpu_renderer.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace occlude::tools {

namespace {

const glm::vec3 kTowardLight = glm::normalize(glm::vec3{0.4f, 0.8f, 0.45f});
constexpr float kAmbient = 0.35f;
constexpr glm::vec3 kBackground{0.76f, 0.80f, 0.85f};
// Lines along edges of the scene must not flicker: within this distance they win against depth.
constexpr double kLineBias = 0x1p-20;

uint32_t packed(const glm::vec3& color)
{
    const glm::vec3 bytes = glm::round(glm::clamp(color, 0.0f, 1.0f) * 255.0f);
    return 0xff000000u | static_cast<uint32_t>(bytes.x) | static_cast<uint32_t>(bytes.y) << 8 |
           static_cast<uint32_t>(bytes.z) << 16;
}

glm::vec3 unpacked(uint32_t pixel)
{
    return glm::vec3{static_cast<float>(pixel & 0xff), static_cast<float>(pixel >> 8 & 0xff),
                     static_cast<float>(pixel >> 16 & 0xff)} /
           255.0f;
}

std::string size_error(glm::ivec2 size)
{
    return "the CPU renderer's target is " + std::to_string(size.x) + "x" + std::to_string(size.y) +
           " pixels; choose a size from 1x1 to " + std::to_string(cpu::kMaxSide) + "x" +
           std::to_string(cpu::kMaxSide);
}

bool good_size(glm::ivec2 size)
{
    return size.x > 0 && size.y > 0 && size.x <= cpu::kMaxSide && size.y <= cpu::kMaxSide;
}

// The first item that draws something that does not exist, as a sentence; nothing if all are valid.
std::string first_broken_item(const SceneModel& model, std::span<const SceneModel::Item> items)
{
    for (size_t i = 0; i < items.size(); ++i) {
        const std::string name = "item " + std::to_string(i) + " of scene '" + model.name + "'";
        if (items[i].instance >= model.instances.size()) {
            return name + " draws instance " + std::to_string(items[i].instance) +
                   ", which does not exist; pass the items made from this scene";
        }
        const uint32_t mesh = model.instances[items[i].instance].mesh;
        if (mesh >= model.meshes.size() || items[i].part >= model.meshes[mesh].parts.size()) {
            return name + " draws part " + std::to_string(items[i].part) + " of mesh " +
                   std::to_string(mesh) +
                   ", which does not exist; pass the items made from this scene";
        }
        const MeshPart& part = model.meshes[mesh].parts[items[i].part];
        const size_t index_count = model.meshes[mesh].indices.size();
        if (part.first_index > index_count || part.index_count > index_count - part.first_index) {
            return name + " draws indices beyond the end of mesh " + std::to_string(mesh) +
                   "; its parts must cover its indices";
        }
    }
    return {};
}

} // namespace

CpuModelScene::CpuModelScene(const SceneModel& model, std::span<const SceneModel::Item> items)
    : model_(model)
    , items_(items.begin(), items.end())
{
    world_from_mesh_.reserve(model.instances.size());
    for (const Instance& instance : model.instances) {
        world_from_mesh_.push_back(instance.world_from_mesh);
    }
}

CpuItem CpuModelScene::item(ItemId item) const
{
    if (!item.valid() || item.value >= items_.size()) {
        return {};
    }
    const SceneModel::Item& drawn = items_[item.value];
    const Mesh& mesh = model_.meshes[model_.instances[drawn.instance].mesh];
    const MeshPart& part = mesh.parts[drawn.part];
    return {.positions = mesh.positions,
            .indices = std::span(mesh.indices).subspan(part.first_index, part.index_count),
            .world_from_mesh = world_from_mesh_[drawn.instance],
            .box = part.box,
            .translucent = model_.instances[items_[item.value].instance].translucent()};
}

void CpuModelScene::set_transforms(std::span<const glm::mat4> world_from_mesh)
{
    const size_t count = std::min(world_from_mesh.size(), world_from_mesh_.size());
    std::copy_n(world_from_mesh.begin(), count, world_from_mesh_.begin());
}

void CpuModelScene::set_items(std::span<const SceneModel::Item> items)
{
    const size_t count = std::min(items.size(), items_.size());
    std::copy_n(items.begin(), count, items_.begin());
}

std::array<glm::vec3, 3> CpuModelScene::triangle(ItemId item, uint32_t triangle) const
{
    const CpuItem drawn = this->item(item);
    std::array<glm::vec3, 3> corners;
    for (size_t i = 0; i < corners.size(); ++i) {
        const uint32_t index = drawn.indices[3 * size_t{triangle} + i];
        corners[i] = glm::vec3{drawn.world_from_mesh * glm::vec4{drawn.positions[index], 1.0f}};
    }
    return corners;
}

glm::vec3 CpuModelScene::color(ItemId item) const
{
    return model_.instances[items_[item.value].instance].color;
}

float CpuModelScene::opacity(ItemId item) const
{
    return model_.instances[items_[item.value].instance].opacity;
}

CpuRenderer::CpuRenderer(const SceneModel& model, std::span<const SceneModel::Item> items,
                         glm::ivec2 size)
    : scene_(model, items)
    , device_(scene_)
    , size_px_(size)
{
}

Result<bool> CpuRenderer::resize(glm::ivec2 size, int samples)
{
    if (samples > 1) {
        return Error{ErrorCode::unsupported, "the CPU renderer has one sample per pixel, not " +
                                                 std::to_string(samples) +
                                                 "; use --msaa 1 or --device gl"};
    }
    if (!good_size(size)) {
        return Error{ErrorCode::invalid_argument, size_error(size)};
    }
    size_px_ = size;
    return true;
}

void CpuRenderer::render(const View& view, std::span<const ItemId> items)
{
    device_.begin_frame(view);
    device_.draw(items, DrawPass::shade);
    device_.end_frame();
}

uint32_t CpuRenderer::shaded(const CpuDevice::Owner& owner) const
{
    if (!owner.item.valid()) {
        return packed(kBackground);
    }
    const std::array<glm::vec3, 3> corners = scene_.triangle(owner.item, owner.triangle);
    // Squares of squares of large edges would not fit a float. Scaling by a power of two rounds
    // nothing.
    const glm::vec3 first = corners[1] - corners[0];
    const glm::vec3 second = corners[2] - corners[0];
    const glm::vec3 sizes = glm::max(glm::abs(first), glm::abs(second));
    const float largest = std::max({sizes.x, sizes.y, sizes.z});
    const float scale = largest > 0.0f ? std::exp2(-std::floor(std::log2(largest))) : 1.0f;
    const glm::vec3 normal = glm::cross(scale * first, scale * second);
    const float length = glm::length(normal);
    const float cosine = length > 0.0f ? std::abs(glm::dot(normal, kTowardLight)) / length : 0.0f;
    const glm::vec3 base = owner.item.value < item_colors_.size()
                               ? glm::vec3{item_colors_[owner.item.value]}
                               : scene_.color(owner.item);
    return packed(base * (kAmbient + (1.0f - kAmbient) * cosine));
}

Capture CpuRenderer::capture()
{
    const bool drawn = device_.frame_count() > 0;
    Capture capture;
    capture.color.size = drawn ? device_.size_px() : size_px_;
    const size_t pixels =
        static_cast<size_t>(capture.color.size.x) * static_cast<size_t>(capture.color.size.y);
    capture.color.pixels.assign(pixels, packed(kBackground));
    capture.depth.assign(pixels, 1.0f);
    if (!drawn) {
        return capture;
    }
    std::copy(device_.depth().begin(), device_.depth().end(), capture.depth.begin());
    // Neighbours mostly show the same triangle: its colour is computed once per run.
    CpuDevice::Owner last;
    uint32_t last_color = packed(kBackground);
    for (size_t pixel = 0; pixel < pixels; ++pixel) {
        const CpuDevice::Owner owner = device_.owner(pixel);
        if (owner != last) {
            last = owner;
            last_color = shaded(owner);
        }
        capture.color.pixels[pixel] = last_color;
    }
    for (const CpuDevice::TranslucentFragment& fragment : device_.translucent_fragments()) {
        if (fragment.owner != last) {
            last = fragment.owner;
            last_color = shaded(fragment.owner);
        }
        uint32_t& pixel = capture.color.pixels[fragment.pixel];
        pixel = packed(
            glm::mix(unpacked(pixel), unpacked(last_color), scene_.opacity(fragment.owner.item)));
    }
    if (lines_frame_ == device_.frame_count()) {
        for (const LineFragment& line : lines_) {
            uint32_t& pixel = capture.color.pixels[line.pixel];
            pixel = packed(glm::mix(unpacked(pixel), line.color, line.alpha));
        }
    }
    return capture;
}

std::vector<uint32_t> CpuRenderer::render_ids(const View& view, std::span<const ItemId> items)
{
    if (!id_device_) {
        id_device_.emplace(scene_);
    }
    id_device_->begin_frame(view);
    id_device_->draw(items, DrawPass::shade);
    id_device_->end_frame();
    std::vector<uint32_t> ids(id_device_->depth().size());
    for (size_t pixel = 0; pixel < ids.size(); ++pixel) {
        ids[pixel] = id_device_->owner(pixel).item.value; // ItemId's invalid value is 0xffffffff
    }
    return ids;
}

void CpuRenderer::set_item_colors(std::span<const glm::vec4> colors)
{
    item_colors_.assign(colors.begin(), colors.end());
}

// One pixel per column or per row, whichever the line crosses more of.
void CpuRenderer::draw_line(glm::dvec4 a, glm::dvec4 b, glm::vec4 color, bool on_top)
{
    const glm::ivec2 size = device_.size_px();
    if (!cpu::clip_segment(a, b)) {
        return;
    }
    const glm::dvec3 half{0.5 * size.x, 0.5 * size.y, 0.0};
    const glm::dvec3 from =
        glm::dvec3{a.x / a.w, a.y / a.w, a.z / a.w} * glm::dvec3{half.x, half.y, 1.0} + half;
    const glm::dvec3 to =
        glm::dvec3{b.x / b.w, b.y / b.w, b.z / b.w} * glm::dvec3{half.x, half.y, 1.0} + half;
    const double length = std::max(std::abs(to.x - from.x), std::abs(to.y - from.y));
    const int steps = std::max(static_cast<int>(std::ceil(length)), 1);
    for (int step = 0; step <= steps; ++step) {
        const glm::dvec3 point = glm::mix(from, to, static_cast<double>(step) / steps);
        const int x = std::clamp(static_cast<int>(point.x), 0, size.x - 1);
        const int y = std::clamp(static_cast<int>(point.y), 0, size.y - 1);
        const size_t pixel =
            static_cast<size_t>(y) * static_cast<size_t>(size.x) + static_cast<size_t>(x);
        const bool again = !lines_.empty() && step > 0 && lines_.back().pixel == pixel;
        const bool seen = on_top || point.z - kLineBias <= double{device_.depth()[pixel]};
        if (seen && !again) {
            lines_.push_back({pixel, glm::vec3{color}, color.a});
        }
    }
}

void CpuRenderer::draw_lines(const View& view, std::span<const glm::vec3> points, glm::vec4 color,
                             bool on_top)
{
    const cpu::ScreenTransform transform(view);
    if (!transform.usable() || view.size_px() != device_.size_px()) {
        return; // no frame of this size to draw over
    }
    if (lines_frame_ != device_.frame_count()) {
        lines_.clear();
        lines_frame_ = device_.frame_count();
    }
    for (size_t i = 0; i + 1 < points.size(); i += 2) {
        draw_line(transform.clip_from_world() * glm::dvec4{glm::dvec3{points[i]}, 1.0},
                  transform.clip_from_world() * glm::dvec4{glm::dvec3{points[i + 1]}, 1.0}, color,
                  on_top);
    }
}

void CpuRenderer::update_transforms(std::span<const glm::mat4> world_from_mesh)
{
    scene_.set_transforms(world_from_mesh);
}

void CpuRenderer::update_items(std::span<const SceneModel::Item> items)
{
    scene_.set_items(items);
}

Result<std::unique_ptr<SceneRenderer>>
make_cpu_renderer(const SceneModel& model, std::span<const SceneModel::Item> items, glm::ivec2 size)
{
    if (!good_size(size)) {
        return Error{ErrorCode::invalid_argument, size_error(size)};
    }
    if (const std::string problem = first_broken_item(model, items); !problem.empty()) {
        return Error{ErrorCode::bad_data, problem};
    }
    return std::unique_ptr<SceneRenderer>{std::make_unique<CpuRenderer>(model, items, size)};
}

} // namespace occlude::tools
