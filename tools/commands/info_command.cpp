#include "commands/commands.h"
#include "commands/open_session.h"
#include "measure/statistics.h"
#include "report/table.h"
#include "session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <set>

namespace occlude::tools {

namespace {

// What the frames of a path show, summed over them.
struct Occlusion {
    uint64_t items = 0; ///< in the frustum
    uint64_t owners = 0;
    uint64_t triangles = 0;
    uint64_t owner_triangles = 0;
};

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

Occlusion sample_occlusion(Session& session, std::span<const View> views, Progress& progress)
{
    Occlusion sum;
    const Stage stage = session.stage();
    for (size_t frame = 0; frame < views.size(); ++frame) {
        set_frame(stage, frame);
        const std::vector<ItemId> items = items_in_frustum(views[frame], stage.item_bounds);
        const std::vector<ItemId> owners =
            owners_of_pixels(stage.renderer.render_ids(views[frame], items));
        sum.items += items.size();
        sum.owners += owners.size();
        for (const ItemId item : items) {
            sum.triangles += stage.item_bounds[item.value].triangles;
        }
        for (const ItemId item : owners) {
            sum.owner_triangles += stage.item_bounds[item.value].triangles;
        }
        progress.show(static_cast<double>(frame + 1) / static_cast<double>(views.size()));
    }
    return sum;
}

double percent(uint64_t part, uint64_t whole)
{
    return 100.0 * static_cast<double>(part) / static_cast<double>(std::max<uint64_t>(whole, 1));
}

std::string recommendation(double best, double triangles_per_frame)
{
    // Below this a whole frame costs less than the tests that would make it cheaper.
    constexpr double kSmallFrame = 50000.0;
    constexpr double kWorthIt = 2.0;
    constexpr double kMaybe = 1.25;
    if (triangles_per_frame < kSmallFrame) {
        return "Culling is unlikely to pay: frames are so small that tests would cost about as "
               "much as drawing.";
    }
    if (best >= kWorthIt) {
        return "Culling is likely to pay: most of what is in the frustum is hidden. Measure it "
               "with 'occlude bench'.";
    }
    if (best >= kMaybe) {
        return "Culling may pay a little; measure it with 'occlude bench' before relying on it.";
    }
    return "Culling is unlikely to pay on this path: nearly everything in the frustum is seen. "
           "Smaller items (--item-triangles) or another path may show otherwise.";
}

std::string occlusion_text(const Occlusion& sum, const InfoOptions& options, size_t frames)
{
    const double best = static_cast<double>(sum.triangles) /
                        static_cast<double>(std::max<uint64_t>(sum.owner_triangles, 1));
    const double per_frame = static_cast<double>(sum.triangles) / static_cast<double>(frames);
    if (sum.owner_triangles == 0) {
        return fmt::format("\npath {}, {} frames: nothing of the scene is in view; choose another "
                           "--path\n",
                           options.stage.path, frames);
    }
    return fmt::format("\npath {}, {} frames at {}x{}: {:.1f}% of the items in the frustum own a "
                       "pixel,\nand {:.1f}% of the triangles are theirs. "
                       "Where triangles are what costs, no culling can be\nmore than {:.1f} times "
                       "faster than frustum culling here.\n{}\n",
                       options.stage.path, frames, options.stage.size.x, options.stage.size.y,
                       percent(sum.owners, sum.items), percent(sum.owner_triangles, sum.triangles),
                       best, recommendation(best, per_frame));
}

} // namespace

Result<int> info_command(const InfoOptions& options, const Streams& streams)
{
    if (const auto checked = check_one_hierarchy(options.stage); !checked) {
        return checked.error();
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
    Progress progress{streams.err, streams.watcher, "looking at " + (*session)->model().name};
    const Occlusion sum = sample_occlusion(**session, *views, progress);
    streams.out << occlusion_text(sum, options, views->size());
    return kDone;
}

} // namespace occlude::tools
