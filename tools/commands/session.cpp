#include "commands/session.h"

#include "scenes/exact_split.h"

#include <occlude/hierarchy/hierarchy_kinds.h>

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>

namespace occlude::tools {

static constexpr std::string_view kTwoLevel = "two_level";

static SceneOptions scene_options(const StageOptions& options)
{
    SceneOptions scene{.item_triangles = options.item_triangles};
    if (options.split == "exact") {
        scene.split = SceneOptions::Split::exact;
        scene.cache_folder = options.cache_folder ? std::filesystem::path{*options.cache_folder}
                                                  : default_cache_folder();
    }
    return scene;
}

static std::optional<TestMethod> test_method(std::string_view name)
{
    constexpr std::pair<std::string_view, TestMethod> kMethods[] = {
        {"queries", TestMethod::queries},
        {"raster", TestMethod::raster},
        {"pyramid", TestMethod::pyramid}};
    const auto found = std::ranges::find(kMethods, name, [](const auto& m) { return m.first; });
    return found == std::end(kMethods) ? std::nullopt : std::optional{found->second};
}

Result<bool> check_stage_options(const StageOptions& options)
{
    const auto unknown = [](std::string_view option, std::string_view value,
                            std::string_view choices) {
        return Error{ErrorCode::unsupported,
                     fmt::format("{}: '{}' is not available in this version; choose {}", option,
                                 value, choices)};
    };
    if (find_hierarchy_kind(options.hierarchy) == nullptr) {
        return unknown("--hierarchy", options.hierarchy, hierarchy_names());
    }
    if (!test_method(options.test)) {
        return unknown("--test", options.test, "queries, raster or pyramid");
    }
    if (options.split != "centroid" && options.split != "exact") {
        return unknown("--split", options.split, "centroid or exact");
    }
    if (options.device && *options.device != "gl" && *options.device != "cpu") {
        return unknown("--device", *options.device, "gl or cpu");
    }
    if (options.device == "cpu" && options.samples > 1) {
        return Error{ErrorCode::unsupported,
                     fmt::format("--msaa {}: the cpu device draws one sample per pixel; leave "
                                 "--msaa away or choose --device gl",
                                 options.samples)};
    }
    return true;
}

Session::Session(SceneModel model, const StageOptions& options)
    : options_(options)
    , model_(std::move(model))
    , scene_(make_cull_scene(model_))
{
    if (options.hierarchy == kTwoLevel) { // knows of objects, not only of items
        two_level_ = std::make_unique<TwoLevelScene>(two_level_options());
        two_level_->sync(scene_.scene);
    } else {
        hierarchy_ = build(scene_.scene.item_bounds());
    }
}

TwoLevelOptions Session::two_level_options() const
{
    return {.leaf_triangles = options_.leaf_triangles};
}

void Session::make_motion()
{
    if (model_.motion.empty()) {
        return;
    }
    if (two_level_) {
        moving_tree_ = std::make_unique<RelinkedTree>(*two_level_, two_level_options());
    } else {
        moving_tree_ = std::make_unique<RefittedTree>(hierarchy_, scene_.scene,
                                                      [this](auto items) { return build(items); });
    }
    motion_ = std::make_unique<MotionPlayer>(model_, scene_, *moving_tree_, *renderer_);
}

Hierarchy Session::build(std::span<const ItemBounds> items) const
{
    return find_hierarchy_kind(options_.hierarchy)->build(items, options_.leaf_triangles);
}

Stage Session::stage()
{
    Stage stage{hierarchy(), scene_.scene.item_bounds(), *renderer_};
    if (motion_) {
        stage.go_to = [this](size_t frame) { motion_->go_to(frame); };
    }
    return stage;
}

// Tells the device how to test; an error names the option.
Result<bool> Session::choose_test()
{
    const auto chosen = renderer_->use_test_method(*test_method(options_.test));
    if (!chosen) {
        return Error{chosen.error().code,
                     fmt::format("--test {}: {}", options_.test, chosen.error().message)};
    }
    return true;
}

Result<bool> Session::make_renderer(std::ostream& notes)
{
    device_name_ = options_.device.value_or("gl");
    if (device_name_ == "gl") {
        auto renderer = make_gl_renderer(model_, scene_.items, options_.size, options_.samples);
        if (renderer) {
            renderer_ = std::move(*renderer);
            return choose_test();
        }
        if (options_.device || options_.samples > 1) {
            return renderer.error();
        }
        notes << "occlude: no OpenGL here (" << renderer.error().message
              << "); drawing on the CPU instead, as --device cpu does, which is much slower\n";
        device_name_ = "cpu";
    }
    auto renderer = make_cpu_renderer(model_, scene_.items, options_.size);
    if (!renderer) {
        return renderer.error();
    }
    renderer_ = std::move(*renderer);
    return choose_test();
}

Result<std::unique_ptr<Session>> Session::open(const std::string& scene,
                                               const StageOptions& options, std::ostream& notes)
{
    if (const auto checked = check_stage_options(options); !checked) {
        return checked.error();
    }
    auto model = load_scene(scene, scene_options(options));
    if (!model) {
        return model.error();
    }
    if (drawn_triangles(*model) == 0) {
        return Error{ErrorCode::bad_data,
                     fmt::format("scene '{}' is empty: it holds no triangle; choose another file, "
                                 "or a scene of 'occlude list scenes'",
                                 scene)};
    }
    std::unique_ptr<Session> session{new Session{std::move(*model), options}};
    if (const auto made = session->make_renderer(notes); !made) {
        return made.error();
    }
    session->make_motion();
    return session;
}

Result<std::vector<Camera>> Session::cameras(const std::string& path) const
{
    auto cameras = load_path(path, model_, options_.frames);
    if (!cameras) {
        return cameras.error();
    }
    if (cameras->empty()) {
        return Error{ErrorCode::bad_data,
                     fmt::format("path '{}' has no frames; give it at least one, or choose a path "
                                 "of 'occlude list paths'",
                                 path)};
    }
    choose_depth_range(*cameras, model_);
    return cameras;
}

Result<std::vector<View>> Session::views(const std::string& path) const
{
    const auto path_cameras = cameras(path);
    if (!path_cameras) {
        return path_cameras.error();
    }
    std::vector<View> views;
    views.reserve(path_cameras->size());
    for (const Camera& camera : *path_cameras) {
        views.push_back(make_view(camera, options_.size));
    }
    return views;
}

} // namespace occlude::tools
