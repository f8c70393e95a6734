// The file that `bench --record` writes and `replay` reads: the tree, the boxes and shapes of the
// items, the cameras, and for each algorithm its calls to the device, the answers, the clock and
// the decisions. With it, a run repeats bit by bit on a machine that has neither the scene nor the
// graphics card.
//
// The format: a mark with the version, fields, and a hash of all bytes before it. Numbers are
// little-endian. Everything is checked when it is read: a file that is cut off, changed, made by
// another version or hostile is an error with a sentence.
#pragma once

#include <occlude/core/option_text.h>
#include <occlude/core/result.h>
#include <occlude/core/view.h>
#include <occlude/device/recording.h>
#include <occlude/hierarchy/hierarchy.h>
#include <occlude/hierarchy/item_shapes.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace occlude::tools {

/// The placement of an item's shape in a recording.
struct RecordedShape {
    ItemId item;
    uint32_t shape = 0; ///< into RunRecording::shapes
    glm::mat4 world_from_shape{1.0f};
};

/// One tree, standing still.
struct RecordedTree {
    std::string name; ///< as in --hierarchy
    std::vector<Node> nodes;
    std::vector<ItemId> items;
    std::vector<ItemBounds> bounds;
    ObjectNodes object_nodes;
};

/// One algorithm on one of the trees.
struct RecordedRun {
    std::string name;      ///< as in tables
    std::string algorithm; ///< as in the registry
    std::vector<OptionValue> options;
    uint32_t tree = 0;                       ///< into RunRecording::trees
    std::vector<double> clock;               ///< the clock, call by call
    std::vector<std::vector<ItemId>> owners; ///< per frame: the argument of record_answer()
    std::vector<uint64_t> decision_hashes;   ///< per frame
    Recording device;
};

struct RunRecording {
    std::string scene;
    std::vector<std::shared_ptr<const Shape>> shapes;
    std::vector<RecordedShape> placed_shapes;
    std::vector<RecordedTree> trees;
    std::vector<View> views;
    std::vector<RecordedRun> runs;
};

/// The file's content. Error: a device recording cannot be written.
Result<std::string> to_bytes(const RunRecording& recording);

/// `name` is the name of the file, for errors. The result satisfies everything that replay() relies
/// on.
Result<RunRecording> from_bytes(std::string_view bytes, const std::string& name);

} // namespace occlude::tools
