#include "load/finish_scene.h"

#include "load/clean_mesh.h"
#include "load/duplicates.h"
#include "load/load_progress.h"
#include "load/scene_colors.h"
#include "load/scene_measures.h"
#include "load/scene_origin.h"
#include "model/focus.h"
#include "model/mesh_tools.h"

#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <string_view>

namespace occlude::tools {
namespace {

constexpr uint32_t kNoMesh = 0xffffffffu;

const LoadedMaterial* material_of(const LoadedScene& scene, const LoadedMesh& mesh)
{
    return mesh.material < scene.materials.size() ? &scene.materials[mesh.material] : nullptr;
}

Instance instance_of(const LoadedScene& scene, const LoadedInstance& source, uint32_t mesh,
                     std::string_view mesh_name)
{
    constexpr float kLeastGlass = 0.25f; // so that one sees where panes are
    const LoadedMesh& loaded = scene.meshes[source.mesh];
    Instance instance{.name = source.name,
                      .mesh = mesh,
                      .world_from_mesh = glm::mat4{source.world_from_mesh},
                      .color = color_of(scene, loaded.material, mesh_name)};
    if (const LoadedMaterial* material = material_of(scene, loaded)) {
        const float opacity = std::clamp(material->opacity, 0.0f, 1.0f);
        instance.see_through = material->surface != Surface::opaque;
        instance.opacity =
            material->surface == Surface::transmissive ? std::max(opacity, kLeastGlass) : opacity;
    }
    return instance;
}

bool is_usable(const Aabb& box)
{
    return box.is_bounded() && std::max({glm::length(box.min), glm::length(box.max)}) < 1e18f;
}

class Finisher {
public:
    Finisher(LoadedScene loaded, const std::string& file, const SceneOptions& options)
        : loaded_(std::move(loaded))
        , file_(file)
        , options_(options)
    {
    }
    Result<SceneModel> finish();

private:
    bool is_opaque(const LoadedMesh& mesh) const;
    void clean_meshes();
    void add_instances();
    void drop_duplicates();
    void choose_origin();
    void move_to(const glm::dvec3& origin);
    void choose_axis_and_unit();
    void add_cameras();
    void describe_losses();
    void describe_materials();
    Error nothing_left() const;

    LoadedScene loaded_;
    std::string file_;
    const SceneOptions& options_;
    SceneModel model_;
    std::vector<uint32_t> mesh_of_;             ///< by mesh of loaded_
    std::vector<uint64_t> triangles_in_file_;   ///< by mesh of loaded_
    std::vector<const LoadedInstance*> placed_; ///< by instance of model_
    uint64_t misplaced_ = 0;
};

bool Finisher::is_opaque(const LoadedMesh& mesh) const
{
    const LoadedMaterial* material = material_of(loaded_, mesh);
    return material == nullptr || material->surface == Surface::opaque;
}

void Finisher::clean_meshes()
{
    std::vector<Mesh> meshes(loaded_.meshes.size());
    uint64_t all = 0;
    for (const LoadedMesh& mesh : loaded_.meshes) {
        all += mesh.indices.size() / 3;
    }
    LoadProgress progress{options_.progress, kReadShare, kCleanShare, all};
    oneapi::tbb::parallel_for(size_t{0}, meshes.size(), [&](size_t i) {
        LoadedMesh& source = loaded_.meshes[i];
        const size_t triangles = source.indices.size() / 3;
        meshes[i] = clean_mesh(source, is_opaque(source) ? Repeats::drop : Repeats::keep);
        if (!meshes[i].indices.empty()) {
            partition_mesh(meshes[i], std::max(options_.item_triangles, 1u));
        }
        progress.advance(triangles);
    });
    mesh_of_.assign(meshes.size(), kNoMesh);
    for (size_t i = 0; i < meshes.size(); ++i) {
        const LoadedMesh& source = loaded_.meshes[i];
        const uint64_t dropped = is_opaque(source) ? source.repeated : 0;
        triangles_in_file_.push_back(meshes[i].indices.size() / 3 + source.left_out.triangles() +
                                     dropped);
        if (!meshes[i].indices.empty()) {
            mesh_of_[i] = static_cast<uint32_t>(model_.meshes.size());
            model_.meshes.push_back(std::move(meshes[i]));
        }
    }
}

void Finisher::add_instances()
{
    for (const LoadedInstance& source : loaded_.instances) {
        model_.file_triangles += triangles_in_file_[source.mesh];
        const uint32_t mesh = mesh_of_[source.mesh];
        if (mesh == kNoMesh) {
            continue;
        }
        Instance instance = instance_of(loaded_, source, mesh, model_.meshes[mesh].name);
        if (is_usable(world_box(model_, instance))) {
            model_.instances.push_back(std::move(instance));
            placed_.push_back(&source);
        } else {
            ++misplaced_;
        }
    }
}

void Finisher::drop_duplicates()
{
    const Duplicates found = find_duplicates(model_, placed_);
    if (found.other_color_count > 0) {
        model_.load_notes.push_back(
            fmt::format("{} objects stand exactly where an object of the same shape and another "
                        "colour does: all are drawn, and which one is seen depends on the order",
                        found.other_color_count));
    }
    if (found.unseen_count == 0) {
        return;
    }
    model_.load_notes.push_back(
        fmt::format("{} objects stand exactly where an equal one does: each is drawn once",
                    found.unseen_count));
    size_t kept = 0;
    for (size_t i = 0; i < placed_.size(); ++i) {
        if (!found.unseen[i]) {
            if (kept != i) {
                model_.instances[kept] = std::move(model_.instances[i]);
            }
            placed_[kept++] = placed_[i];
        }
    }
    model_.instances.resize(kept);
    placed_.resize(kept);
}

void Finisher::choose_origin()
{
    if (options_.origin) {
        move_to(*options_.origin);
    } else {
        // Boxes are in single precision: far away the first step leads only near.
        constexpr int kMostSteps = 3;
        glm::dvec3 way = way_to_bulk(model_);
        for (int i = 0; i < kMostSteps && way != glm::dvec3{0.0}; ++i) {
            move_to(model_.origin + way);
            way = way_to_bulk(model_);
        }
    }
    const glm::dvec3& origin = model_.origin;
    if (origin != glm::dvec3{0.0}) {
        model_.load_notes.push_back(fmt::format(
            "moved by ({:.10g}, {:.10g}, {:.10g}), {}", 0.0 - origin.x, 0.0 - origin.y,
            0.0 - origin.z,
            options_.origin ? "as --origin says"
                            : "because it lies far from its origin; path files stay in the "
                              "coordinates of the file (--origin 0,0,0 leaves it there)"));
    }
}

/// Puts the point of the file's coordinates at zero.
void Finisher::move_to(const glm::dvec3& origin)
{
    if (origin == model_.origin) {
        return;
    }
    for (size_t i = 0; i < placed_.size(); ++i) {
        glm::dmat4 moved = placed_[i]->world_from_mesh;
        moved[3] -= glm::dvec4{origin, 0.0};
        model_.instances[i].world_from_mesh = glm::mat4{moved};
    }
    model_.origin = origin;
}

void Finisher::choose_axis_and_unit()
{
    const auto axis_name = [](const glm::vec3& up) {
        const int axis = std::abs(up.x) > 0.5f ? 0 : std::abs(up.y) > 0.5f ? 1 : 2;
        return fmt::format("{}{}", up[axis] < 0.0f ? '-' : '+', "xyz"[axis]);
    };
    const std::optional<glm::vec3> up = options_.up ? options_.up : loaded_.up;
    model_.up = up ? *up : guess_up(model_);
    const char* why_up = options_.up  ? "as --up says"
                         : loaded_.up ? "as its format says"
                                      : "guessed by its level surfaces";
    UnitGuess unit{1.0f, {}};
    if (options_.units_per_metre) {
        unit = {*options_.units_per_metre, "as --unit says"};
    } else if (loaded_.units_per_metre) {
        unit = {*loaded_.units_per_metre, "as the file says"};
    } else {
        unit =
            guess_unit(model_, loaded_.format_is_metric ? UnitSource::metres : UnitSource::unknown);
    }
    model_.unit = unit.units_per_metre;
    model_.load_notes.push_back(fmt::format("{:g} units a metre ({}; --unit), up is {} ({}; --up)",
                                            model_.unit, unit.reason, axis_name(model_.up),
                                            why_up));
}

void Finisher::add_cameras()
{
    for (const LoadedCamera& source : loaded_.cameras) {
        Camera camera;
        camera.eye = glm::vec3{source.eye - model_.origin};
        camera.target =
            glm::vec3{source.eye - model_.origin +
                      source.forward * std::max(1.0, glm::length(source.eye - model_.origin))};
        camera.up = glm::vec3{source.up};
        camera.fov_y = source.fov_y;
        camera.near = source.near;
        camera.far = source.far > source.near ? source.far : 0.0f;
        std::string name = "camera:" + source.name;
        const auto taken = [&](const std::string& wanted) {
            return std::any_of(
                model_.paths.begin(), model_.paths.end(),
                [&](const SceneModel::NamedPath& path) { return path.name == wanted; });
        };
        for (int copy = 2; taken(name); ++copy) {
            name = fmt::format("camera:{}#{}", source.name, copy);
        }
        model_.paths.push_back({std::move(name), {{0.0f, camera, false}}});
    }
}

void Finisher::describe_losses()
{
    LeftOut sum;
    uint64_t dropped = 0;
    uint64_t drawn_again = 0;
    for (const LoadedMesh& mesh : loaded_.meshes) {
        sum += mesh.left_out;
        (is_opaque(mesh) ? dropped : drawn_again) += mesh.repeated;
        drawn_again += mesh.backs;
    }
    if (dropped > 0) {
        model_.load_notes.push_back(fmt::format(
            "{} triangles repeat another one of their mesh: each is drawn once", dropped));
    }
    if (drawn_again > 0) {
        model_.load_notes.push_back(fmt::format(
            "{} triangles are the back of another one of their mesh, or repeat one that "
            "hides nothing: they are drawn, too",
            drawn_again));
    }
    const auto say = [&](uint64_t count, const char* what) {
        if (count > 0) {
            model_.load_losses.push_back(fmt::format("{} {}", count, what));
        }
    };
    say(sum.points, "points: only triangles are drawn");
    say(sum.lines, "lines: only triangles are drawn");
    say(sum.degenerate, "triangles without area: two of their corners are the same point");
    say(sum.non_finite, "triangles with a corner that is not a finite number below 1e15");
    say(sum.masked_away, "triangles that their material's alpha mask leaves nothing of");
    say(misplaced_, "objects whose transform puts them at no finite place");
}

void Finisher::describe_materials()
{
    uint64_t objects[4] = {};
    for (const LoadedInstance* placed : placed_) {
        const LoadedMaterial* material = material_of(loaded_, loaded_.meshes[placed->mesh]);
        ++objects[static_cast<size_t>(material != nullptr ? material->surface : Surface::opaque)];
    }
    const auto say = [&](Surface surface, const char* what) {
        const auto count = std::count_if(
            loaded_.materials.begin(), loaded_.materials.end(),
            [&](const LoadedMaterial& material) { return material.surface == surface; });
        if (objects[static_cast<size_t>(surface)] > 0) {
            model_.load_notes.push_back(fmt::format("{} objects of {} {} materials hide nothing",
                                                    objects[static_cast<size_t>(surface)], count,
                                                    what));
        }
    };
    say(Surface::masked, "alpha-masked");
    say(Surface::blended, "blended");
    say(Surface::transmissive, "transmissive");
}

Error Finisher::nothing_left() const
{
    const std::string reasons = fmt::format("{}", fmt::join(model_.load_losses, "; "));
    const uint64_t nowhere = std::accumulate(
        loaded_.meshes.begin(), loaded_.meshes.end(), misplaced_,
        [](uint64_t sum, const LoadedMesh& mesh) { return sum + mesh.left_out.non_finite; });
    return {ErrorCode::bad_data,
            fmt::format("{}: has no triangles to draw ({}); export it {}", file_,
                        reasons.empty() ? "it holds none" : "left out: " + reasons,
                        nowhere > 0 ? "again with finite coordinates" : "with its surfaces")};
}

Result<SceneModel> Finisher::finish()
{
    model_.name = std::filesystem::path(file_).stem().string();
    clean_meshes();
    add_instances();
    describe_losses();
    if (model_.instances.empty()) {
        return nothing_left();
    }
    drop_duplicates();
    choose_origin();
    if (options_.origin && !has_shape(model_)) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("{}: --origin leaves it so far away that single precision cannot "
                                 "tell its corners apart; omit it, or give a point near the scene",
                                 file_)};
    }
    choose_axis_and_unit();
    describe_materials();
    add_cameras();
    if (const Focus focus = find_focus(model_); focus.left_out > 0) {
        model_.load_notes.push_back(fmt::format("{} of {} objects stand far away from the others; "
                                                "the built-in paths look at the others",
                                                focus.left_out, model_.instances.size()));
    }
    model_.load_notes.insert(model_.load_notes.end(), loaded_.notes.begin(), loaded_.notes.end());
    return std::move(model_);
}

} // namespace

Result<SceneModel> finish_scene(LoadedScene loaded, const std::string& file,
                                const SceneOptions& options)
{
    return Finisher{std::move(loaded), file, options}.finish();
}

} // namespace occlude::tools
