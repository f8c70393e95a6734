// The calls of a device and their answers, and their binary form.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/core/result.h>
#include <occlude/core/view.h>
#include <occlude/device/device_verb.h>

#include <iosfwd>
#include <optional>
#include <vector>

namespace occlude {

struct RecordedBox {
    Aabb box;
    std::optional<glm::mat4> world_from_box;
    NodeId subject;
};

/// One call of a verb; only the fields of that verb are filled. Tests are numbered in the order in
/// which they were issued, independent of their tickets.
struct RecordedCall {
    static constexpr uint32_t kNoTest = 0xffffffffu; ///< an invalid, spent or foreign ticket

    // The input.
    DeviceVerb verb = DeviceVerb::flush;
    DrawPass pass = DrawPass::shade;
    TestMethod method = TestMethod::automatic;
    glm::mat4 clip_from_world{0.0f}; ///< these six fields make a View
    glm::dmat4 clip_from_relative{0.0};
    glm::dvec3 origin{0.0};
    glm::ivec2 size_px{0};
    ClipConvention convention;
    ViewOptions view_options;
    std::vector<ItemId> items;
    std::vector<RecordedBox> boxes;
    std::vector<uint32_t> test_ends;
    uint32_t asked_test = kNoTest; ///< by poll and wait
    PixelRect rect;
    int tile_px = 0;

    // The output.
    std::vector<uint32_t> issued_tests; ///< kNoTest if the ticket was invalid
    Answer answer;
    std::vector<float> depth;           ///< empty if it could not be read
    std::optional<DeviceCaps> new_caps; ///< by begin_frame, if it changed them
};

struct Recording {
    DeviceCaps caps; ///< before the first frame; a device may change its caps in begin_frame
    std::vector<RecordedCall> calls;

    /// A hash of the calls and their answers, the same on every machine. Leaves out caps, which
    /// hold names and costs.
    uint64_t hash() const;
};

/// Writes a compact binary form; returns its size in bytes. Error: the stream failed.
Result<size_t> save_recording(const Recording& recording, std::ostream& out);

/// Reads a recording that save_recording() wrote. Error: it is cut off, changed, or not a
/// recording.
Result<Recording> load_recording(std::istream& in);

} // namespace occlude
