#include "model/scene_advice.h"

#include "model/focus.h"

#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <functional>
#include <ranges>
#include <span>

namespace occlude::tools {
namespace {

struct ObjectSize {
    uint32_t instance = 0;
    uint64_t triangles = 0;
    float reach = 0.0f; ///< size of its box, as a share of the scene's
    float fill = 1.0f;  ///< volume of its mesh's box
};

/// The quantities that a scene's objects are compared with.
struct Sizes {
    std::vector<ObjectSize> objects;
    uint64_t triangles = 0;
};

Aabb box_of(const Mesh& mesh)
{
    Aabb box;
    for (const MeshPart& part : mesh.parts) {
        box = merge(box, part.box);
    }
    return box;
}

Sizes measure_objects(const SceneModel& model)
{
    std::vector<Aabb> boxes;
    std::vector<float> fills;
    for (const Mesh& mesh : model.meshes) {
        boxes.push_back(box_of(mesh));
        fills.push_back(box_fill(mesh));
    }
    Sizes sizes;
    const float scene = glm::length(find_focus(model).box.extent());
    for (uint32_t i = 0; i < model.instances.size(); ++i) {
        const Instance& instance = model.instances[i];
        const Aabb box = transformed(instance.world_from_mesh, boxes[instance.mesh]);
        const float length = glm::length(box.extent());
        const uint64_t triangles = model.meshes[instance.mesh].indices.size() / 3;
        sizes.objects.push_back(
            {i, triangles, scene > 0.0f ? length / scene : 0.0f, fills[instance.mesh]});
        sizes.triangles += triangles;
    }
    return sizes;
}

std::string name_of(const SceneModel& model, const ObjectSize& object)
{
    const Instance& instance = model.instances[object.instance];
    const std::string& mesh = model.meshes[instance.mesh].name;
    return instance.name.empty() && !mesh.empty() ? mesh : object_name(model, object.instance);
}

/// Makes an advice about objects, of which the first are the worst.
Advice about(const SceneModel& model, std::string kind, std::span<const ObjectSize> objects)
{
    constexpr size_t kMostNames = 10;
    Advice advice{.kind = std::move(kind), .sentence = {}, .count = objects.size()};
    for (const ObjectSize& object : objects.first(std::min(objects.size(), kMostNames))) {
        advice.objects.push_back(name_of(model, object));
    }
    return advice;
}

/// "'wall', 'roof', 'floor' and 4 more".
std::string named(const Advice& advice)
{
    constexpr size_t kMostNames = 3;
    std::string text;
    const size_t shown = std::min(advice.objects.size(), kMostNames);
    for (size_t i = 0; i < shown; ++i) {
        text += fmt::format("{}'{}'", i > 0 ? ", " : "", advice.objects[i]);
    }
    return advice.count > shown ? fmt::format("{} and {} more", text, advice.count - shown) : text;
}

double percent(uint64_t part, uint64_t whole)
{
    return 100.0 * static_cast<double>(part) / static_cast<double>(std::max<uint64_t>(whole, 1));
}

template <class Keep>
std::vector<ObjectSize> objects_where(const Sizes& sizes, Keep&& keep)
{
    std::vector<ObjectSize> kept;
    std::ranges::copy_if(sizes.objects, std::back_inserter(kept), keep);
    return kept;
}

void advise_on_large_objects(const SceneModel& model, const Sizes& sizes, uint32_t item_triangles,
                             std::vector<Advice>& out)
{
    constexpr double kMost = 60.0;      // percent of the triangles
    constexpr float kThrough = 0.5f;    // of the scene
    constexpr float kLong = 0.25f;      // of the scene
    constexpr uint64_t kHeavyItems = 4; // pieces of item_triangles
    constexpr size_t kFew = 16;         // objects
    const uint64_t heavy = kHeavyItems * uint64_t{std::max(item_triangles, 1u)};
    std::vector<ObjectSize> large = objects_where(sizes, [&](const ObjectSize& object) {
        return object.triangles >= heavy && object.reach > kLong;
    });
    std::ranges::stable_sort(large, std::greater{}, &ObjectSize::triangles);
    const bool one = !large.empty() && large.front().reach > kThrough &&
                     percent(large.front().triangles, sizes.triangles) > kMost;
    if (one) {
        Advice advice = about(model, "one_mesh", std::span{large}.first(1));
        advice.sentence = fmt::format(
            "{} holds {:.0f}% of the triangles and reaches through the whole scene. Drawn with one "
            "call it is always seen, and culling saves nothing of it. Cut it by rooms, blocks or a "
            "grid, and draw the pieces apart. (This program has cut it into {} items; "
            "--item-triangles.)",
            named(advice), percent(large.front().triangles, sizes.triangles),
            model.meshes[model.instances[large.front().instance].mesh].parts.size());
        out.push_back(std::move(advice));
        large.erase(large.begin());
    }
    if (!large.empty()) {
        Advice advice = about(model, "large_objects", large);
        advice.sentence = fmt::format(
            "{} objects have {} triangles or more each and are longer than a quarter of the scene: "
            "{}. They are seen from nearly everywhere. Cut them into pieces of about {} triangles, "
            "as this program does, and draw the pieces apart.",
            advice.count, heavy, named(advice), item_triangles);
        out.push_back(std::move(advice));
    }
    if (!one && model.instances.size() < kFew && sizes.triangles >= heavy) {
        std::vector<ObjectSize> all = sizes.objects;
        std::ranges::stable_sort(all, std::greater{}, &ObjectSize::triangles);
        Advice advice = about(model, "few_objects", all);
        advice.sentence = fmt::format(
            "The scene is {} objects: {}. Culling leaves out whole objects, so there is little to "
            "leave out. Export what can hide apart from what it hides (a house, a tree, a machine "
            "each as an object of its own).",
            advice.count, named(advice));
        out.push_back(std::move(advice));
    }
}

void advise_on_small_objects(const SceneModel& model, const Sizes& sizes, std::vector<Advice>& out)
{
    constexpr uint64_t kSmall = 64; // triangles: drawn in the time of a box test
    constexpr size_t kMany = 1000;  // objects
    std::vector<ObjectSize> tiny =
        objects_where(sizes, [](const ObjectSize& object) { return object.triangles < kSmall; });
    if (tiny.size() < kMany || 2 * tiny.size() < sizes.objects.size()) {
        return;
    }
    std::ranges::stable_sort(tiny, {}, &ObjectSize::triangles);
    Advice advice = about(model, "small_objects", tiny);
    advice.sentence = fmt::format(
        "{} of {} objects have fewer than {} triangles, such as {}. A draw call for each costs "
        "more "
        "than its triangles, and so does a test. Merge neighbours of one material into objects of "
        "about 1,000 triangles; where they must stay apart, let the hierarchy test them in groups "
        "(--leaf-triangles).",
        advice.count, sizes.objects.size(), kSmall, named(advice));
    out.push_back(std::move(advice));
}

void advise_on_empty_boxes(const SceneModel& model, const Sizes& sizes, std::vector<Advice>& out)
{
    constexpr float kNearlyEmpty = 0.15f;
    constexpr float kNoticed = 0.05f; // of the scene
    constexpr float kLong = 0.25f;
    constexpr double kShare = 5.0; // percent of the objects
    std::vector<ObjectSize> empty = objects_where(sizes, [](const ObjectSize& object) {
        return object.fill < kNearlyEmpty && object.reach > kNoticed;
    });
    const bool any_long =
        std::ranges::any_of(empty, [](const ObjectSize& object) { return object.reach > kLong; });
    if (empty.empty() || (!any_long && percent(empty.size(), sizes.objects.size()) < kShare)) {
        return;
    }
    std::ranges::stable_sort(empty, std::greater{}, &ObjectSize::reach);
    Advice advice = about(model, "empty_boxes", empty);
    advice.sentence = fmt::format(
        "{} objects fill less than {:.0f}% of their boxes: {}. Such a box is seen where its object "
        "is not, so the object is drawn though it is hidden. Split them along their length, turn "
        "their meshes so that the boxes fit, or give the items shapes of several boxes.",
        advice.count, 100.0f * kNearlyEmpty, named(advice));
    out.push_back(std::move(advice));
}

void advise_on_materials(const SceneModel& model, const Sizes& sizes, std::vector<Advice>& out)
{
    constexpr double kShare = 20.0; // percent of the triangles
    std::vector<ObjectSize> clear = objects_where(sizes, [&](const ObjectSize& object) {
        return model.instances[object.instance].translucent();
    });
    uint64_t triangles = 0;
    for (const ObjectSize& object : clear) {
        triangles += object.triangles;
    }
    if (percent(triangles, sizes.triangles) < kShare) {
        return;
    }
    std::ranges::stable_sort(clear, std::greater{}, &ObjectSize::reach);
    Advice advice = about(model, "see_through", clear);
    advice.sentence = fmt::format(
        "{} objects with {:.0f}% of the triangles have materials that let light through, so they "
        "hide nothing: {}. Give those that are solid an opaque material.",
        advice.count, percent(triangles, sizes.triangles), named(advice));
    out.push_back(std::move(advice));
}

} // namespace

float box_fill(const Mesh& mesh)
{
    glm::dvec3 area{0.0}; // of the triangles, seen along each axis
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        const glm::dvec3 a{mesh.positions[mesh.indices[i]]};
        const glm::dvec3 b{mesh.positions[mesh.indices[i + 1]]};
        const glm::dvec3 c{mesh.positions[mesh.indices[i + 2]]};
        area += 0.5 * glm::abs(glm::cross(b - a, c - a));
    }
    const glm::dvec3 size{box_of(mesh).extent()};
    double most = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double face = size[(axis + 1) % 3] * size[(axis + 2) % 3];
        most = face > 0.0 ? std::max(most, 0.5 * area[axis] / face) : most; // a solid: two layers
    }
    return static_cast<float>(std::min(most, 1.0));
}

std::vector<Advice> advise(const SceneModel& model, uint32_t item_triangles)
{
    const Sizes sizes = measure_objects(model);
    std::vector<Advice> advice;
    advise_on_large_objects(model, sizes, item_triangles, advice);
    advise_on_small_objects(model, sizes, advice);
    advise_on_empty_boxes(model, sizes, advice);
    advise_on_materials(model, sizes, advice);
    return advice;
}

} // namespace occlude::tools
