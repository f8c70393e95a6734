#include "commands/commands.h"
#include "commands/open_session.h"
#include "files/output_file.h"
#include "render/image.h"
#include "report/table.h"
#include "session/contenders.h"
#include "session/picture.h"

#include <occlude/cull/registry.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <ostream>

namespace occlude::tools {

namespace {

namespace fs = std::filesystem;

struct Plan {
    FrameRange frames;
    bool many = false; ///< into a directory
    Show show = Show::visible;
    bool overview = false;
};

Result<Plan> make_plan(const RenderOptions& options)
{
    static const std::map<std::string, Show> kShows = {{"visible", Show::visible},
                                                       {"hidden", Show::hidden},
                                                       {"boxes", Show::boxes},
                                                       {"states", Show::states}};
    Plan plan;
    if (options.camera != "path" && options.camera != "overview") {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--camera: there is no camera '{}'; choose path or overview",
                                 options.camera)};
    }
    plan.overview = options.camera == "overview";
    const std::string standard = plan.overview ? "states" : "visible";
    const auto show = kShows.find(options.show.empty() ? standard : options.show);
    if (show == kShows.end()) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--show: '{}' cannot be shown; choose visible, hidden, boxes or "
                                 "states",
                                 options.show)};
    }
    plan.show = show->second;
    if (options.frame_range.empty()) {
        const size_t frame = options.frame.value_or(0);
        plan.frames = {frame, frame};
        return plan;
    }
    const auto range = parse_frame_range(options.frame_range);
    if (!range) {
        return range.error();
    }
    plan.frames = *range;
    plan.many = true;
    return plan;
}

Result<bool> make_directory(const std::string& path)
{
    std::error_code failed;
    fs::create_directories(path, failed);
    if (failed || !fs::is_directory(path)) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--out: cannot make the directory '{}'{}; choose another place",
                                 path, failed ? ": " + failed.message() : "")};
    }
    return true;
}

void print_legend(const Session& session, const Culler& culler, size_t frame, std::ostream& out)
{
    const std::vector<Decision> decisions =
        item_decisions(culler, session.scene().scene.item_bounds().size());
    std::vector<std::vector<std::string>> rows;
    for (const StateColor& state : state_colors()) {
        const auto count = std::count(decisions.begin(), decisions.end(), state.decision);
        rows.push_back({std::string{to_string(state.decision)}, std::string{state.color.name},
                        grouped(static_cast<uint64_t>(count)) + " items"});
    }
    out << "frame " << frame << '\n' << align_columns(rows);
}

Result<bool> check_output(const RenderOptions& options, const Plan& plan)
{
    if (!plan.many) {
        const auto file = OutputFile::open(options.out);
        return file ? Result<bool>{true} : Result<bool>{file.error()};
    }
    if (const auto made = make_directory(options.out); !made) {
        return made.error();
    }
    const auto file = OutputFile::open(fs::path{options.out} / "frame_0000.png");
    return file ? Result<bool>{true} : Result<bool>{file.error()};
}

Result<std::unique_ptr<Culler>> make_chosen_culler(Session& session, const RenderOptions& options)
{
    if (options.algorithm == "all" || options.algorithm == "exact" ||
        options.algorithm.find(',') != std::string::npos) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("--algorithm: '{}' is not one algorithm; 'occlude list "
                                 "algorithms' names them",
                                 options.algorithm)};
    }
    const auto contenders =
        choose_contenders(options.algorithm, options.stage.sets, session.renderer().device().caps(),
                          References::if_asked);
    if (!contenders) {
        return contenders.error();
    }
    return contenders->front().make(session.hierarchy());
}

Result<int> render_frames(Session& session, Culler& culler, std::span<const Camera> cameras,
                          const RenderOptions& options, const Plan& plan, const Streams& streams)
{
    session.renderer().warm_up();
    Progress progress{streams.err, streams.watcher, "rendering " + session.model().name};
    std::optional<Camera> observer; // one camera for all frames, so that the scene stands still
    if (plan.overview) {
        observer = overview_camera(session.model(), cameras[plan.frames.first], options.stage.size);
    }
    const size_t start = plan.frames.first - std::min(plan.frames.first, kLeadInFrames);
    for (size_t frame = start; frame <= plan.frames.last; ++frame) {
        cull_for_picture(session, culler, make_view(cameras[frame], options.stage.size), frame);
        if (frame < plan.frames.first) {
            continue;
        }
        const Image image = draw_picture(session, culler, cameras[frame], plan.show, observer);
        const fs::path path = plan.many
                                  ? fs::path{options.out} / fmt::format("frame_{:04}.png", frame)
                                  : fs::path{options.out};
        if (const auto written = write_png(path, image); !written) {
            return written.error();
        }
        if (plan.show != Show::visible && (frame == plan.frames.first || !plan.many)) {
            print_legend(session, culler, frame, streams.out);
        }
        progress.show(static_cast<double>(frame - start + 1) /
                      static_cast<double>(plan.frames.last - start + 1));
    }
    return kDone;
}

} // namespace

Result<int> render_command(const RenderOptions& options, const Streams& streams)
{
    const auto plan = make_plan(options);
    if (!plan) {
        return plan.error();
    }
    if (const auto checked = check_one_hierarchy(options.stage); !checked) {
        return checked.error();
    }
    if (const auto checked = check_output(options, *plan); !checked) {
        return checked.error();
    }
    const auto session = open_session(options.scene, options.stage, streams);
    if (!session) {
        return session.error();
    }
    const auto cameras = (*session)->cameras(options.stage.path);
    if (!cameras) {
        return cameras.error();
    }
    if (plan->frames.last >= cameras->size()) {
        return Error{ErrorCode::invalid_argument,
                     fmt::format("frame {} is beyond the end of path '{}', whose last frame is {}; "
                                 "choose an earlier one, or more frames with --path-frames",
                                 plan->frames.last, options.stage.path, cameras->size() - 1)};
    }
    const auto culler = make_chosen_culler(**session, options);
    if (!culler) {
        return culler.error();
    }
    return render_frames(**session, **culler, *cameras, options, *plan, streams);
}

} // namespace occlude::tools
