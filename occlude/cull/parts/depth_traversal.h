// Tests by depth of a frame over a cut (cut_traversal.h), in the two phases of two_phase.h: entries
// that the depth of the first draws hides are kept; the others are opened and drawn near to far.
//
//    project_all()      boxes to rectangles, while the device draws
//    read()             reads the depth of everything drawn so far
//    test_candidates()  tests against it: hidden, or left to reveal()
//    reveal()           near to far: draws, or opens and tests the parts
//    retest()           tests what was drawn before the last read(), for the next frame
//
// Guarantees  errs toward "not hidden", as DepthTests does.
// Cost        well below a microsecond per test; a read-back of the whole target per read().
#pragma once

#include <occlude/core/clock.h>
#include <occlude/cull/parts/cut_traversal.h>
#include <occlude/cull/parts/depth_tests.h>
#include <occlude/cull/parts/test_prices.h>
#include <occlude/hierarchy/item_shapes.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace occlude {

class DepthTraversal {
public:
    /// `cut` must outlive this object. The test of a shape counts as `shape_us` until a clock has
    /// timed some. Without `use_shapes`, no shape is tested.
    DepthTraversal(CutTraversal& cut, DepthTests depth, bool use_shapes,
                   double shape_us = DepthTestBudget::kAlways)
        : cut_(cut)
        , depth_(depth)
        , use_shapes_(use_shapes)
        , shape_us_(shape_us)
    {
    }

    /// See DepthTests::set_tile_px().
    void set_tile_px(int tile_px) { depth_.set_tile_px(tile_px); }
    /// Sets the budget from now on.
    void set_budget(const DepthTestBudget& budget) { budget_ = budget; }
    /// Sets the clock that times tests of shapes; it must outlive its use. Null: they are not
    /// timed.
    void set_clock(const SecondsClock* clock) { clock_ = clock; }
    /// Forgets how often shapes were hidden.
    void forget() { shape_hidden_share_ = {}; }

    // --- one frame, in order ---

    void start_frame(const CullFrame& frame);
    void project_all(CullFrame& frame);
    /// Draws what is queued and reads its depth. Returns false and keeps the last depth if nothing
    /// was drawn or the device cannot read.
    bool read(CullFrame& frame);
    /// Allocates the memory of read(), unless it has been allocated.
    void make_room(const View& view) { depth_.make_room(view); }
    bool known() const { return depth_.known(); }

    void test_candidates(CullFrame& frame);
    /// Draws or opens what is not hidden, near to far. Returns true when the queued drawing costs
    /// more than `max_waiting_us` and the device can read: the caller may read(), and must call
    /// again. Returns false when everything is revealed.
    bool reveal(CullFrame& frame, double max_waiting_us);
    /// Tests what was drawn before the last read() against that depth, and keeps all that is drawn.
    void retest(CullFrame& frame);

    /// True if the entry's box, or else its shape, is hidden by the depth that was read last.
    bool hidden(const CullFrame& frame, const HierarchyCut::Entry& entry);
    /// The same for a node; counts it as a test.
    bool node_hidden(const CullFrame& frame, NodeId node);

    /// The number of boxes tested one by one in this frame, without the candidates and the drawn
    /// entries.
    size_t single_tests() const { return single_tests_; }
    /// The number of entries that were drawn before the last read().
    size_t drawn_before_read() const { return drawn_before_read_; }
    /// The time of the tests of shapes in this frame, in microseconds.
    double shapes_us() const { return shapes_us_; }

private:
    using Entry = HierarchyCut::Entry;

    /// The data that tests read, gathered from the candidates into contiguous memory: nodes and
    /// items are scattered, and reading depth has displaced them from the caches.
    struct Tests {
        std::vector<Aabb> boxes;
        std::vector<ScreenBounds> bounds;
        std::vector<uint32_t> max_texels;
        std::vector<const ItemShapes::Placed*> shapes; ///< null: this candidate has none; empty: no
                                                       ///< candidate has one
        std::vector<uint8_t> hidden;
    };
    void prepare(const CullFrame& frame, std::span<const CutCandidate> candidates,
                 Tests& tests) const;
    void test(const CullFrame& frame, std::span<const CutCandidate> candidates, Tests& tests);
    uint32_t max_texels(const Entry& entry) const;
    bool has_shapes() const;
    const ItemShapes::Placed* shape_of(const Entry& entry) const;
    bool shape_hidden(const CullFrame& frame, const Entry& entry, const ItemShapes::Placed* shape);
    bool next_to_reveal(CullFrame& frame);
    void open(CullFrame& frame, const CutCandidate& candidate, bool tested);

    CutTraversal& cut_;
    DepthTests depth_;
    bool use_shapes_;
    DepthTestBudget budget_;

    size_t drawn_before_read_ = 0; ///< size of cut_.drawn() when depth was last read
    size_t single_tests_ = 0;
    Tests drawn_tests_;
    Tests candidate_tests_;

    /// The remaining work of reveal().
    struct ToReveal {
        std::vector<CutCandidate> stack; ///< the nearest on top
        /// How many entries at the bottom are candidates, which are known to be in the frustum.
        size_t candidates = 0;
        bool candidates_tested = false;     ///< the candidates were tested against the depth that
                                            ///< was read last
        std::optional<CutCandidate> paused; ///< the entry at which reveal() returned
        bool is_candidate = false;          ///< the entry taken last is a candidate
    };
    ToReveal to_reveal_;

    const SecondsClock* clock_ = nullptr;
    ShareEstimate shape_hidden_share_;
    double shape_us_;        ///< running average of the time of one test
    double shapes_us_ = 0.0; ///< total of this frame
};

} // namespace occlude
