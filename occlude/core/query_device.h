// The seam between the culling algorithms and the renderer: one in-order stream of verbs.
//
// An engine implements QueryDevice, or wraps one of the backends around its draw callback. The
// algorithms in cull/ talk only to this interface.
//
// Required: caps, begin_frame, draw, query, flush, poll, wait, end_frame.
// Optional: draw_and_query (caps.draw_and_query), read_depth (caps.read_depth), read_depth_tiles
// (caps.depth_reads).
//
// The contract. ValidatingDevice asserts each line by its name:
//   C1  Frames do not nest: begin_frame, verbs, end_frame. Only poll and wait may come outside.
//   C2  Verbs take effect in call order. A test sees exactly the depth of the draws before it.
//   C3  A test counts at least one sample if any sample inside its boxes could be seen. It may
//   count
//       more samples than the contents of the boxes show, because boxes are a superset.
//   C4  A test writes nothing: neither colour nor depth.
//   C5  Boxes are bounded and do not touch the near rectangle (View::touches_near is false).
//   C6  A test has at least one box. Boxes of one test may overlap; they count as one union.
//   C7  A ticket is spent by the first poll or wait that answers ready or lost. A spent, foreign or
//       overwritten ticket answers lost, which reads as visible.
//   C8  A failed, lost or expired test answers lost: "visible". It never answers 0 samples.
//   C9  poll never blocks. wait returns ready or lost, never pending.
//   C10 An item is drawn at most once per frame and pass.
//   C11 At most caps.max_outstanding tickets are unspent at any time; a test beyond that is lost.
//   C12 end_frame may come while tickets are unspent; they stay valid in later frames.
#pragma once

#include <occlude/core/aabb.h>
#include <occlude/core/ids.h>
#include <occlude/core/pixel_rect.h>
#include <occlude/core/tiles.h>
#include <occlude/core/view.h>

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace occlude {

/// How a device answers a test. A batch may name one of caps.methods; `automatic` is the device's
/// default. Only `queries` counts samples; the others answer 0 or 1. If a threshold above 0
/// decides, ask for queries.
enum class TestMethod : uint8_t {
    automatic,
    queries, ///< one hardware occlusion query per test
    raster,  ///< all boxes rasterised into a flag buffer in one draw
    pyramid, ///< depth read back and tested on the CPU
};
/// "automatic", "queries", "raster" or "pyramid".
const char* name(TestMethod method);

/// The purpose of a draw.
enum class DrawPass : uint8_t {
    shade,       ///< colour and depth
    depth_only,  ///< depth now; the same items come again with `shade_equal`
    shade_equal, ///< colour of items whose depth is already there (compare EQUAL, write no depth)
};

/// A device's own estimate of the cost of a test method, in microseconds. It is used until the
/// costs are measured.
struct TestCost {
    TestMethod method = TestMethod::queries;
    float us_per_batch = 0.0f;
    float us_per_test = 0.0f;
    float us_per_box = 0.0f;
    bool exact_counts = true; ///< counts samples; otherwise a visible test counts 1
};

/// A device's own estimate of the cost of reading depth in tiles of one size, in microseconds: the
/// sum of three parts. It is used until the costs are measured.
struct DepthReadCost {
    int tile_px = 1;           ///< 1: read_depth. A power of two above 1: read_depth_tiles.
    float us_per_read = 0.0f;  ///< of the call itself, including the wait for the device
    float us_per_pixel = 0.0f; ///< of each pixel of the target, for its reduction on the device
    float us_per_value = 0.0f; ///< of each value that comes back

    /// The cost of one read of a whole target of this size.
    float us(glm::ivec2 size_px) const;
};

struct DeviceCaps {
    std::string name;
    bool same_frame_results = true; ///< wait() can answer in the frame of the test
    bool exact_counts = true;       ///< exact sample counts by the default method; otherwise 0 or 1
    bool draw_and_query = false;    ///< draw_and_query() works
    bool read_depth = false;        ///< read_depth() works
    /// True if the target of this frame has one sample per pixel, in its middle. Otherwise samples
    /// are assumed to be anywhere in their pixel.
    bool samples_at_pixel_centers = false;
    uint32_t max_outstanding = 4096;
    std::vector<TestCost> methods = {}; ///< the available test methods, the default first
    float us_per_triangle = 0.15f;
    float us_per_item = 4.0f; ///< of a draw, in addition to its triangles
    /// The tile sizes in which depth can be read, ascending; read_depth is the size 1. May be empty
    /// although read_depth works.
    std::vector<DepthReadCost> depth_reads = {};

    /// The entry of that method in `methods`, or null if the device does not have it.
    const TestCost* find_method(TestMethod method) const;
    /// Makes `method` the first of `methods` (`automatic`: queries) and sets exact_counts for it.
    /// Returns false and changes nothing if the device does not have it.
    bool make_default(TestMethod method);
    /// The entry of that tile size in `depth_reads`, or null if the device cannot read such tiles.
    const DepthReadCost* find_depth_read(int tile_px) const;
};

/// One box of a test. The box is in the space of `world_from_box`, or in world space if that is
/// null. Already inflated (View::inflated_for_test).
struct QueryBox {
    Aabb box;
    const glm::mat4* world_from_box = nullptr; ///< must live until query() returns
    NodeId subject; ///< the tested node, for logs, scripts and error messages; the device ignores
                    ///< it
};

/// Several tests with one change of state. Test i covers boxes [test_ends[i-1], test_ends[i]).
struct QueryBatch {
    std::span<const QueryBox> boxes;
    std::span<const uint32_t> test_ends;
    TestMethod method = TestMethod::automatic;
};

enum class AnswerState : uint8_t {
    pending, ///< not known yet (poll only)
    ready,   ///< `samples` is the count, or 1 if counts are not exact
    lost,    ///< the device will never know: counts as visible
};

struct Answer {
    static constexpr uint64_t kUnknownSamples = std::numeric_limits<uint64_t>::max();

    AnswerState state = AnswerState::lost;
    uint64_t samples =
        kUnknownSamples; ///< kUnknownSamples unless ready, so that it reads as visible

    static Answer pending() { return {AnswerState::pending, kUnknownSamples}; }
    static Answer lost() { return {}; }
    static Answer ready(uint64_t samples) { return {AnswerState::ready, samples}; }
};

class QueryDevice {
public:
    virtual ~QueryDevice() = default;

    virtual const DeviceCaps& caps() const = 0;

    /// Starts a frame: the camera is `view`, the target is cleared. Query pools may be reset here.
    virtual void begin_frame(const View& view) = 0;

    /// Draws the items, in this or any better order. The items come in one call, so that the engine
    /// can sort them by state.
    virtual void draw(std::span<const ItemId> items, DrawPass pass) = 0;

    /// Tests every union of boxes in `batch` against the depth of all draws so far, and writes one
    /// ticket per test. Precondition: tickets.size() == batch.test_ends.size().
    virtual void query(const QueryBatch& batch, std::span<Ticket> tickets) = 0;

    /// Draws the items and counts the samples that passed while drawing.
    virtual Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass);

    /// Starts everything recorded so far.
    virtual void flush() = 0;

    /// The answer, if it has arrived. Never blocks; spends the ticket unless the answer is pending.
    virtual Answer poll(Ticket ticket) = 0;

    /// The answer; blocks until it arrives. Spends the ticket.
    virtual Answer wait(Ticket ticket) = 0;

    /// Reads window depth of the draws so far, 0 (near) to 1 (far) in every convention: the
    /// farthest sample of each pixel, row by row from the bottom. Blocks. Returns false and leaves
    /// `out` untouched if the device cannot. Preconditions: rect inside the target; out.size() ==
    /// width * height.
    virtual bool read_depth(const PixelRect& rect, std::span<float> out);

    /// Reads the farthest depth, as read_depth reports it, of each tile of tile_px x tile_px pixels
    /// of the whole target, tile by tile from the lower left. Tile (x, y) begins at pixel (x, y) *
    /// tile_px; the edge of the target cuts off the last tiles of a row or column. A device that
    /// rounds must round towards far. Blocks. Returns false and leaves `out` untouched if the
    /// device cannot. Preconditions: tile_px is a power of two; out.size() is the number of
    /// tiles_in the target.
    virtual bool read_depth_tiles(int tile_px, std::span<float> out);

    virtual void end_frame() = 0;
};

inline Ticket QueryDevice::draw_and_query(std::span<const ItemId> items, DrawPass pass)
{
    draw(items, pass);
    return Ticket{}; // answers lost, which counts as visible
}

inline bool QueryDevice::read_depth(const PixelRect&, std::span<float>)
{
    return false;
}

inline bool QueryDevice::read_depth_tiles(int, std::span<float>)
{
    return false;
}

} // namespace occlude
