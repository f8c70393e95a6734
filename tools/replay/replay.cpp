#include "replay/replay.h"

#include <occlude/core/clock.h>
#include <occlude/cull/registry.h>
#include <occlude/device/recording_device.h>
#include <occlude/device/replay_device.h>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>

namespace occlude::tools {

namespace {

Hierarchy tree_of(const RecordedTree& recorded)
{
    Hierarchy tree =
        Hierarchy::from_finished_arrays(recorded.nodes, recorded.items, recorded.bounds);
    if (!recorded.object_nodes.empty()) {
        tree.set_object_nodes(recorded.object_nodes);
    }
    return tree;
}

RecordedTree recorded_tree(const Hierarchy& tree, const std::string& name)
{
    return {name,
            {tree.nodes().begin(), tree.nodes().end()},
            {tree.items().begin(), tree.items().end()},
            {tree.item_bounds().begin(), tree.item_bounds().end()},
            tree.object_nodes()};
}

void keep_shapes(const ItemShapes& shapes, std::span<const ItemBounds> items,
                 RunRecording& recording)
{
    std::map<const Shape*, uint32_t> known;
    for (size_t i = 0; i < items.size(); ++i) {
        const ItemShapes::Placed* placed = shapes.find(ItemId{i});
        if (placed == nullptr) {
            continue;
        }
        const auto [entry, added] =
            known.try_emplace(placed->shape.get(), static_cast<uint32_t>(known.size()));
        if (added) {
            recording.shapes.push_back(placed->shape);
        }
        recording.placed_shapes.push_back({ItemId{i}, entry->second, placed->world_from_shape});
    }
}

ItemShapes shapes_of(const RunRecording& recording)
{
    ItemShapes shapes;
    for (const RecordedShape& placed : recording.placed_shapes) {
        shapes.place(placed.item, recording.shapes[placed.shape], placed.world_from_shape);
    }
    return shapes;
}

/// The index of a tree among those of the recording.
uint32_t tree_index(const Hierarchy& tree, const std::string& name,
                    std::map<const Hierarchy*, uint32_t>& known, RunRecording& recording)
{
    const auto [entry, added] = known.try_emplace(&tree, static_cast<uint32_t>(known.size()));
    if (added) {
        recording.trees.push_back(recorded_tree(tree, name));
    }
    return entry->second;
}

Result<RecordedRun> record_run(const Stage& stage, const RunToRecord& wanted,
                               std::span<const View> views)
{
    RecordedRun run;
    run.name = wanted.name;
    run.algorithm = wanted.algorithm;
    run.options = wanted.options;
    const Hierarchy& tree = *wanted.tree;
    auto culler =
        make_culler(run.algorithm, tree, run.options, [&run, clock = steady_seconds_clock()] {
            return run.clock.emplace_back(clock());
        });
    if (!culler) {
        return culler.error();
    }
    RecordingDevice device{stage.renderer.device()};
    for (size_t frame = 0; frame < views.size(); ++frame) {
        if (needs_answer(**culler)) {
            const std::vector<ItemId> items = items_in_frustum(views[frame], stage.item_bounds);
            run.owners.push_back(owners_of_pixels(stage.renderer.render_ids(views[frame], items)));
            record_answer(**culler, views[frame], device, run.owners.back());
        }
        (*culler)->cull(views[frame], device);
        run.decision_hashes.push_back((*culler)->decisions().hash(tree, frame));
    }
    run.device = device.recording();
    return run;
}

} // namespace

Result<RunRecording> record(const Stage& stage, const std::string& scene,
                            std::span<const RunToRecord> runs, std::span<const View> views,
                            const ProgressCallback& progress)
{
    if (stage.go_to) {
        return Error{ErrorCode::unsupported,
                     fmt::format("--record: '{}' moves; recordings hold static scenes", scene)};
    }
    RunRecording recording;
    recording.scene = scene;
    recording.views.assign(views.begin(), views.end());
    if (const ItemShapes* shapes = stage.hierarchy.shapes(); shapes != nullptr) {
        keep_shapes(*shapes, stage.item_bounds, recording);
    }
    std::map<const Hierarchy*, uint32_t> known_trees;
    for (const RunToRecord& wanted : runs) {
        auto run = record_run(stage, wanted, views);
        if (!run) {
            return run.error();
        }
        run->tree = tree_index(*wanted.tree, wanted.tree_name, known_trees, recording);
        recording.runs.push_back(std::move(*run));
        if (progress) {
            progress(static_cast<double>(recording.runs.size()) / static_cast<double>(runs.size()));
        }
    }
    return recording;
}

Result<ReplayedRun> replay(const RunRecording& recording, const RecordedRun& run,
                           const ProgressCallback& progress)
{
    Hierarchy tree = tree_of(recording.trees[run.tree]);
    const ItemShapes shapes = shapes_of(recording);
    if (!shapes.empty()) {
        tree.set_shapes(&shapes);
    }
    size_t next_reading = 0;
    const auto clock = [&run, &next_reading] {
        const size_t reading = next_reading++;
        return reading < run.clock.size() ? run.clock[reading]
               : run.clock.empty()        ? 0.0
                                          : run.clock.back();
    };
    auto culler = make_culler(run.algorithm, tree, run.options, clock);
    if (!culler) {
        return Error{culler.error().code, fmt::format("{}: {}", run.name, culler.error().message)};
    }
    ReplayDevice device{run.device};
    ReplayedRun replayed{run.name, recording.trees[run.tree].name, 0, 0, {}};
    for (size_t frame = 0; frame < recording.views.size(); ++frame) {
        const View& view = recording.views[frame];
        if (frame < run.owners.size()) {
            record_answer(**culler, view, device, run.owners[frame]);
        }
        (*culler)->cull(view, device);
        replayed.items_drawn += (*culler)->drawn_items().size();
        if (!device.mismatch().empty()) {
            replayed.mismatch = fmt::format("frame {}: {}", frame, device.mismatch());
            return replayed;
        }
        if ((*culler)->decisions().hash(tree, frame) != run.decision_hashes[frame]) {
            replayed.mismatch = fmt::format("frame {}: it decided differently", frame);
            return replayed;
        }
        ++replayed.frames;
        if (progress) {
            progress(static_cast<double>(replayed.frames) /
                     static_cast<double>(recording.views.size()));
        }
    }
    if (!device.complete()) {
        replayed.mismatch = "it made fewer calls than the recording";
    }
    return replayed;
}

} // namespace occlude::tools
