// Statistically optimised queries: a node that was recently visible is drawn untested for a while.
//
// Implements  V. Kovalcik, J. Sochor, "Occlusion Culling with Statistically Optimized Occlusion
//             Queries", WSCG 2005.
// Map         section 3, main loop     -> Statistical::cull_frame
//               its first inner loop   -> move_pointer
//               its second inner loop  -> handle_results
//             CalcNodeAction           -> calc_node_action
//             RenderNode,
//             AddChildrenBeforePointer -> render_node
//             SaveStatistics           -> save_statistics
//             not_query_time           -> pause
// Deviations  The printed listing has five defects; the text says what was meant:
//             1  The loop runs while *both* queues hold something; it must run while either does.
//                Here a node under test stays in the list, so that one condition is enough.
//             2  RENDER never inserts the children of the node.
//             3  The node is deleted from the list before its test is answered, and with it the
//                place where its children must go. Here it stays as a place-holder.
//             4  The inner loop has no limit of tests under way, which the text sets to about 20.
//             5  CalcNodeAction queries if the statistics are *not* too old, computes
//                not_query_time without using it, and returns nothing in the last case.
//             The paper leaves open how many results are kept (here 8) and when statistics are too
//             old (here after twice BASE_TIME: then they are forgotten). The tests of one pass of
//             the pointer are issued as one batch; the paper issues each at its place. Time is
//             counted in frames unless a clock is given, so that runs repeat. Pauses may be spread.
//             A lost answer draws the node and does not enter the statistics. As in chc.h: R1
//             instead of "viewer is inside".
// Guarantees  exact with threshold 0, with every combination of options and any clock: a node is
//             left out only if a test of this frame found no sample of it.
// Cost        about one test per node of the hidden boundary, and one per visible node in 40 to 80
//             frames; one wait per test, or per batch if answers arrive together. A node that
//             turned hidden is drawn for up to 2 * BASE_TIME longer, so that this algorithm draws
//             more triangles than other exact ones.
#pragma once

#include <occlude/core/clock.h>
#include <occlude/core/option_range.h>
#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/fifo.h>
#include <occlude/cull/parts/node_list.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace occlude {

struct StatisticalOptions {
    /// How the tests of one pass of the pointer are issued.
    enum class Issue : uint8_t {
        batch,    ///< all at the end of the pass, with one change of state
        at_place, ///< each when the pointer reaches it, after the draws before it
    };
    /// How many answers are handled before the pointer returns to the start.
    enum class Results : uint8_t {
        all,    ///< all: no test is under way when the pointer moves on
        oldest, ///< the oldest, and those after it that have arrived
    };
    /// The unit of pauses.
    enum class Time : uint8_t {
        frames, ///< frames: runs repeat
        clock,  ///< seconds of the clock that the culler was given; frames if there is none
    };

    /// BASE_TIME in seconds. A faster viewer needs a smaller one. 0 tests every node in every
    /// frame.
    float base_time = 2.0f / 3.0f;
    /// The number of latest results that count; at most 64.
    uint32_t history = 8;
    /// Statistics older than this many BASE_TIMEs are forgotten.
    float max_age = 2.0f;
    /// Each node's pause is multiplied by a random factor from 1 - spread to 1 + spread, so that
    /// nodes that turn visible together are not all tested together later. 0: as in the paper.
    float spread = 0.25f;
    /// The largest number of tests under way.
    uint32_t max_in_flight = 20;
    Issue issue = Issue::batch;
    Results results = Results::all;
    Time time = Time::frames;
    /// The number of frames that count as a second if there is no clock.
    float frames_per_second = 60.0f;
    /// A node with at most this many visible samples is hidden. Above 0 the image is approximate.
    uint64_t threshold = 0;
    /// Seed of the random factors of `spread`.
    uint64_t seed = 1;
};

class Statistical final : public Culler {
public:
    using Options = StatisticalOptions;
    static constexpr AlgorithmTraits kTraits{
        .name = "statistical",
        .paper = "Kovalcik, Sochor 2005",
        .summary =
            "draws recently visible nodes untested, the longer the more often they were visible",
        .needs = {.queries = true},
    };

    /// With Time::clock, `clock` is read once per frame. Otherwise time is the number of frames
    /// since the last reset, divided by frames_per_second.
    explicit Statistical(HierarchyRef hierarchy, StatisticalOptions options = {},
                         SecondsClock clock = {})
        : Culler(hierarchy)
        , options_(clamped(options))
        , clock_(options_.time == StatisticalOptions::Time::clock ? std::move(clock)
                                                                  : SecondsClock{})
    {
    }

private:
    friend class CullerProbe; // of the tests
    enum class Action : uint8_t { render, skip, query };

    struct Statistics {
        double last_time = 0.0;
        uint64_t visible_bits = 0; ///< one bit per result; bit 0 is the latest
        uint32_t results = 0;      ///< 0: no result yet
    };
    struct PendingQuery {
        Ticket ticket;
        NodeList::Position place;
    };

    void cull_frame(CullFrame& frame) override;
    void reset_state() override;
    Guarantee guarantee() const override { return by_threshold(options_.threshold); }

    void move_pointer(CullFrame& frame);
    void handle_results(CullFrame& frame);
    Action calc_node_action(CullFrame& frame, NodeList::Entry& entry, Decision& decision);
    NodeList::Position render_node(CullFrame& frame, NodeList::Position place, Decision decision);
    void issue(CullFrame& frame, NodeList::Position place);
    void submit_batch(CullFrame& frame);
    void save_statistics(NodeId node, bool visible);
    /// How many seconds `node` is not tested after a visible result, if `visible_results` of the
    /// kept ones are visible: BASE_TIME * (2 - 0.5^n), spread.
    double pause(NodeId node, uint32_t visible_results) const;

    StatisticalOptions options_;
    SecondsClock clock_;
    double now_ = 0.0;
    std::vector<Statistics> statistics_;
    NodeList queue_;
    Fifo<PendingQuery> query_queue_;

    TestBatch batch_;
    std::vector<NodeList::Position> batch_places_;
    std::vector<Ticket> tickets_;
    std::vector<std::pair<float, NodeId>> children_;
};

/// Names of the options for the registry; see registry.h.
constexpr std::array<std::string_view, 2> option_names(StatisticalOptions::Issue)
{
    return {"batch", "at_place"};
}
constexpr std::array<std::string_view, 2> option_names(StatisticalOptions::Results)
{
    return {"all", "oldest"};
}
constexpr std::array<std::string_view, 2> option_names(StatisticalOptions::Time)
{
    return {"frames", "clock"};
}
template <class Visit>
void visit_options(StatisticalOptions& o, Visit&& visit)
{
    visit("base_time", o.base_time, {0.0f, 3600.0f},
          "BASE_TIME in seconds; a visible node is not tested for one to two times this");
    visit("history", o.history, {1, 64}, "number of latest results of a node that count");
    visit("max_age", o.max_age, {}, "BASE_TIMEs after which statistics are forgotten");
    visit("spread", o.spread, {0.0f, 1.0f},
          "share by which pauses vary from node to node; 0: as in the paper");
    visit("max_in_flight", o.max_in_flight, {1, 65536}, "largest number of tests under way");
    visit("issue", o.issue,
          "when tests are issued: a whole pass as one batch, or each at its place");
    visit("results", o.results,
          "which answers are handled before the pointer returns to the start");
    visit("time", o.time, "unit of pauses; with a clock, runs do not repeat");
    visit("frames_per_second", o.frames_per_second, {1.0f, 10000.0f},
          "frames that count as one second of BASE_TIME");
    visit("threshold", o.threshold, {},
          "a node with at most this many visible samples is hidden; above 0 not exact");
    visit("seed", o.seed, {}, "seed of the random factors of spread");
}

} // namespace occlude
