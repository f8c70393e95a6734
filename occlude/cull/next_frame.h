// Occlusion queries whose results are read in the next frame: an object is tested in one frame and
// drawn in the next if the test found it visible. No frame waits, and no image is exact.
//
// Implements  D. Sekulic, "Efficient Occlusion Culling", GPU Gems, 2004, ch. 29, section 29.4.
// Map         29.4, "check the query result from the previous frame" -> collect_results
//             29.4, visible: render the object in the query           -> draw_visible
//             29.4, not visible: "render" the box in the query        -> test_boxes
//             29.4.1, opaque front to back, then translucent          -> ObjectTests, CullFrame
//             29.4.2, the small caveat                                -> handle_result, Hysteresis
//             29.5.2, the first pass as the test                      -> Options::depth_only_pass
//             29.5.1, 29.6.1, 29.6.2                                  -> ObjectTestOptions
//             29.9, level of detail by pixels                         -> visible_samples
// Deviations  The boxes of hidden objects are tested in one batch after all visible objects are
//             drawn; the chapter tests each in its turn. The result counts in the next frame either
//             way, and against more depth a test hides more. Objects with items that their flags
//             set aside are tested by their box: items that are drawn later cannot be counted now.
//             An object counts as visible in its first frame, when it comes back into the frustum,
//             and after it was drawn untested, because its results are old then; the chapter does
//             not say so. As in chc.h: R1.
// Guarantees  latent(1) when results are waited for: an object that is missing in frame F became
//             visible in F. latent(max_latency) when results are polled. Hysteresis::hide adds
//             `hold_frames` to the latency. The same holds where boxes alone decide (no
//             draw_and_query).
// Cost        one test per hidden object and frame, and one per visible object in k frames; two
//             changes of state per frame.
#pragma once

#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/object_tests.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace occlude {

struct NextFrameOptions {
    /// How the results of the last frame are read.
    enum class Read : uint8_t {
        wait, ///< all of them, at the start of the frame
        poll, ///< the results that have arrived; an object without one keeps its state
    };
    Read read = Read::wait;
    /// With Read::poll: a result this many frames old is waited for. At least 1.
    uint32_t max_latency = 3;
    /// k: a visible object is tested every k frames.
    uint32_t visible_interval = 4;

    /// How to treat an object that is hidden although its box is visible (29.4.2).
    enum class Hysteresis : uint8_t {
        off,  ///< it is drawn every other frame or so, as in the chapter
        draw, ///< it is drawn, and tested by its box, until its box is hidden
        hide, ///< it stays hidden for `hold_frames` even if its box is visible, and may appear
              ///< that many frames late
    };
    Hysteresis hysteresis = Hysteresis::draw;
    /// h: the number of frames for which Hysteresis::hide ignores a visible box.
    uint32_t hold_frames = 6;

    /// Tests in a depth-only pass, then shades everything drawn in one batch.
    bool depth_only_pass = false;
    /// An object with at most this many visible samples is hidden.
    uint64_t threshold = 0;
    ObjectTestOptions tests = {};
};

class NextFrame final : public Culler {
public:
    using Options = NextFrameOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "next_frame",
        .paper = "Sekulic 2004, 29.4",
        .summary = "draws objects by the answers of the last frame: never waits, is one frame late",
        .needs = {.queries = true},
        .node_use = NodeUse::leaves,
        .exact = false,
    };

    explicit NextFrame(HierarchyRef hierarchy, NextFrameOptions options = {});

    /// The number of samples that the last answered test of an object counted: its own pixels
    /// (times samples per pixel) if it was tested by drawing it, else the pixels of its box, which
    /// are more. Answer::kUnknownSamples before the first answer and for inner nodes.
    uint64_t visible_samples(NodeId object) const;

private:
    enum class TestedBy : uint8_t { nothing, box, geometry };

    struct ObjectState {
        uint64_t samples = Answer::kUnknownSamples;
        uint32_t last_seen = 0;    ///< stamp of the last frame in which it was in the frustum
        uint32_t valid_from = 0;   ///< results of tests issued before this stamp say nothing
        uint32_t hidden_until = 0; ///< stamp until which a visible box is ignored
        uint32_t issued = 0;       ///< stamp of the pending test
        Ticket ticket;             ///< of the pending test
        TestedBy pending = TestedBy::nothing;
        bool visible = true;
        bool revealed_by_box = false; ///< drawn because its box is visible; its own geometry was
                                      ///< not counted yet
        bool test_by_box = false;     ///< Hysteresis::draw keeps it drawn
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;
    Guarantee guarantee() const override;

    void collect_results(CullFrame& frame);
    void handle_result(NodeId object, const Answer& answer, uint32_t stamp);
    void draw_untested(CullFrame& frame, const ObjectTests::Object& object, Decision decision);
    void draw_visible(CullFrame& frame, const ObjectTests::Object& object);
    void test_boxes(CullFrame& frame);
    void remember(NodeId object, Ticket ticket, TestedBy test, uint32_t stamp);

    NextFrameOptions options_;
    ObjectTests tests_;
    std::vector<ObjectState> states_;
    std::vector<NodeId> pending_;       ///< objects whose result is outstanding
    std::vector<NodeId> still_pending_; ///< of them, in collect_results
    std::vector<NodeId> box_tests_;     ///< objects tested by their box at the end of this frame
    TestBatch batch_;
    std::vector<Ticket> tickets_;
};

/// Names of the options for the registry; see registry.h.
constexpr std::array<std::string_view, 2> option_names(NextFrameOptions::Read)
{
    return {"wait", "poll"};
}
constexpr std::array<std::string_view, 3> option_names(NextFrameOptions::Hysteresis)
{
    return {"off", "draw", "hide"};
}
template <class Visit>
void visit_options(NextFrameOptions& o, Visit&& visit)
{
    visit("read", o.read, "how the results of the last frame are read: wait for all, or poll");
    visit("max_latency", o.max_latency, {1, 1000},
          "frames after which a polled result is waited for");
    visit("visible_interval", o.visible_interval, {1, 1'000'000},
          "k: a visible object is tested every this many frames");
    visit("hysteresis", o.hysteresis,
          "what happens to an object that is hidden although its box is visible");
    visit("hold_frames", o.hold_frames, {0, 1'000'000},
          "h: frames for which hysteresis=hide ignores a visible box");
    visit("depth_only_pass", o.depth_only_pass,
          "test in a depth-only pass, then shade in one batch");
    visit("threshold", o.threshold, {},
          "an object with at most this many visible samples is hidden");
    visit_options(o.tests, visit);
}

} // namespace occlude
