// A scene that is loaded, organised and ready to be drawn.
#pragma once

#include "commands/options.h"
#include "measure/motion_player.h"
#include "measure/stage.h"

#include <occlude/scene/two_level_scene.h>

#include <iosfwd>
#include <memory>

namespace occlude::tools {

class Session {
public:
    /// Loads or generates the scene, builds the hierarchy and makes the renderer. Says on `notes`
    /// what the user should know (a fallback to the CPU). Errors name the thing and the remedy.
    static Result<std::unique_ptr<Session>> open(const std::string& scene,
                                                 const StageOptions& options, std::ostream& notes);

    const SceneModel& model() const { return model_; }
    const CullScene& scene() const { return scene_; }
    const Hierarchy& hierarchy() const { return two_level_ ? two_level_->hierarchy() : hierarchy_; }
    SceneRenderer& renderer() { return *renderer_; }
    /// "gl" or "cpu".
    const std::string& device_name() const { return device_name_; }
    const StageOptions& options() const { return options_; }

    /// Valid as long as the session. If the scene moves, set_frame() changes the session's scene,
    /// hierarchy and renderer.
    Stage stage();

    /// The cameras of a path, with near and far chosen. Never empty.
    Result<std::vector<Camera>> cameras(const std::string& path) const;
    /// The views of the same path at the session's size.
    Result<std::vector<View>> views(const std::string& path) const;

    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

private:
    Session(SceneModel model, const StageOptions& options);
    Result<bool> make_renderer(std::ostream& notes);
    Result<bool> choose_test();
    TwoLevelOptions two_level_options() const;
    void make_motion();
    Hierarchy build(std::span<const ItemBounds> items) const;

    StageOptions options_;
    SceneModel model_;
    CullScene scene_;
    Hierarchy hierarchy_;
    std::unique_ptr<TwoLevelScene> two_level_; ///< instead of hierarchy_, if that was chosen
    std::unique_ptr<SceneRenderer> renderer_;
    std::string device_name_;
    std::unique_ptr<MovingTree> moving_tree_; ///< these are null if nothing moves
    std::unique_ptr<MotionPlayer> motion_;
};

/// Errors for choices that this version does not have. Costs nothing: call it before loading.
Result<bool> check_stage_options(const StageOptions& options);

} // namespace occlude::tools
