#include "session/session.h"

#include "generate/scene_source.h"
#include "measure/timing_device.h"
#include "model/exact_split.h"
#include "model/scene_options.h"
#include "render/cpu_fast_renderer.h"
#include "render/gl_renderer.h"
#include "walk/paths.h"

#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <fmt/format.h>

#include <optional>
#include <ostream>
#include <string_view>
#include <utility>

namespace occlude::tools {

static constexpr std::string_view kTwoLevel = "two_level";

// check_stage_options() has checked them.
static SceneOptions scene_options(const StageOptions& options)
{
    SceneOptions scene = *parse_file_options(options.file);
    scene.item_triangles = options.item_triangles;
    scene.cache_folder = options.cache_folder ? std::filesystem::path{*options.cache_folder}
                                              : default_cache_folder();
    scene.split = options.split == "exact" ? SceneOptions::Split::exact : scene.split;
    return scene;
}

static std::optional<TestMethod> test_method(std::string_view text)
{
    for (const TestMethod method : {TestMethod::queries, TestMethod::raster, TestMethod::pyramid}) {
        if (text == name(method)) {
            return method;
        }
    }
    return std::nullopt;
}

static Error unknown(std::string_view option, std::string_view value, std::string_view choices)
{
    return {ErrorCode::unsupported,
            fmt::format("{}: '{}' is not available in this version; choose {}", option, value,
                        choices)};
}

Result<bool> check_stage_options(const StageOptions& options)
{
    if (const auto trees = choose_hierarchies(options.hierarchy, options.sets); !trees) {
        return trees.error();
    }
    if (const auto file = parse_file_options(options.file); !file) {
        return file.error();
    }
    if (!test_method(options.test)) {
        return unknown("--test", options.test, "queries, raster or pyramid");
    }
    if (options.split != "centroid" && options.split != "exact") {
        return unknown("--split", options.split, "centroid or exact");
    }
    const std::string device = options.device.value_or("gl");
    if (device != "gl" && device != "cpu" && device != "cpu_fast") {
        return unknown("--device", device, "gl, cpu or cpu_fast");
    }
    if (options.device == "cpu" && options.samples > 1) {
        return Error{ErrorCode::unsupported,
                     fmt::format("--msaa {}: the cpu device draws one sample per pixel; omit "
                                 "--msaa or choose --device gl",
                                 options.samples)};
    }
    return true;
}

Result<bool> check_one_hierarchy(const StageOptions& options)
{
    if (const auto checked = check_stage_options(options); !checked) {
        return checked.error();
    }
    if (choose_hierarchies(options.hierarchy, options.sets)->size() > 1) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--hierarchy: '{}' is more than one, and only bench and verify "
                                 "take several; choose from: {}",
                                 options.hierarchy, hierarchy_names())};
    }
    return true;
}

std::string load_summary(const SceneModel& model)
{
    if (model.file_triangles == 0) {
        return {};
    }
    std::string text;
    for (const std::string& note : model.load_notes) {
        text += fmt::format("  {:<17} {}\n", text.empty() ? "assumed" : "", note);
    }
    const char* heading = "left out";
    for (const std::string& loss : model.load_losses) {
        text += fmt::format("  {:<17} {}\n", heading, loss);
        heading = "";
    }
    return text;
}

std::optional<Error> left_out_error(const std::string& scene, const SceneModel& model)
{
    if (model.load_losses.empty()) {
        return std::nullopt;
    }
    return Error{ErrorCode::bad_data,
                 fmt::format("{}: --strict: the file has parts that cannot be drawn: {}; omit "
                             "--strict, or export it without",
                             scene, fmt::join(model.load_losses, "; "))};
}

Session::Session(SceneModel model, const StageOptions& options,
                 std::span<const HierarchyChoice> trees, const LoadingCallback& loading)
    : options_(options)
    , model_(std::move(model))
    , scene_(make_cull_scene(model_))
{
    const SecondsClock clock = steady_seconds_clock();
    const double start = clock();
    build_trees(trees, loading);
    preparation_.hierarchy_seconds = clock() - start;
    preparation_.uncut_triangles = model_.uncut_triangles;
}

void Session::build_trees(std::span<const HierarchyChoice> choices, const LoadingCallback& loading)
{
    trees_.clear();
    for (const HierarchyChoice& choice : choices) {
        if (loading) {
            loading(choices.size() > 1 ? "building the trees" : "building the tree",
                    static_cast<double>(trees_.size()) / static_cast<double>(choices.size()));
        }
        auto tree = std::make_unique<Tree>();
        tree->choice = choice;
        if (choice.kind == kTwoLevel) { // knows objects, not only items
            tree->two_level = std::make_unique<TwoLevelScene>(options_of_two_level(choice));
            tree->two_level->sync(scene_.scene);
        } else {
            tree->flat = build(choice, scene_.scene.item_bounds());
        }
        trees_.push_back(std::move(tree));
    }
}

Result<bool> Session::use_hierarchies(const std::string& text, const std::vector<std::string>& sets)
{
    const auto choices = choose_hierarchies(text, sets);
    if (!choices) {
        return choices.error();
    }
    options_.hierarchy = text;
    options_.sets = sets;
    motion_.reset();
    moving_trees_.reset();
    scene_ = make_cull_scene(model_); // a motion begins with every object in its place
    build_trees(*choices);
    renderer_->update_items(scene_.items);
    make_motion();
    return true;
}

Result<bool> Session::use_test(const std::string& method)
{
    const auto known = test_method(method);
    if (!known) {
        return unknown("--test", method, "queries, raster or pyramid");
    }
    const std::string before = std::exchange(options_.test, method);
    auto chosen = choose_test();
    if (!chosen) {
        options_.test = before;
    }
    return chosen;
}

Result<bool> Session::resize(glm::ivec2 size)
{
    auto resized = renderer_->resize(size, options_.samples);
    if (resized) {
        options_.size = size;
    }
    return resized;
}

SceneModel& Session::editable_model()
{
    if (model_.motion.empty()) {
        model_.motion.box = world_bounds(model_);
        model_.motion.instances.resize(model_.instances.size());
        make_motion();
    }
    return model_;
}

Preparation Session::preparation() const
{
    Preparation preparation = preparation_;
    if (motion_) {
        preparation.tree_update_ms = motion_->tree_update_ms();
    }
    return preparation;
}

const Hierarchy* Session::tree(std::string_view label) const
{
    for (const auto& tree : trees_) {
        if (tree->choice.label == label) {
            return &tree->hierarchy();
        }
    }
    return nullptr;
}

std::vector<std::string> Session::tree_labels() const
{
    std::vector<std::string> labels;
    for (const auto& tree : trees_) {
        labels.push_back(tree->choice.label);
    }
    return labels;
}

// choose_hierarchies() has checked the options, here and in build().
TwoLevelOptions Session::options_of_two_level(const HierarchyChoice& choice) const
{
    return *two_level_options(options_.leaf_triangles, choice.options);
}

void Session::make_motion()
{
    if (model_.motion.empty()) {
        return;
    }
    std::vector<std::unique_ptr<MovingTree>> moving;
    for (const auto& tree : trees_) {
        moving.push_back(make_moving(*tree));
    }
    moving_trees_ = std::make_unique<MovingTrees>(std::move(moving));
    motion_ = std::make_unique<MotionPlayer>(model_, scene_, *moving_trees_, *renderer_);
}

std::unique_ptr<MovingTree> Session::make_moving(Tree& tree) const
{
    if (tree.two_level) {
        return std::make_unique<RelinkedTree>(*tree.two_level, options_of_two_level(tree.choice));
    }
    return std::make_unique<RefittedTree>(
        tree.flat, scene_.scene,
        [this, &choice = tree.choice](auto items) { return build(choice, items); });
}

Hierarchy Session::build(const HierarchyChoice& choice, std::span<const ItemBounds> items) const
{
    Hierarchy hierarchy = *find_hierarchy_kind(choice.kind)
                               ->build_with(items, options_.leaf_triangles, choice.options);
    hierarchy.set_shapes(&scene_.scene.shapes());
    return hierarchy;
}

Stage Session::stage()
{
    Stage stage{hierarchy(), scene_.scene.item_bounds(), *renderer_};
    if (motion_) {
        stage.go_to = [this](size_t frame) { motion_->go_to(frame); };
    }
    return stage;
}

// Sets the test method of the device; an error names the option.
Result<bool> Session::choose_test()
{
    const auto chosen = renderer_->use_test_method(*test_method(options_.test));
    if (!chosen) {
        return Error{chosen.error().code,
                     fmt::format("--test {}: {}", options_.test, chosen.error().message)};
    }
    return true;
}

Result<bool> Session::make_renderer(std::shared_ptr<GlContext> context, std::ostream& notes)
{
    device_name_ = options_.device.value_or("gl");
    if (device_name_ == "cpu_fast" && options_.test == "queries") { // also the default
        options_.test = "pyramid";
        notes << "occlude: --device cpu_fast has no queries; it tests by --test pyramid\n";
    }
    if (device_name_ != "cpu") {
        auto renderer = make_gl_renderer(model_, scene_.items, options_.size, options_.samples,
                                         {.context = std::move(context)});
        if (renderer) {
            renderer_ = device_name_ == "cpu_fast"
                            ? make_cpu_fast_renderer(std::move(*renderer), model_, scene_.items)
                            : std::move(*renderer);
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

Result<SceneModel> Session::load(const std::string& scene, const StageOptions& options,
                                 const LoadingCallback& loading)
{
    if (const auto checked = check_stage_options(options); !checked) {
        return checked.error();
    }
    SceneOptions reading = scene_options(options);
    if (loading) {
        reading.progress = [&loading](double share) { loading("reading", share); };
    }
    auto model = load_scene(scene, reading);
    if (!model) {
        return model.error();
    }
    if (drawn_triangles(*model) == 0) {
        return Error{ErrorCode::bad_data,
                     fmt::format("scene '{}' is empty: it holds no triangle; choose another file, "
                                 "or a scene of 'occlude list scenes'",
                                 scene)};
    }
    if (const auto problem = options.strict ? left_out_error(scene, *model) : std::nullopt) {
        return *problem;
    }
    if (options.path.ends_with(".json")) {
        const auto movers = read_movers(options.path, *model);
        if (!movers) {
            return movers.error();
        }
    }
    return model;
}

Result<std::unique_ptr<Session>> Session::prepare(SceneModel model, const StageOptions& options,
                                                  const LoadingCallback& loading)
{
    const auto trees = choose_hierarchies(options.hierarchy, options.sets);
    if (!trees) {
        return trees.error();
    }
    return std::unique_ptr<Session>{new Session{std::move(model), options, *trees, loading}};
}

Result<bool> Session::start(std::shared_ptr<GlContext> context, std::ostream& notes)
{
    if (const auto made = make_renderer(std::move(context), notes); !made) {
        return made.error();
    }
    make_motion();
    return true;
}

Result<std::unique_ptr<Session>> Session::open(const std::string& scene,
                                               const StageOptions& options, std::ostream& notes,
                                               const LoadingCallback& loading)
{
    const SecondsClock clock = steady_seconds_clock();
    const double start = clock();
    auto model = load(scene, options, loading);
    const double load_seconds = clock() - start;
    if (!model) {
        return model.error();
    }
    auto session = prepare(std::move(*model), options, loading);
    if (!session) {
        return session.error();
    }
    (*session)->preparation_.load_seconds = load_seconds;
    if (const auto started = (*session)->start(nullptr, notes); !started) {
        return started.error();
    }
    return session;
}

} // namespace occlude::tools
