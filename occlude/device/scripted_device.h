// A QueryDevice that draws nothing and answers from a script, with any latency. So the behaviour of
// an algorithm for given answers can be worked out by hand and compared, verb by verb, as text.
//
// Time is counted in polls. Every poll(), of any ticket, advances the clock of all pending tests by
// one. So a test can complete while a traversal polls another one, and tests with different
// latencies complete out of order. A test of latency n is pending for the first n polls after it
// was issued, of whichever ticket, and is then ready for good.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/core/ticket_table.h>
#include <occlude/device/device_verb.h>

#include <functional>
#include <string>
#include <vector>

namespace occlude {

/// Whether a test is answered, and when.
struct Latency {
    enum class Fate : uint8_t {
        answered, ///< ready after `polls` polls and `frames` frames; wait() gets the answer at any
                  ///< time
        never,    ///< poll() answers pending for ever; wait() gets the answer
        lost,     ///< like `answered`, but the answer is lost, also from wait()
    };

    uint32_t polls = 0;  ///< polls of any ticket since the test was issued
    uint32_t frames = 0; ///< calls of end_frame() since the test was issued
    Fate fate = Fate::answered;

    static Latency after_polls(uint32_t polls) { return {polls, 0, Fate::answered}; }
    static Latency after_frames(uint32_t frames) { return {0, frames, Fate::answered}; }
    static Latency never() { return {0, 0, Fate::never}; }
    static Latency lost(uint32_t polls = 0) { return {polls, 0, Fate::lost}; }
};

/// The samples of the union of the boxes of one test. Called when the test is issued, so that it
/// can look at ScriptedDevice::items_drawn_this_frame().
using BoxScript = std::function<uint64_t(std::span<const QueryBox>)>;

/// Answers by subject: `samples` if `visible` has the subject of any box of the test, else 0.
BoxScript visible_subjects(std::vector<NodeId> visible, uint64_t samples = 1000);

/// The capabilities and answers of a ScriptedDevice. An empty function has the default named beside
/// it.
struct DeviceScript {
    BoxScript boxes = {};                                                ///< everything is visible
    std::function<uint64_t(std::span<const ItemId>)> items = {};         ///< 1000 samples per item
    std::function<Latency(uint64_t test_index)> latency = {};            ///< ready at once
    std::function<bool(const PixelRect&, std::span<float>)> depth = {};  ///< all far: 1
    std::function<bool(int tile_px, std::span<float>)> depth_tiles = {}; ///< all far: 1
    DeviceCaps caps{.name = "scripted", .methods = {TestCost{}}};
};

class ScriptedDevice final : public QueryDevice {
public:
    using Verb = DeviceVerb;

    /// One call. Only the fields of that verb are filled.
    struct Event {
        uint64_t frame = 0; ///< counts begin_frame() from 0
        Verb verb = Verb::flush;
        DrawPass pass = DrawPass::shade;
        TestMethod method = TestMethod::automatic;
        std::vector<ItemId> items;
        std::vector<NodeId> subjects;    ///< of all boxes, in order
        std::vector<uint32_t> test_ends; ///< as in QueryBatch
        std::vector<Ticket> tickets;
        Answer answer;
        PixelRect rect;
        int tile_px = 0;
    };

    explicit ScriptedDevice(DeviceScript script = {})
        : script_(std::move(script))
    {
    }

    /// The script. It may be changed at any time, and applies to tests issued after that.
    DeviceScript& script() { return script_; }

    const DeviceCaps& caps() const override { return script_.caps; }
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;

    /// A test beyond caps().max_outstanding gets an invalid ticket, which answers lost.
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override;
    Answer poll(Ticket ticket) override;

    /// Without caps().same_frame_results, waiting in the frame of the test answers lost.
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

    const std::vector<Event>& trace() const { return trace_; }
    void clear_trace() { trace_.clear(); }

    /// The trace, one line per call. Tests are named by the subjects of their boxes, tests of
    /// draw_and_query by their items; "?" is an unknown subject or ticket.
    ///
    ///   frame 0
    ///   draw 3 4                     draw depth_only 3 4
    ///   query [7] [8 9]              query raster [7]
    ///   draw_and_query 5
    ///   flush
    ///   poll 7 pending               poll 8 9 -> 0
    ///   wait item 5 -> 1000          wait ? -> lost
    ///   read_depth 0 0 64x32          read_depth_tiles 8
    ///   end
    std::string trace_text() const;

    /// The lines of one frame, without "frame" and "end".
    std::string frame_text(uint64_t frame) const;

    /// The items drawn since begin_frame(), in draw order. An item drawn in two passes comes twice.
    std::span<const ItemId> items_drawn_this_frame() const { return drawn_; }

    /// How many tickets were given out and are unspent.
    uint32_t outstanding() const { return tests_.size(); }

private:
    struct Test {
        uint64_t samples = 0;
        uint64_t ready_at_poll = 0;
        uint64_t ready_at_frame = 0; ///< in frames ended
        uint64_t issued_in_frame = 0;
        Latency::Fate fate = Latency::Fate::answered;
        std::vector<NodeId> subjects;
        std::vector<ItemId> items;
    };

    Event& record(Verb verb);
    Ticket issue(Test test);
    Answer spend(Ticket ticket, const Test& test);
    Answer record_answer(Verb verb, Ticket ticket, Answer answer, const Test* test);

    DeviceScript script_;
    TicketTable<Test> tests_;
    std::vector<Event> trace_;
    std::vector<ItemId> drawn_;
    uint64_t frames_begun_ = 0;
    uint64_t frames_ended_ = 0;
    uint64_t polls_ = 0;
    uint64_t tests_issued_ = 0;
};

/// The line of trace_text() for one event, without a line end.
std::string to_string(const ScriptedDevice::Event& event);

} // namespace occlude
