#include "replay/run_recording.h"

#include "replay/byte_archive.h"
#include "replay/check_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace occlude::tools {

namespace {

constexpr std::string_view kMark = "occlrun3";
constexpr size_t kHashBytes = 8;

uint64_t hash_of(std::string_view bytes)
{
    uint64_t hash = 0xcbf29ce484222325ull; // FNV-1a
    for (const char c : bytes) {
        hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001b3ull;
    }
    return hash;
}

template <class Archive, class Box>
void transfer_box(Archive& archive, Box& box)
{
    for (int axis = 0; axis < 3; ++axis) {
        archive.number(box.min[axis]);
        archive.number(box.max[axis]);
    }
}

template <class Archive, class Matrix>
void transfer_matrix(Archive& archive, Matrix& matrix)
{
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            archive.number(matrix[column][row]);
        }
    }
}

template <class Archive, class Bounds>
void transfer_bounds(Archive& archive, Bounds& item)
{
    transfer_box(archive, item.box);
    archive.number(item.triangles);
    archive.choice(item.flags, ItemFlags{15});
}

template <class Archive, class OneNode>
void transfer_node(Archive& archive, OneNode& node)
{
    transfer_box(archive, node.box);
    archive.number(node.parent.value);
    archive.number(node.first_child.value);
    archive.number(node.child_count);
    archive.number(node.first_item);
    archive.number(node.own_items);
    archive.number(node.subtree_items);
    archive.number(node.subtree_triangles);
    archive.number(node.leaf);
}

template <class Archive, class Nodes>
void transfer_object_nodes(Archive& archive, Nodes& nodes)
{
    archive.list(nodes.object, [&](auto& object) { archive.number(object); });
    archive.list(nodes.box, [&](auto& box) { transfer_box(archive, box); });
    archive.list(nodes.key, [&](auto& key) { archive.number(key); });
    archive.list(nodes.frames, [&](auto& frame) {
        transfer_matrix(archive, frame.world_from_object);
        archive.choice(frame.oriented, true);
    });
    archive.number(nodes.key_count);
    archive.number(nodes.lineage);
}

template <class Archive, class Tree>
void transfer_tree(Archive& archive, Tree& tree)
{
    archive.text(tree.name);
    archive.list(tree.nodes, [&](auto& node) { transfer_node(archive, node); });
    archive.list(tree.items, [&](auto& item) { archive.number(item.value); });
    archive.list(tree.bounds, [&](auto& item) { transfer_bounds(archive, item); });
    transfer_object_nodes(archive, tree.object_nodes);
}

// The program's views are relative to their eyes (make_view() in scene/camera_path.h).
template <class Archive, class OneView>
void transfer_view(Archive& archive, OneView& view)
{
    glm::mat4 matrix{view.clip_from_relative()};
    glm::dvec3 origin = view.origin();
    glm::ivec2 size = view.size_px();
    ClipConvention convention = view.convention();
    ViewOptions options = view.options();
    transfer_matrix(archive, matrix);
    for (int axis = 0; axis < 3; ++axis) {
        archive.number(origin[axis]);
    }
    archive.number(size.x);
    archive.number(size.y);
    archive.choice(convention.range, DepthRange::zero_to_one);
    archive.choice(convention.order, DepthOrder::near_is_large);
    archive.number(options.viewport_origin_px.x);
    archive.number(options.viewport_origin_px.y);
    archive.number(options.tag);
    archive.choice(options.ignores_near_plane, true);
    if constexpr (Archive::kReads) {
        view = View::camera_relative(matrix, origin, size, convention, options);
    }
}

template <class Archive, class Run>
void transfer_run(Archive& archive, Run& run, std::string& device)
{
    archive.text(run.name);
    archive.text(run.algorithm);
    archive.list(run.options, [&](auto& option) {
        archive.text(option.first);
        archive.text(option.second);
    });
    archive.number(run.tree);
    archive.list(run.clock, [&](auto& seconds) { archive.number(seconds); });
    archive.list(run.owners, [&](auto& owners) {
        archive.list(owners, [&](auto& item) { archive.number(item.value); });
    });
    archive.list(run.decision_hashes, [&](auto& hash) { archive.number(hash); });
    archive.text(device);
}

template <class Archive, class Whole>
void transfer(Archive& archive, Whole& recording)
{
    archive.text(recording.scene);
    archive.list(recording.shapes, [&](auto& shape) {
        Shape boxes = shape ? *shape : Shape{};
        archive.list(boxes, [&](auto& box) { transfer_box(archive, box); });
        if constexpr (Archive::kReads) {
            shape = std::make_shared<const Shape>(std::move(boxes));
        }
    });
    archive.list(recording.placed_shapes, [&](auto& placed) {
        archive.number(placed.item.value);
        archive.number(placed.shape);
        transfer_matrix(archive, placed.world_from_shape);
    });
    archive.list(recording.trees, [&](auto& tree) { transfer_tree(archive, tree); });
    archive.list(recording.views, [&](auto& view) { transfer_view(archive, view); });
}

/// A sentence about parts that do not fit together, or nothing.
std::string inconsistency(const RunRecording& recording)
{
    for (const RecordedTree& tree : recording.trees) {
        const auto fits = [&](size_t count) {
            return tree.object_nodes.empty() ? count == 0 : count == tree.nodes.size();
        };
        if (tree.nodes.empty() || tree.items.size() != tree.bounds.size() ||
            !fits(tree.object_nodes.object.size()) || !fits(tree.object_nodes.box.size()) ||
            !fits(tree.object_nodes.key.size())) {
            return "has a tree whose lists do not belong together";
        }
        for (size_t node = 0; node < tree.object_nodes.object.size(); ++node) {
            const uint32_t object = tree.object_nodes.object[node];
            if ((object != ObjectNodes::kScene && object >= tree.object_nodes.frames.size()) ||
                tree.object_nodes.key[node] >= tree.object_nodes.key_count ||
                tree.object_nodes.key_count > 16 * tree.nodes.size() + 1024) {
                return "names an object of a node that does not exist";
            }
        }
    }
    constexpr uint32_t kMostItems = 1u << 28;
    for (const RecordedShape& placed : recording.placed_shapes) {
        if (placed.shape >= recording.shapes.size() || placed.item.value >= kMostItems) {
            return "places a shape that does not exist";
        }
    }
    for (const RecordedRun& run : recording.runs) {
        if (run.tree >= recording.trees.size() ||
            run.decision_hashes.size() != recording.views.size() ||
            (!run.owners.empty() && run.owners.size() != recording.views.size())) {
            return "has a run that does not fit its tree or its cameras";
        }
    }
    return {};
}

} // namespace

Result<std::string> to_bytes(const RunRecording& recording)
{
    ByteWriter writer;
    writer.bytes = kMark;
    transfer(writer, recording);
    uint64_t runs = recording.runs.size();
    writer.number(runs);
    for (const RecordedRun& run : recording.runs) {
        std::ostringstream stream;
        if (const auto saved = save_recording(run.device, stream); !saved) {
            return saved.error();
        }
        std::string device = stream.str();
        transfer_run(writer, run, device);
    }
    const uint64_t hash = hash_of(writer.bytes);
    writer.number(hash);
    return std::move(writer.bytes);
}

Result<RunRecording> from_bytes(std::string_view bytes, const std::string& name)
{
    const auto broken = [&](std::string_view how) {
        return Error{
            ErrorCode::bad_data,
            fmt::format("{}: it {}; record it again with 'occlude bench --record'", name, how)};
    };
    if (!bytes.starts_with(kMark)) {
        return broken("is not a recording of this version");
    }
    if (bytes.size() < kMark.size() + kHashBytes) {
        return broken("is cut off");
    }
    const std::string_view body = bytes.substr(0, bytes.size() - kHashBytes);
    ByteReader end{bytes.substr(body.size())};
    uint64_t hash = 0;
    end.number(hash);
    if (hash != hash_of(body)) {
        return broken("is cut off or was changed");
    }
    ByteReader reader{body.substr(kMark.size())};
    RunRecording recording;
    transfer(reader, recording);
    uint64_t runs = 0;
    reader.number(runs);
    for (uint64_t i = 0; i < runs && !reader.failed(); ++i) {
        RecordedRun& run = recording.runs.emplace_back();
        std::string device;
        transfer_run(reader, run, device);
        std::istringstream stream{device};
        auto loaded = load_recording(stream);
        if (!loaded) {
            return broken("holds an invalid device recording");
        }
        run.device = std::move(*loaded);
    }
    if (reader.failed() || !reader.at_end()) {
        return broken("holds invalid data");
    }
    if (const std::string problem = inconsistency(recording); !problem.empty()) {
        return broken(problem);
    }
    for (const RecordedTree& tree : recording.trees) {
        if (const std::string problem = check_tree(tree); !problem.empty()) {
            return broken("has a broken tree: " + problem);
        }
    }
    return recording;
}

} // namespace occlude::tools
