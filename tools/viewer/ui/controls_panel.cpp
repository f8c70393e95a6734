// The panel on the left: what is culled how, what is shown, where the camera is.
#include "viewer/ui/panels.h"
#include "walk/paths.h"

#include <occlude/cull/registry.h>
#include <occlude/hierarchy/builders/hierarchy_kinds.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace occlude::tools::viewer {

namespace {

// The values that a description lists: "... (one of near far)".
std::vector<std::string> listed_values(const OptionInfo& info)
{
    constexpr std::string_view kOpening = "(one of ";
    std::vector<std::string> values;
    const size_t begin = info.description.rfind(kOpening);
    if (begin == std::string::npos) {
        return values;
    }
    std::string word;
    for (const char c : info.description.substr(begin + kOpening.size())) {
        if (c == ' ' || c == ')') {
            values.push_back(std::exchange(word, {}));
        } else {
            word += c;
        }
    }
    return values;
}

// A widget for one option; true if `value` was changed.
bool option_widget(const OptionInfo& info, std::string& value)
{
    const std::vector<std::string> listed = listed_values(info);
    if (!listed.empty()) {
        std::vector<const char*> names;
        for (const std::string& name : listed) {
            names.push_back(name.c_str());
        }
        return combo(info.name.c_str(), value, names.data(), names.size(), value);
    }
    if (info.default_value == "true" || info.default_value == "false") {
        bool on = value == "true";
        const bool changed = checkbox(info.name.c_str(), &on);
        value = on ? "true" : "false";
        return changed;
    }
    std::array<char, 32> buffer{};
    std::strncpy(buffer.data(), value.c_str(), buffer.size() - 1);
    ImGui::SetNextItemWidth(scaled(90.0f));
    const bool entered = ImGui::InputText(info.name.c_str(), buffer.data(), buffer.size(),
                                          ImGuiInputTextFlags_EnterReturnsTrue);
    note_item(info.name);
    if (entered) {
        value = buffer.data();
    }
    return entered;
}

void algorithm_section(Viewer& viewer, size_t index)
{
    ImGui::PushID(static_cast<int>(index));
    Pane& pane = viewer.pane(index);
    std::vector<const char*> names;
    std::vector<std::string> descriptions;
    for (const AlgorithmInfo& info : algorithms()) {
        names.push_back(info.name.c_str());
        descriptions.push_back(info.summary + " (" + info.paper + ")");
    }
    std::string chosen;
    const char* label = viewer.pane_count() == 1 ? "algorithm" : index == 0 ? "left" : "right";
    if (combo(label, pane.algorithm(), names.data(), names.size(), chosen, descriptions.data())) {
        viewer.choose_algorithm(index, chosen);
    }
    const AlgorithmInfo* info = find_algorithm(pane.algorithm());
    if (info != nullptr) {
        faint(info->summary);
        if (!info->options.empty() && ImGui::TreeNode("options")) {
            for (const OptionInfo& option : info->options) {
                std::string value = pane.option(option);
                if (option_widget(option, value)) {
                    pane.set_option(option.name, value);
                }
                hint(option.description + " Default: " + option.default_value);
            }
            ImGui::TreePop();
        }
    }
    if (!pane.problem().empty()) {
        wrapped(pane.problem());
    }
    ImGui::PopID();
}

void hierarchy_section(Viewer& viewer)
{
    Session& session = *viewer.session();
    const std::string& text = session.options().hierarchy;
    const std::string kind_name = text.substr(0, text.find(':'));
    std::vector<std::string> kinds;
    std::vector<const char*> names;
    std::vector<std::string> descriptions;
    for (const HierarchyKind& kind : hierarchy_kinds()) {
        kinds.emplace_back(kind.name);
        descriptions.emplace_back(kind.summary);
    }
    for (const std::string& kind : kinds) {
        names.push_back(kind.c_str());
    }
    std::string chosen;
    if (combo("hierarchy", kind_name, names.data(), names.size(), chosen, descriptions.data())) {
        viewer.choose_hierarchy(chosen);
        return;
    }
    const HierarchyKind* kind = find_hierarchy_kind(kind_name);
    if (kind == nullptr || kind->options().empty() || !ImGui::TreeNode("tree options")) {
        return;
    }
    const auto entry = parse_entry(text);
    std::string changed = kind_name;
    bool any = false;
    for (const OptionInfo& option : kind->options()) {
        std::string value = option.default_value;
        for (const OptionValue& set : entry ? entry->options : std::vector<OptionValue>{}) {
            if (set.first == option.name) {
                value = set.second;
            }
        }
        any = option_widget(option, value) || any;
        hint(option.description);
        if (value != option.default_value) {
            changed += ":" + option.name + "=" + value;
        }
    }
    ImGui::TreePop();
    if (any) {
        viewer.choose_hierarchy(changed);
    }
}

void device_section(Viewer& viewer)
{
    Session& session = *viewer.session();
    static constexpr std::array<const char*, 3> kDevices = {"gl", "cpu", "cpu_fast"};
    static const std::array<std::string, 3> kMeanings = {
        "OpenGL draws and tests.", "The CPU draws and tests: exact, and slow.",
        "OpenGL draws; the CPU tests boxes against occluders that it rasterises."};
    std::string chosen;
    if (combo("device", session.device_name(), kDevices.data(), kDevices.size(), chosen,
              kMeanings.data())) {
        viewer.choose_device(chosen);
        return;
    }
    std::vector<const char*> methods;
    for (const TestCost& cost : session.renderer().device().caps().methods) {
        methods.push_back(name(cost.method));
    }
    std::sort(methods.begin(), methods.end(),
              [](const char* a, const char* b) { return std::string_view{a} < b; });
    if (combo("tests", session.options().test, methods.data(), methods.size(), chosen)) {
        viewer.choose_test(chosen);
    }
    hint("How boxes are tested: hardware occlusion queries, boxes rasterised into flags, or depth "
         "read back and compared on the CPU.");
}

// In the order of Overlay.
constexpr std::array<const char*, kOverlayCount> kOverlayHints = {
    "The node of every decision, in its colour.",
    "Every box that was tested, by what the test found.",
    "The boxes that are tested where an item's own is too large.",
    "The boxes of one level of the hierarchy.",
    "The boxes that shared one test, in one colour.",
    "What lazy_grid knows of each cell of the screen.",
    "The rectangles of pixels whose depth was read back.",
    "The farthest depth of each square of pixels: dark is near."};

void picture_section(Viewer& viewer)
{
    PictureState& picture = viewer.state().picture;
    std::vector<const char*> fills;
    for (const std::string_view fill : kFillNames) {
        fills.push_back(fill.data());
    }
    std::string chosen;
    const auto current = static_cast<size_t>(picture.fill);
    if (combo("show", fills[current], fills.data(), fills.size(), chosen)) {
        const auto found = std::find(kFillNames.begin(), kFillNames.end(), chosen);
        picture.fill = static_cast<Fill>(found - kFillNames.begin());
    }
    checkbox("split", &picture.split);
    ImGui::SameLine();
    checkbox("difference", &picture.difference);
    ImGui::SameLine();
    bool flare = picture.flare;
    if (checkbox("flare", &flare)) {
        viewer.execute(Command::toggle_flare);
    }
    const float column = 0.5f * ImGui::GetContentRegionAvail().x;
    for (size_t i = 0; i < kOverlayCount; ++i) {
        if (i % 2 == 1) {
            ImGui::SameLine(column);
        }
        checkbox(kOverlayNames[i].data(), &picture.overlays.on[i]);
        hint(kOverlayHints[i]);
    }
    if (picture.overlays.has(Overlay::levels)) {
        slider("tree level##slider", &picture.overlays.level, 0, 24);
    }
    if (picture.overlays.has(Overlay::pyramid)) {
        slider("texel: 2^n pixels", &picture.overlays.pyramid_level, 3, 8);
    }
}

void places_section(Viewer& viewer)
{
    if (button("overview")) {
        viewer.execute(Command::overview);
    }
    ImGui::SameLine();
    if (button("home")) {
        viewer.execute(Command::home);
    }
    ImGui::SameLine();
    if (button("bookmark")) {
        viewer.execute(Command::save_bookmark);
    }
    const size_t count = viewer.settings().bookmarks[viewer.session()->model().name].size();
    for (size_t i = 0; i < count; ++i) {
        if (i % 6 != 0) {
            ImGui::SameLine();
        }
        if (button(fmt::format("{}##bookmark", i + 1).c_str())) {
            viewer.go_to_bookmark(i);
        }
    }
}

void camera_section(Viewer& viewer)
{
    ViewerState& state = viewer.state();
    CameraState& camera = state.camera;
    bool frozen = camera.frozen;
    if (checkbox("freeze", &frozen)) {
        viewer.execute(Command::toggle_freeze);
    }
    hint("The culling camera stays where it is, and you walk around as an observer.");
    ImGui::SameLine();
    checkbox("pause", &state.time.paused);
    ImGui::SameLine();
    if (button("step")) {
        viewer.execute(Command::step);
    }
    ImGui::SameLine();
    if (button("cut")) {
        viewer.execute(Command::cut);
    }
    std::vector<std::string> paths;
    for (const PathInfo& path : path_names(viewer.session()->model())) {
        paths.push_back(path.name);
    }
    std::vector<const char*> names;
    for (const std::string& path : paths) {
        names.push_back(path.c_str());
    }
    std::string chosen;
    if (combo("path", camera.path_name, names.data(), names.size(), chosen)) {
        viewer.choose_path(chosen);
    }
    checkbox("play", &camera.playing);
    ImGui::SameLine();
    text(fmt::format("frame {} of {}", camera.path_frame, camera.path.size()));
    slider("speed", &camera.speed, 0.05f, 20.0f, "%.2f");
    if (button("record path")) {
        viewer.execute(Command::toggle_path_recording);
    }
    ImGui::SameLine();
    if (button("record trace")) {
        viewer.execute(Command::toggle_trace_recording);
    }
    places_section(viewer);
    if (!viewer.session()->model().motion.empty()) {
        checkbox("objects move", &state.time.moving);
    }
}

} // namespace

void controls_panel(Viewer& viewer, const Layout& layout)
{
    const PanelScope scope{
        "controls", {0.0f, 0.0f}, {layout.controls_width, layout.window.y}, false};
    if (button("F1 keys")) {
        viewer.execute(Command::toggle_help);
    }
    ImGui::SameLine();
    if (button("screenshot")) {
        viewer.execute(Command::screenshot);
    }
    if (viewer.session() == nullptr) {
        faint("Drop a scene on the window: glTF, OBJ, IFC, or any other file that Assimp reads.");
        return;
    }
    const SceneModel& model = viewer.session()->model();
    text(model.name);
    faint(fmt::format("{} objects, {} items, {} triangles", model.instances.size(),
                      viewer.instance_of().size(), drawn_triangles(model)));
    ImGui::PushItemWidth(scaled(150.0f));
    if (header("Culling", true)) {
        for (size_t i = 0; i < viewer.pane_count(); ++i) {
            algorithm_section(viewer, i);
        }
        hierarchy_section(viewer);
        device_section(viewer);
        if (button("check exactness")) {
            viewer.execute(Command::check_exactness);
        }
        hint("Compares every pixel of this frame with drawing everything in the frustum.");
    }
    if (header("Camera", true)) {
        camera_section(viewer);
    }
    if (header("Picture", true)) {
        picture_section(viewer);
    }
    ImGui::PopItemWidth();
}

} // namespace occlude::tools::viewer
