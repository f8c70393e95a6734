// The frames of the viewer: culling them and making pictures of them.
#include "measure/verify.h"
#include "session/picture.h"
#include "viewer/viewer.h"

#include <occlude/device/flare_device.h>

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools::viewer {

void Viewer::draw(glm::ivec2 size)
{
    if (!session_ || size.x < 1 || size.y < 1) {
        return;
    }
    context_->make_current();
    if (size != pictures_.size) {
        if (const auto resized = session_->resize(size); !resized) {
            say(resized.error().message, true);
            return;
        }
        pictures_.size = size;
        pending_.redraw = true;
    }
    TimeState& time = state_.time;
    const bool cull = !time.paused || time.steps > 0;
    time.steps = std::max(time.steps - 1, 0);
    if (!cull && !pending_.redraw) {
        return;
    }
    const bool moves = !session_->model().motion.empty();
    if (moves && cull && time.moving) {
        ++time.motion_frame;
    }
    if (moves && (time.moving || pending_.redraw)) {
        // Frame 0 would begin the motion again, and with it all ids.
        set_frame(session_->stage(), std::max<size_t>(time.motion_frame, 1));
        note_instances();
    }
    cull_panes(cull);
    pending_.redraw = false;
}

void Viewer::cull_panes(bool cull)
{
    const Stage stage = session_->stage();
    const View view = culling_view();
    frame_ += cull ? 1 : 0;
    if (cull && state_.measure_references && references_.debt_s <= 0.0) {
        measure_references(stage, view);
    }
    pictures_.marks.clear();
    for (size_t i = 0; i < pane_count(); ++i) {
        if (cull || panes_[i]->culler() == nullptr) {
            cull_pane(i, stage, view);
        } else { // paused: the same frame again, as it was
            session_->renderer().render(view, panes_[i]->culler()->drawn_items());
        }
        if (i == 0) {
            take_eye();
        }
        if (i == 0 && std::exchange(pending_.check, false)) {
            check_exactness(stage, view);
        }
        present(i);
    }
    if (state_.picture.difference && pictures_.compositor) {
        pictures_.compositor->compose(Compositor::Mode::difference, pictures_.finished[0],
                                      pictures_.finished[1], pictures_.difference);
    }
}

void Viewer::take_eye()
{
    if (state_.camera.frozen && state_.picture.overlays.any_on_screen()) {
        pictures_.eye.take(session_->renderer(), pictures_.size);
    } else if (!pictures_.eye.empty()) {
        pictures_.eye = Canvas{};
    }
}

void Viewer::cull_pane(size_t index, const Stage& stage, const View& view)
{
    QueryDevice* device = &stage.renderer.device();
    if (index == 0 && recorder_) {
        device = recorder_.get();
    }
    FlareDevice flare_device{*device, light_.visibility};
    if (index == 0 && state_.picture.flare) {
        device = &flare_device;
    }
    if (!panes_[index]->cull(stage, view, *device, frame_)) {
        say(panes_[index]->problem(), true);
    }
    pictures_.depth.clear();
    if (index == 0 && state_.picture.overlays.has(Overlay::pyramid)) {
        pictures_.depth = stage.renderer.capture().depth;
    }
}

void Viewer::measure_references(const Stage& stage, const View& view)
{
    constexpr double kFramesPerReference = 20.0; // so that measuring takes 5% of the time
    const SecondsClock clock = steady_seconds_clock();
    const double start = clock();
    references_.panes[references_.next]->cull(stage, view, stage.renderer.device(), frame_);
    references_.next = (references_.next + 1) % references_.panes.size();
    references_.debt_s = kFramesPerReference * (clock() - start);
}

void Viewer::check_exactness(const Stage& stage, const View& view)
{
    const Culler* culler = panes_[0]->culler();
    if (culler == nullptr) {
        return;
    }
    const Capture culled = stage.renderer.capture();
    const Capture reference = reference_image(stage, view);
    const Verdict verdict =
        judge_frame(stage, view, reference, culled, culler->drawn_items(), culler->decisions());
    stage.renderer.render(view, culler->drawn_items());
    const bool promised = panes_[0]->report().guarantee == Guarantee::exact();
    ++state_.checked_frames;
    state_.wrong_frames += promised && verdict.differing_pixels > 0 ? 1 : 0;
    if (verdict.differing_pixels == 0) {
        say("Checked: every pixel is as if nothing was culled.");
    } else {
        say(fmt::format("Checked: {} pixels differ from drawing everything{}.",
                        verdict.differing_pixels,
                        promised ? ", though the algorithm is exact: this is a defect"
                                 : ", as this algorithm may"),
            promised);
    }
}

std::vector<ItemId> Viewer::hidden_items(const Pane& pane) const
{
    const auto in_frustum = items_in_frustum(culling_view(), session_->scene().scene.item_bounds());
    std::vector<ItemId> drawn{pane.culler()->drawn_items().begin(),
                              pane.culler()->drawn_items().end()};
    std::sort(drawn.begin(), drawn.end());
    std::vector<ItemId> hidden;
    std::set_difference(in_frustum.begin(), in_frustum.end(), drawn.begin(), drawn.end(),
                        std::back_inserter(hidden));
    return hidden;
}

// Draws the pane's picture into the renderer's target, where the culled frame is now.
void Viewer::fill(const Pane& pane, const View& view)
{
    const Stage stage = session_->stage();
    const Culler& culler = *pane.culler();
    const auto everything = [&] {
        return in_draw_order(view, stage.item_bounds, items_in_frustum(view, stage.item_bounds));
    };
    switch (state_.picture.fill) {
    case Fill::visible:
    case Fill::hidden:
        if (state_.camera.frozen) {
            stage.renderer.render(view,
                                  in_draw_order(view, stage.item_bounds, culler.drawn_items()));
        }
        break;
    case Fill::states: {
        std::vector<glm::vec4> colors;
        for (const Decision decision : item_decisions(culler, stage.item_bounds.size())) {
            colors.push_back(linear_color(state_color(decision).color.color));
        }
        stage.renderer.set_item_colors(colors);
        stage.renderer.render(view, everything());
        stage.renderer.set_item_colors({});
        break;
    }
    case Fill::all:
        stage.renderer.render(view, everything());
        break;
    }
}

void Viewer::draw_overlays(size_t index, const View& view)
{
    const Stage stage = session_->stage();
    const Pane& pane = *panes_[index];
    OverlayPicture overlays = make_overlays(state_.picture.overlays, pane, stage.hierarchy.shapes(),
                                            pictures_.size, pictures_.depth);
    for (const WorldLines& lines : overlays.lines) {
        stage.renderer.draw_lines(view, lines.points, lines.color, lines.on_top);
    }
    if (index == 0) {
        pictures_.marks = std::move(overlays.marks);
    }
    const auto draw_instance = [&](uint32_t instance, const glm::vec4& color) {
        std::vector<glm::vec3> points;
        for (size_t item = 0; item < instance_of_.size(); ++item) {
            if (instance_of_[item] == instance) {
                add_box(points, stage.item_bounds[item].box);
            }
        }
        stage.renderer.draw_lines(view, points, color, true);
    };
    const Selection& selection = state_.selection;
    if (selection.coverage) {
        constexpr size_t kMostShown = 5;
        const auto& occluders = selection.coverage->occluders;
        for (size_t i = 0; i < std::min(kMostShown, occluders.size()); ++i) {
            draw_instance(occluders[i].instance, palette::kOccluder.color);
        }
    }
    if (selection.instance) {
        draw_instance(*selection.instance, palette::kSelected.color);
    }
    if (state_.camera.frozen) {
        const float reach = glm::length(world_bounds(session_->model()).extent());
        stage.renderer.draw_lines(view, frustum_edges(culling_view(), reach), palette::kWhite.color,
                                  true);
    }
}

std::vector<LegendLine> Viewer::legend_lines() const
{
    if (!session_) {
        return {};
    }
    std::vector<LegendLine> lines =
        legend(state_.picture.fill, state_.picture.overlays, *panes_[0]);
    const bool selected = state_.selection.instance.has_value();
    if (state_.camera.frozen || selected) {
        static_assert(palette::kSelected.color == palette::kWhite.color, "one line for both");
        lines.push_back({palette::kWhite.color, !selected ? "lines: the frozen camera's frustum"
                                                : !state_.camera.frozen
                                                    ? "lines: the selected object"
                                                    : "lines: the frozen frustum, the selection"});
    }
    if (state_.selection.coverage && !state_.selection.coverage->occluders.empty()) {
        lines.push_back({palette::kOccluder.color, "lines: what hides it"});
    }
    if (state_.picture.difference) {
        lines.push_back({palette::kOrange.color, "pixels in which the two images differ"});
    }
    return lines;
}

void Viewer::present(size_t index)
{
    Pane& pane = *panes_[index];
    if (pane.culler() == nullptr) {
        return;
    }
    SceneRenderer& renderer = session_->renderer();
    const View view = shown_view();
    fill(pane, view);
    draw_overlays(index, view);
    if (state_.picture.fill != Fill::hidden || !pictures_.compositor) {
        pictures_.finished[index].take(renderer, pictures_.size);
        return;
    }
    // Hidden objects alone, in one colour, mixed over the frame as if nothing stood before them.
    pictures_.scratch.take(renderer, pictures_.size);
    const std::vector<glm::vec4> tints(session_->scene().scene.item_bounds().size(),
                                       linear_color(state_color(Decision::hidden).color.color));
    renderer.set_item_colors(tints);
    renderer.render(view, hidden_items(pane));
    renderer.set_item_colors({});
    pictures_.tinted.take(renderer, pictures_.size);
    pictures_.compositor->compose(Compositor::Mode::shine_through, pictures_.scratch,
                                  pictures_.tinted, pictures_.finished[index]);
}

} // namespace occlude::tools::viewer
