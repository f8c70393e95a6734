// Records everything that is said to a device and what it answers, and answers from such a
// recording: a run on real hardware becomes a test that needs none.
#pragma once

#include <occlude/core/query_device.h>
#include <occlude/core/result.h>
#include <occlude/core/ticket_table.h>
#include <occlude/device/device_verb.h>

#include <iosfwd>
#include <map>
#include <optional>

namespace occlude {

struct RecordedBox {
    Aabb box;
    std::optional<glm::mat4> world_from_box;
    NodeId subject;
};

/// One call of a verb; only the fields that the verb has are filled. Tests are numbered in the
/// order they were issued, whatever their tickets.
struct RecordedCall {
    static constexpr uint32_t kNoTest = 0xffffffffu; ///< an invalid, spent or foreign ticket

    // What was asked.
    DeviceVerb verb = DeviceVerb::flush;
    DrawPass pass = DrawPass::shade;
    TestMethod method = TestMethod::automatic;
    glm::mat4 clip_from_world{0.0f};
    glm::ivec2 size_px{0};
    ClipConvention convention;
    std::vector<ItemId> items;
    std::vector<RecordedBox> boxes;
    std::vector<uint32_t> test_ends;
    uint32_t asked_test = kNoTest; ///< by poll and wait
    PixelRect rect;

    // What came back.
    std::vector<uint32_t> issued_tests; ///< kNoTest where the ticket was invalid
    Answer answer;
    std::vector<float> depth; ///< empty if it could not be read
};

struct Recording {
    DeviceCaps caps;
    std::vector<RecordedCall> calls;

    /// A hash of the calls and what came back, the same on every machine. The caps, which hold
    /// names and costs, do not count.
    uint64_t hash() const;
};

/// Writes a compact binary form; returns its size in bytes. Error: the stream failed.
Result<size_t> save_recording(const Recording& recording, std::ostream& out);

/// Reads what save_recording wrote. Error: it is cut off, changed, or no recording.
Result<Recording> load_recording(std::istream& in);

class RecordingDevice final : public QueryDevice {
public:
    /// Keeps a reference: `inner` outlives this device. Tickets pass through unchanged.
    explicit RecordingDevice(QueryDevice& inner);

    const Recording& recording() const { return recording_; }

    const DeviceCaps& caps() const override { return inner_.caps(); }
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    void end_frame() override;

private:
    uint32_t number(Ticket issued);
    uint32_t number_of(Ticket asked) const;
    Answer record_answer(RecordedCall call, Ticket ticket, Answer answer);

    QueryDevice& inner_;
    Recording recording_;
    std::map<Ticket, uint32_t> unspent_; ///< the number of the test
    uint32_t tests_issued_ = 0;
};

/// Answers from a recording as long as the calls are the recorded ones, in the same order. From the
/// first difference on every answer is lost, and depth cannot be read.
class ReplayDevice final : public QueryDevice {
public:
    explicit ReplayDevice(Recording recording)
        : recording_(std::move(recording))
    {
    }

    /// What differed first, as a sentence; empty so far.
    const std::string& mismatch() const { return mismatch_; }
    /// True if every recorded call was made, and no other.
    bool complete() const { return mismatch_.empty() && next_ == recording_.calls.size(); }

    const DeviceCaps& caps() const override { return recording_.caps; }
    void begin_frame(const View& view) override;
    void draw(std::span<const ItemId> items, DrawPass pass) override;
    void query(const QueryBatch& batch, std::span<Ticket> tickets) override;
    Ticket draw_and_query(std::span<const ItemId> items, DrawPass pass) override;
    void flush() override;
    Answer poll(Ticket ticket) override;
    Answer wait(Ticket ticket) override;
    bool read_depth(const PixelRect& rect, std::span<float> out) override;
    void end_frame() override;

private:
    const RecordedCall* match(const RecordedCall& asked);
    void fail(std::string why);
    Ticket issue(uint32_t test);
    Answer answer(RecordedCall asked, Ticket ticket);

    Recording recording_;
    size_t next_ = 0;
    std::string mismatch_;
    TicketTable<uint32_t> tests_;
};

} // namespace occlude
