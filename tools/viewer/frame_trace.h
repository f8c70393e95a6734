// What an algorithm said to the device in one frame and when, for time lines and explanations.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/core/query_device.h>
#include <occlude/device/device_verb.h>

#include <map>
#include <span>
#include <vector>

namespace occlude::tools::viewer {

/// One test: the nodes whose boxes it covered, and its answer.
struct TracedTest {
    std::vector<NodeId> subjects = {};
    std::vector<Aabb> boxes = {}; ///< as tested; world space, or the world box of an oriented one
    TestMethod method = TestMethod::automatic;
    double issued_s = 0.0;
    double answered_s = 0.0; ///< 0: not yet
    AnswerState state = AnswerState::pending;
    uint64_t samples = Answer::kUnknownSamples;

    /// An answer that came and found nothing.
    bool found_nothing() const { return state == AnswerState::ready && samples == 0; }
};

/// One call of a verb.
struct TracedCall {
    DeviceVerb verb = DeviceVerb::flush;
    double begin_s = 0.0;
    double end_s = 0.0;
    uint32_t items = 0;      ///< of draws
    uint32_t first_test = 0; ///< of queries: into FrameTrace::tests
    uint32_t test_count = 0;
    PixelRect rect = {}; ///< of read_depth
};

struct FrameTrace {
    uint64_t frame = 0; ///< of the viewer
    double begin_s = 0.0;
    double end_s = 0.0;
    std::vector<TracedCall> calls; ///< polls that found nothing are left out
    std::vector<TracedTest> tests;
};

/// Passes everything through to a device and keeps a trace of each frame. Answers that come in a
/// later frame are entered there too, in the trace of that frame, as a call.
class TraceDevice final : public QueryDevice {
public:
    explicit TraceDevice(SecondsClock clock)
        : clock_(std::move(clock))
    {
    }

    /// The device of the frames to come; it outlives them.
    void set_inner(QueryDevice& inner) { inner_ = &inner; }
    /// Starts a trace, which receives everything until the next begin(). It outlives that.
    void begin(FrameTrace& trace, uint64_t frame);
    /// Seconds that tracing itself has taken since begin(): no part of the frame.
    double overhead_s() const { return overhead_s_; }
    /// Forgets tickets of earlier frames: their tests are not told apart any more.
    void forget() { pending_.clear(); }

    const DeviceCaps& caps() const override { return inner_->caps(); }
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    bool read_depth_tiles(int tile_px, std::span<float> out) override;
    void end_frame() override;

private:
    TracedCall& add(DeviceVerb verb);
    void note_answer(Ticket ticket, const Answer& answer);

    SecondsClock clock_;
    QueryDevice* inner_ = nullptr;
    FrameTrace* trace_ = nullptr;
    double overhead_s_ = 0.0;
    std::map<Ticket, TracedTest> pending_; ///< with everything that is known before the answer
    std::map<Ticket, uint32_t> places_;    ///< of tests of this frame, in FrameTrace::tests
};

} // namespace occlude::tools::viewer
