// What the commands of the keys do.
#include "session/picture.h"
#include "viewer/viewer.h"

#include <fmt/format.h>

namespace occlude::tools::viewer {

void Viewer::execute(Command command)
{
    PanelState& panels = state_.panels;
    pending_.redraw = true;
    switch (command) {
    case Command::toggle_help:
        panels.help = !panels.help;
        return;
    case Command::toggle_controls: {
        const bool covered = panels.narrow && panels.inspector && panels.inspector_wins;
        panels.controls = covered || !panels.controls;
        panels.inspector_wins = false;
        return;
    }
    case Command::toggle_inspector: {
        const bool covered = panels.narrow && panels.controls && !panels.inspector_wins;
        panels.inspector = covered || !panels.inspector;
        panels.inspector_wins = panels.inspector;
        return;
    }
    case Command::toggle_timeline:
        panels.timeline = !panels.timeline;
        return;
    case Command::screenshot:
        requests_.screenshot = true;
        return;
    case Command::quit:
        requests_.quit = true;
        return;
    case Command::search:
        panels.show_inspector();
        panels.focus_search = true;
        return;
    default:
        break;
    }
    if (session_) { // everything else is about a scene
        execute_on_camera(command);
        execute_on_scene(command);
    }
}

void Viewer::execute_on_camera(Command command)
{
    CameraState& camera = state_.camera;
    auto& bookmarks = settings_.bookmarks[session_->model().name];
    switch (command) {
    case Command::toggle_freeze:
        toggle_freeze();
        break;
    case Command::toggle_play:
        toggle_playing();
        break;
    case Command::overview:
        camera.playing = camera.playing && camera.frozen;
        camera.fly =
            FlyCamera{overview_camera(session_->model(), camera.fly.camera(), pictures_.size),
                      session_->model().up};
        break;
    case Command::home:
        camera.path_frame = 0;
        camera.fly = FlyCamera{camera.path.front(), session_->model().up};
        break;
    case Command::save_bookmark:
        bookmarks.push_back(camera.fly.camera());
        say(fmt::format("This camera is bookmark {}.", bookmarks.size()));
        break;
    case Command::next_bookmark:
        if (bookmarks.empty()) {
            say("There is no bookmark yet: Ctrl+B makes one.");
        } else {
            go_to_bookmark(camera.bookmark % bookmarks.size());
        }
        break;
    case Command::toggle_path_recording:
        toggle_path_recording();
        break;
    case Command::close:
        if (state_.panels.help) {
            state_.panels.help = false;
        } else if (state_.selection.instance) {
            select(std::nullopt);
        } else if (camera.frozen) {
            toggle_freeze();
        }
        break;
    default:
        break;
    }
}

void Viewer::execute_on_scene(Command command)
{
    TimeState& time = state_.time;
    PictureState& picture = state_.picture;
    switch (command) {
    case Command::toggle_pause:
        time.paused = !time.paused;
        time.steps = 0;
        break;
    case Command::step:
        time.paused = true;
        time.steps = 1;
        break;
    case Command::toggle_split:
        picture.split = !picture.split;
        break;
    case Command::toggle_difference:
        picture.difference = !picture.difference;
        break;
    case Command::next_fill:
        cycle_fill(1);
        break;
    case Command::previous_fill:
        cycle_fill(-1);
        break;
    case Command::next_algorithm:
        cycle_algorithm(1);
        break;
    case Command::previous_algorithm:
        cycle_algorithm(-1);
        break;
    case Command::cut:
        panes_[0]->cut();
        panes_[1]->cut();
        say("Cut: the algorithms have forgotten everything.");
        break;
    case Command::toggle_motion:
        time.moving = !time.moving;
        say(time.moving ? "Objects move." : "Objects stand still.");
        break;
    case Command::check_exactness:
        pending_.check = true;
        break;
    case Command::toggle_trace_recording:
        toggle_trace_recording();
        break;
    case Command::delete_object:
        delete_selected();
        break;
    case Command::duplicate_object:
        duplicate_selected();
        break;
    case Command::find_occluders:
        find_occluders();
        break;
    case Command::toggle_flare:
        toggle_flare();
        break;
    default:
        break;
    }
}

} // namespace occlude::tools::viewer
