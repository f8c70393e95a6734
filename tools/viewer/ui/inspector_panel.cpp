// The panel on the right: rolling figures, the report of the frame, and why an object is drawn.
#include "report/table.h"
#include "viewer/report_words.h"
#include "viewer/ui/panels.h"

#include <fmt/format.h>

#include <algorithm>

namespace occlude::tools::viewer {

namespace {

struct Series {
    std::string name;
    glm::vec4 color;
    const Rolling* values;
};

// A rolling plot of several series with one scale from 0, newest values at the right.
void plot(const char* title, std::span<const Series> series, const char* format)
{
    const float height = scaled(52.0f);
    const float width = ImGui::GetContentRegionAvail().x;
    float most = 0.0f;
    std::string caption = title;
    for (const Series& one : series) {
        most = std::max(most, one.values->largest());
    }
    caption += fmt::format("   (top: {})", fmt::format(fmt::runtime(format), most));
    faint(caption);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg));
    std::vector<ImVec2> points;
    for (const Series& one : series) {
        const auto values = one.values->values();
        points.clear();
        for (size_t i = 0; i < values.size(); ++i) {
            const float x = width * static_cast<float>(i + Rolling::kCapacity - values.size()) /
                            static_cast<float>(Rolling::kCapacity - 1);
            const float share = most > 0.0f ? values[i] / most : 0.0f;
            points.push_back({at.x + x, at.y + height - 1.0f - share * (height - 2.0f)});
        }
        list.AddPolyline(points.data(), static_cast<int>(points.size()), to_u32(one.color), 0,
                         scaled(1.5f));
    }
    ImGui::Dummy({width, height});
}

std::array<glm::vec4, 2> pane_colors()
{
    return {palette::kWhite.color, palette::kSkyBlue.color};
}

std::array<glm::vec4, 3> reference_colors()
{
    return {palette::kLightGrey.color * glm::vec4{0.7f, 0.7f, 0.7f, 1.0f}, palette::kGreen.color,
            palette::kYellow.color};
}

void figure_plot(Viewer& viewer, const char* title, Rolling PaneFigures::*figure)
{
    std::vector<Series> series;
    for (size_t i = 0; i < viewer.pane_count(); ++i) {
        series.push_back(
            {viewer.pane(i).algorithm(), pane_colors()[i], &(viewer.pane(i).figures().*figure)});
    }
    plot(title, series, "{:.0f}");
}

} // namespace

void figures_tab(Viewer& viewer)
{
    std::vector<Series> series;
    for (size_t i = 0; i < viewer.pane_count(); ++i) {
        series.push_back(
            {viewer.pane(i).algorithm(), pane_colors()[i], &viewer.pane(i).figures().frame_ms});
    }
    checkbox("measure frustum, opt and ideal", &viewer.state().measure_references);
    hint("Every now and then a frame is drawn by these too, in 5% of the time: what culling must "
         "beat, what a perfect tester would take, and the least there is to draw.");
    if (viewer.state().measure_references) {
        for (size_t i = 0; i < Viewer::kReferences.size(); ++i) {
            series.push_back({Viewer::kReferences[i], reference_colors()[i],
                              &viewer.reference(i).figures().frame_ms});
        }
    }
    for (const Series& one : series) {
        const float median = one.values->median();
        swatch(one.color, one.values->values().empty()
                              ? fmt::format("{}: not measured yet", one.name)
                              : fmt::format("{}: {:.2f} ms", one.name, median));
    }
    plot("frame time, ms", series, "{:.1f}");
    figure_plot(viewer, "tests", &PaneFigures::queries);
    figure_plot(viewer, "batches of tests", &PaneFigures::batches);
    figure_plot(viewer, "waits", &PaneFigures::waits);
    figure_plot(viewer, "triangles drawn", &PaneFigures::triangles);
}

void report_tab(Viewer& viewer)
{
    for (size_t i = 0; i < viewer.pane_count(); ++i) {
        const Pane& pane = viewer.pane(i);
        text(fmt::format("{}, frame {}", pane.algorithm(), viewer.frame()));
        for (const std::string& line : report_in_words(pane.report())) {
            wrapped(line);
        }
        const std::vector<std::string> plan = plan_in_words(pane.report().plan);
        if (!plan.empty()) {
            ImGui::Separator();
            for (const std::string& line : plan) {
                wrapped(line);
            }
        }
        faint(fmt::format("frame {:.2f} ms, of which the algorithm itself {:.2f} ms",
                          pane.figures().frame_ms.median(), pane.figures().cull_cpu_ms.median()));
        ImGui::Separator();
    }
}

namespace {

void show_last_test(const ItemExplanation& why)
{
    if (!why.last_test) {
        faint(fmt::format("No test covered it in the last {} frames.", why.recent.size()));
        return;
    }
    const LastTest& test = *why.last_test;
    const std::string age = test.frames_ago == 0   ? "in this frame"
                            : test.frames_ago == 1 ? "one frame ago"
                                                   : fmt::format("{} frames ago", test.frames_ago);
    const std::string answer = test.state == AnswerState::pending ? "not answered yet"
                               : test.state == AnswerState::lost
                                   ? "lost: taken as visible"
                                   : fmt::format("{} samples", grouped(test.samples));
    wrapped(fmt::format("Last test: {}, by {}, of node {}: {}.", age, name(test.method),
                        test.node.value, answer));
    if (!test.partners.empty()) {
        std::string partners;
        constexpr size_t kMostNamed = 8;
        for (size_t i = 0; i < std::min(kMostNamed, test.partners.size()); ++i) {
            partners += (i == 0 ? "" : ", ") + std::to_string(test.partners[i].value);
        }
        wrapped(fmt::format("Partners in its multiquery: {} nodes ({}{}).", test.partners.size(),
                            partners, test.partners.size() > kMostNamed ? ", ..." : ""));
    }
}

// One small square per frame, the newest at the right.
void show_recent(const ItemExplanation& why)
{
    text("The last frames:");
    const float side = scaled(5.0f);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    float x = at.x;
    for (const Decision decision : why.recent) {
        ImGui::GetWindowDrawList()->AddRectFilled({x, at.y}, {x + side - 1.0f, at.y + 2.0f * side},
                                                  to_u32(state_color(decision).color.color));
        x += side;
    }
    ImGui::Dummy({side * static_cast<float>(why.recent.size()), 2.0f * side});
}

void show_chain(const ItemExplanation& why)
{
    text("Chain of nodes, from the root:");
    bool decided = false;
    for (const ChainLink& link : why.chain) {
        const Decision decision = link.decision.value_or(Decision::undecided);
        const std::string_view meaning = link.decision ? state_color(decision).meaning
                                         : decided     ? "decided with the node above"
                                                       : "open: its parts decide";
        decided = decided || link.decision;
        swatch(state_color(decision).color.color,
               fmt::format("node {}, {} items, {} triangles; {}", link.node.value,
                           grouped(link.items), grouped(link.triangles), meaning));
    }
}

void show_coverage(Viewer& viewer)
{
    if (button("what hides it?")) {
        viewer.execute(Command::find_occluders);
    }
    const auto& coverage = viewer.state().selection.coverage;
    if (!coverage) {
        return;
    }
    if (coverage->pixels == 0) {
        wrapped("Drawn alone, it has no pixel in the culling camera's picture: it is outside the "
                "frustum, or "
                "too small. No object hides it; its box is hidden.");
        return;
    }
    wrapped(fmt::format("Of its {} pixels {} can be seen.", grouped(coverage->pixels),
                        grouped(coverage->visible_pixels)));
    constexpr size_t kMostShown = 5;
    for (size_t i = 0; i < std::min(kMostShown, coverage->occluders.size()); ++i) {
        const Occluder& occluder = coverage->occluders[i];
        swatch(palette::kOccluder.color,
               fmt::format("{} covers {:.0f}%", viewer.instance_name(occluder.instance),
                           100.0 * static_cast<double>(occluder.pixels) /
                               static_cast<double>(coverage->pixels)));
    }
}

void edit_object(Viewer& viewer, uint32_t instance)
{
    glm::vec3 place{viewer.session()->model().instances[instance].world_from_mesh[3]};
    const glm::vec3 before = place;
    const float step = 0.002f * glm::length(world_bounds(viewer.session()->model()).extent());
    if (ImGui::DragFloat3("place", &place.x, step, 0.0f, 0.0f, "%.2f")) {
        viewer.move_selected(place - before);
    }
    note_item("place");
    if (button(viewer.is_deleted(instance) ? "bring back" : "delete")) {
        viewer.execute(Command::delete_object);
    }
    ImGui::SameLine();
    if (button("copy")) {
        viewer.execute(Command::duplicate_object);
    }
}

void search_field(Viewer& viewer)
{
    ViewerState& state = viewer.state();
    if (std::exchange(state.panels.focus_search, false)) {
        ImGui::SetKeyboardFocusHere();
    }
    const bool entered = ImGui::InputTextWithHint(
        "##search", "search an object by its name", state.selection.search.data(),
        state.selection.search.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    note_item("search");
    ImGui::SameLine();
    if ((button("find") || entered) && state.selection.search[0] != '\0') {
        const std::string name = state.selection.search.data();
        if (const auto found = viewer.find_by_name(name)) {
            viewer.select(found);
        } else {
            viewer.say(fmt::format("No object's name contains '{}'.", name), true);
        }
    }
}

} // namespace

void why_tab(Viewer& viewer)
{
    search_field(viewer);
    const Selection& selection = viewer.state().selection;
    const Pane& pane = viewer.pane(0);
    if (!selection.instance || pane.culler() == nullptr) {
        faint("Click an object in the picture, or search its name: here stands why it is drawn or "
              "hidden. To reach a hidden one, freeze the camera (F) and walk around.");
        return;
    }
    const ItemExplanation why = explain(pane, selection.item);
    text(viewer.instance_name(*selection.instance));
    faint(fmt::format("object {}, item {}, algorithm {}", *selection.instance, selection.item.value,
                      pane.algorithm()));
    swatch(state_color(why.decision).color.color, why.rule);
    show_last_test(why);
    show_recent(why);
    show_coverage(viewer);
    ImGui::Separator();
    edit_object(viewer, *selection.instance);
    ImGui::Separator();
    show_chain(why);
}

void inspector_panel(Viewer& viewer, const Layout& layout)
{
    const PanelScope scope{"inspector",
                           {layout.window.x - layout.inspector_width, 0.0f},
                           {layout.inspector_width, layout.window.y},
                           false};
    if (viewer.session() == nullptr || !ImGui::BeginTabBar("inspector")) {
        return;
    }
    static std::optional<uint32_t> shown; // selecting an object opens its tab
    const auto selected = viewer.state().selection.instance;
    const bool jump = (selected && selected != shown) || viewer.state().panels.focus_search;
    shown = selected;
    const auto tab = [](const char* label, ImGuiTabItemFlags flags) {
        const bool open = ImGui::BeginTabItem(label, nullptr, flags);
        note_item(label);
        return open;
    };
    if (tab("Figures", 0)) {
        figures_tab(viewer);
        ImGui::EndTabItem();
    }
    if (tab("Report", 0)) {
        report_tab(viewer);
        ImGui::EndTabItem();
    }
    if (tab("Why?", jump ? ImGuiTabItemFlags_SetSelected : 0)) {
        why_tab(viewer);
        ImGui::EndTabItem();
    }
    ImGui::EndTabBar();
}

} // namespace occlude::tools::viewer
