#include "commands/commands.h"
#include "commands/open_session.h"
#include "files/json.h"
#include "files/output_file.h"
#include "model/scene_advice.h"
#include "report/table.h"
#include "session/prospects.h"
#include "session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <ostream>
#include <set>

namespace occlude::tools {

namespace {

struct TreeShape {
    size_t depth = 0; ///< nodes from the root to the deepest leaf, both included
    size_t leaves = 0;
};

TreeShape tree_shape(const Hierarchy& hierarchy)
{
    TreeShape shape;
    std::vector<size_t> depths(hierarchy.nodes().size(), 0);
    std::vector<bool> below_leaf(hierarchy.nodes().size(), false);
    for (size_t i = 0; i < depths.size(); ++i) {
        const NodeId parent = hierarchy.node(NodeId{i}).parent;
        const bool is_root = !parent.valid();
        depths[i] = is_root ? 1 : depths[parent.value] + 1;
        below_leaf[i] = !is_root && (below_leaf[parent.value] || hierarchy.is_leaf(parent));
        if (hierarchy.is_leaf(NodeId{i}) && !below_leaf[i]) {
            ++shape.leaves;
            shape.depth = std::max(shape.depth, depths[i]);
        }
    }
    return shape;
}

uint64_t unique_triangles(const SceneModel& model)
{
    std::set<uint32_t> used;
    for (const Instance& instance : model.instances) {
        used.insert(instance.mesh);
    }
    uint64_t triangles = 0;
    for (const uint32_t mesh : used) {
        triangles += model.meshes[mesh].indices.size() / 3;
    }
    return triangles;
}

double mesh_mebibytes(const SceneModel& model)
{
    size_t bytes = 0;
    for (const Mesh& mesh : model.meshes) {
        bytes += (mesh.positions.size() + mesh.normals.size()) * sizeof(glm::vec3) +
                 mesh.indices.size() * sizeof(uint32_t) + mesh.parts.size() * sizeof(MeshPart);
    }
    return static_cast<double>(bytes) / (1024.0 * 1024.0);
}

double hierarchy_mebibytes(const Hierarchy& hierarchy)
{
    const size_t bytes = hierarchy.nodes().size_bytes() + hierarchy.items().size_bytes() +
                         hierarchy.item_bounds().size_bytes();
    return static_cast<double>(bytes) / (1024.0 * 1024.0);
}

std::string objects_text(const SceneModel& model)
{
    const auto& motions = model.motion.instances;
    const auto passing = std::count_if(motions.begin(), motions.end(),
                                       [](const InstanceMotion& m) { return m.period > 0; });
    const std::string count = grouped(model.instances.size());
    return model.motion.empty() ? count
                                : fmt::format("{}, moving, {} of them appear and vanish", count,
                                              grouped(static_cast<uint64_t>(passing)));
}

std::string triangles_text(const SceneModel& model)
{
    const uint64_t drawn = drawn_triangles(model);
    return model.file_triangles <= drawn
               ? grouped(drawn)
               : fmt::format("{} of {} in the file", grouped(drawn), grouped(model.file_triangles));
}

std::string contents_text(Session& session)
{
    const SceneModel& model = session.model();
    const Hierarchy& hierarchy = session.hierarchy();
    const Aabb bounds = world_bounds(model);
    const glm::dvec3 low = glm::dvec3{bounds.min} + model.origin; // as in the file
    const glm::dvec3 high = glm::dvec3{bounds.max} + model.origin;
    const int digits = model.origin == glm::dvec3{0.0} ? 6 : 10;
    const TreeShape shape = tree_shape(hierarchy);
    const std::vector<std::vector<std::string>> rows = {
        {"objects", objects_text(model)},
        {"items", grouped(session.scene().items.size())},
        {"triangles", triangles_text(model)},
        {"unique triangles", grouped(unique_triangles(model))},
        {"bounds",
         fmt::format("({:.{}g}, {:.{}g}, {:.{}g}) to ({:.{}g}, {:.{}g}, {:.{}g})", low.x, digits,
                     low.y, digits, low.z, digits, high.x, digits, high.y, digits, high.z, digits)},
        {"hierarchy", fmt::format("{}, {} nodes, {} leaves, depth {}, SAH cost {:.1f}",
                                  session.options().hierarchy, grouped(hierarchy.nodes().size()),
                                  grouped(shape.leaves), shape.depth, sah_cost(hierarchy))},
        {"memory", fmt::format("meshes {:.1f} MiB, hierarchy {:.1f} MiB", mesh_mebibytes(model),
                               hierarchy_mebibytes(hierarchy))}};
    std::string text = model.name + "\n";
    for (const auto& row : rows) {
        text += fmt::format("  {:<17} {}\n", row[0], row[1]);
    }
    return text + load_summary(model);
}

double percent(uint64_t part, uint64_t whole)
{
    return 100.0 * static_cast<double>(part) / static_cast<double>(std::max<uint64_t>(whole, 1));
}

std::string recommendation(Pays pays)
{
    switch (pays) {
    case Pays::yes:
        return "Culling is likely to pay: most of what is in the frustum is hidden. Measure it "
               "with 'occlude bench'.";
    case Pays::perhaps:
        return "Culling may pay a little; measure it with 'occlude bench' before relying on it.";
    case Pays::small:
        return "Culling is unlikely to pay: frames are so small that tests would cost about as "
               "much as drawing.";
    default:
        return "Culling is unlikely to pay on this path: nearly everything in the frustum is seen. "
               "Smaller items (--item-triangles) or another path may show otherwise.";
    }
}

std::string occlusion_text(const Occlusion& sum, const InfoOptions& options)
{
    if (sum.owner_triangles == 0) {
        return fmt::format("\npath {}, {} frames: nothing of the scene is in view; choose another "
                           "--path\n",
                           options.stage.path, sum.frames);
    }
    return fmt::format("\npath {}, {} frames at {}x{}: {:.1f}% of the items in the frustum own a "
                       "pixel,\nand {:.1f}% of the triangles are theirs. "
                       "Where triangles are what costs, no culling can be\nmore than {:.1f} times "
                       "faster than frustum culling here.\n{}\n",
                       options.stage.path, sum.frames, options.stage.size.x, options.stage.size.y,
                       percent(sum.owners, sum.items), percent(sum.owner_triangles, sum.triangles),
                       sum.limit(), recommendation(judge(sum)));
}

std::string prospects_text(std::span<const Prospect> prospects)
{
    std::string text = "\nDoes culling pay, per frame of a camera that\n";
    for (const Prospect& prospect : prospects) {
        text += fmt::format("  {:<34} {:<16} {}\n", prospect.what, to_string(prospect.pays),
                            prospect.sentence());
    }
    return text + conclusion(prospects) + "\n";
}

std::string advice_text(std::span<const Advice> advice)
{
    if (advice.empty()) {
        return "\nNothing in the scene's objects stands in the way of culling.\n";
    }
    std::string text = "\nWhat to change in the scene\n";
    for (const Advice& one : advice) {
        text += fmt::format("  {}\n", one.sentence);
    }
    return text;
}

Json occlusion_json(const Occlusion& sum)
{
    return Json::object({{"frames", sum.frames},
                         {"items", sum.items},
                         {"items_seen", sum.owners},
                         {"triangles", sum.triangles},
                         {"triangles_seen", sum.owner_triangles},
                         {"limit", sum.limit()}});
}

std::string info_json(Session& session, const InfoOptions& options, const Occlusion& path,
                      std::span<const Prospect> prospects, std::span<const Advice> advice)
{
    const SceneModel& model = session.model();
    Json cameras = Json::array();
    for (const Prospect& prospect : prospects) {
        Json camera = Json::object({{"kind", prospect.kind},
                                    {"does", prospect.what},
                                    {"pays", to_string(prospect.pays)},
                                    {"sentence", prospect.sentence()}});
        camera.update(occlusion_json(prospect.seen));
        cameras.push_back(std::move(camera));
    }
    Json changes = Json::array();
    for (const Advice& one : advice) {
        changes.push_back(Json::object({{"kind", one.kind},
                                        {"sentence", one.sentence},
                                        {"count", one.count},
                                        {"objects", Json::list(one.objects)}}));
    }
    Json on_path = Json::object({{"name", options.stage.path}, {"pays", to_string(judge(path))}});
    on_path.update(occlusion_json(path));
    const Json document = Json::object(
        {{"version", 1},
         {"scene",
          Json::object({{"name", model.name},
                        {"objects", model.instances.size()},
                        {"items", session.scene().items.size()},
                        {"triangles", drawn_triangles(model)},
                        {"file_triangles", model.file_triangles},
                        {"units_per_metre", model.unit},
                        {"up", Json::array({model.up.x, model.up.y, model.up.z})},
                        {"origin", Json::array({model.origin.x, model.origin.y, model.origin.z})},
                        {"notes", Json::list(model.load_notes)},
                        {"left_out", Json::list(model.load_losses)}})},
         {"size", Json::array({options.stage.size.x, options.stage.size.y})},
         {"path", std::move(on_path)},
         {"cameras", std::move(cameras)},
         {"conclusion", conclusion(prospects)},
         {"changes", std::move(changes)}});
    return document.dump(1) + "\n";
}

} // namespace

Result<int> info_command(const InfoOptions& options, const Streams& streams)
{
    if (const auto checked = check_one_hierarchy(options.stage); !checked) {
        return checked.error();
    }
    std::optional<OutputFile> json;
    if (!options.json.empty()) {
        auto file = OutputFile::open(options.json);
        if (!file) {
            return file.error();
        }
        json.emplace(std::move(*file));
    }
    const auto session = open_session(options.scene, options.stage, streams);
    if (!session) {
        return session.error();
    }
    const auto views = (*session)->views(options.stage.path);
    if (!views) {
        return views.error();
    }
    streams.out << contents_text(**session) << std::flush;
    constexpr double kPathShare = 0.25; // of the frames that are drawn
    Progress progress{streams.err, streams.watcher, "looking at " + (*session)->model().name};
    const Occlusion on_path = sample_occlusion(
        **session, *views, [&](double share) { progress.show(kPathShare * share); });
    streams.out << occlusion_text(on_path, options) << std::flush;
    const std::vector<Prospect> cameras =
        prospects(**session, options.stage.frames,
                  [&](double share) { progress.show(kPathShare + (1.0 - kPathShare) * share); });
    const std::vector<Advice> advice = advise((*session)->model(), options.stage.item_triangles);
    streams.out << prospects_text(cameras) << advice_text(advice);
    if (json) {
        const auto written = json->commit(info_json(**session, options, on_path, cameras, advice));
        if (!written) {
            return written.error();
        }
    }
    return kDone;
}

} // namespace occlude::tools
