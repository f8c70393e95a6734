// A scene that is loaded, organised and ready to be drawn.
#pragma once

#include "measure/motion_player.h"
#include "measure/stage.h"
#include "options/options.h"
#include "render/gl_context.h"
#include "report/bench_document.h"
#include "session/hierarchies.h"

#include <occlude/core/result.h>
#include <occlude/scene/two_level_scene.h>

#include <functional>
#include <iosfwd>
#include <memory>

namespace occlude::tools {

/// Called with the work being done on a scene ("reading", "building the tree") and the share that
/// is done; NaN if it is unknown.
using LoadingCallback = std::function<void(const std::string& phase, double share)>;

class Session {
public:
    /// Loads or generates the scene, builds the hierarchies and makes the renderer. Reports on
    /// `notes` what the user should know (a fallback to the CPU). Errors name the thing and the
    /// remedy.
    static Result<std::unique_ptr<Session>> open(const std::string& scene,
                                                 const StageOptions& options, std::ostream& notes,
                                                 const LoadingCallback& loading = {});

    /// The parts of open(), for programs that load in another thread. load() and prepare() touch no
    /// renderer; start() belongs to the thread that will draw. `context` is the OpenGL context to
    /// draw in; null: one without a window.
    static Result<SceneModel> load(const std::string& scene, const StageOptions& options,
                                   const LoadingCallback& loading = {});
    static Result<std::unique_ptr<Session>> prepare(SceneModel model, const StageOptions& options,
                                                    const LoadingCallback& loading = {});
    Result<bool> start(std::shared_ptr<GlContext> context, std::ostream& notes);

    /// Replaces the trees: cullers of the old ones must not be used again. Changes nothing on an
    /// error.
    Result<bool> use_hierarchies(const std::string& text, const std::vector<std::string>& sets);
    /// Changes the method of testing boxes: "queries", "raster" or "pyramid".
    Result<bool> use_test(const std::string& method);
    /// Changes the size of the target and of views.
    Result<bool> resize(glm::ivec2 size);
    /// The model, so that instances can be moved (world_from_mesh) or made to vanish (motion); the
    /// next set_frame() of the stage takes the changes over. A scene in which nothing moves gets a
    /// motion in which everything stands still. Neither instances nor meshes may be added or
    /// removed.
    SceneModel& editable_model();

    const SceneModel& model() const { return model_; }
    const CullScene& scene() const { return scene_; }
    /// The first of the chosen trees.
    const Hierarchy& hierarchy() const { return trees_.front()->hierarchy(); }
    /// The tree of an entry of --hierarchy; null if there is none. Valid as long as the session.
    const Hierarchy* tree(std::string_view label) const;
    /// The entries of --hierarchy, in their order.
    std::vector<std::string> tree_labels() const;
    SceneRenderer& renderer() { return *renderer_; }
    /// "gl", "cpu" or "cpu_fast".
    const std::string& device_name() const { return device_name_; }
    const StageOptions& options() const { return options_; }
    /// Times measured while the session was made, and since then where things move.
    Preparation preparation() const;

    /// Valid as long as the session. If the scene moves, set_frame() changes the session's scene,
    /// hierarchies and renderer.
    Stage stage();

    /// The cameras of a path, with near and far chosen. Never empty.
    Result<std::vector<Camera>> cameras(const std::string& path) const;
    /// The same for another number of frames than the option's.
    Result<std::vector<Camera>> cameras(const std::string& path, size_t frames) const;
    /// The views of the same path, or of these cameras, in the session's size.
    Result<std::vector<View>> views(const std::string& path) const;
    std::vector<View> views(std::span<const Camera> cameras) const;

    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

private:
    // One of the chosen hierarchies, at a fixed place in memory.
    struct Tree {
        HierarchyChoice choice;
        Hierarchy flat;
        std::unique_ptr<TwoLevelScene> two_level; ///< used instead of `flat` for the kind two_level

        const Hierarchy& hierarchy() const { return two_level ? two_level->hierarchy() : flat; }
    };

    Session(SceneModel model, const StageOptions& options, std::span<const HierarchyChoice> trees,
            const LoadingCallback& loading);
    void build_trees(std::span<const HierarchyChoice> choices, const LoadingCallback& loading = {});
    Result<bool> make_renderer(std::shared_ptr<GlContext> context, std::ostream& notes);
    Result<bool> choose_test();
    TwoLevelOptions options_of_two_level(const HierarchyChoice& choice) const;
    void make_motion();
    std::unique_ptr<MovingTree> make_moving(Tree& tree) const;
    Hierarchy build(const HierarchyChoice& choice, std::span<const ItemBounds> items) const;

    StageOptions options_;
    SceneModel model_;
    CullScene scene_;
    std::vector<std::unique_ptr<Tree>> trees_; ///< never empty
    std::unique_ptr<SceneRenderer> renderer_;
    std::string device_name_;
    std::unique_ptr<MovingTree> moving_trees_; ///< these are null if nothing moves
    std::unique_ptr<MotionPlayer> motion_;
    Preparation preparation_;
};

/// The assumptions about a file and the parts left out of it, one indented line each; empty for
/// generated scenes.
std::string load_summary(const SceneModel& model);

/// What --strict says of a file of which something is left out; nothing if all of it is there.
std::optional<Error> left_out_error(const std::string& scene, const SceneModel& model);

/// Errors for choices that this version does not have. Costs nothing: call it before loading.
Result<bool> check_stage_options(const StageOptions& options);

/// The same for commands that run on one hierarchy.
Result<bool> check_one_hierarchy(const StageOptions& options);

} // namespace occlude::tools
