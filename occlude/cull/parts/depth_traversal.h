// The tests of a frame over a cut (cut_traversal.h) by depth that was read back, in the two phases
// of two_phase.h: what the depth of the first draws hides is kept, what it does not hide is opened
// and drawn near to far.
//
//    project_all()      boxes to rectangles, while the device draws
//    read()             depth of all that is drawn so far
//    test_candidates()  against it: hidden, or left to reveal()
//    reveal()           near to far: drawn, or opened and its parts tested
//    retest()           what was drawn before the last read(), for the next frame
//
// Guarantees  Errs toward "not hidden", as DepthTests does.
// Cost        well below a microsecond a test; a read-back of the whole target per read().
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
    /// `cut` outlives this object. A test of a shape counts as `shape_us` until a clock has timed
    /// some; without `use_shapes` there are none.
    DepthTraversal(CutTraversal& cut, DepthTests depth, bool use_shapes,
                   double shape_us = DepthTestBudget::kAlways)
        : cut_(cut)
        , depth_(depth)
        , use_shapes_(use_shapes)
        , shape_us_(shape_us)
    {
    }

    /// See DepthTests.
    void set_tile_px(int tile_px) { depth_.set_tile_px(tile_px); }
    /// Holds until the next call.
    void set_budget(const DepthTestBudget& budget) { budget_ = budget; }
    /// Tests of shapes are timed by it, as long as it lives. Null: they are not.
    void set_clock(const SecondsClock* clock) { clock_ = clock; }
    /// Forgets how often shapes were hidden.
    void forget() { shape_hidden_share_ = {}; }

    // --- one frame, in order ---

    void start_frame(const CullFrame& frame);
    void project_all(CullFrame& frame);
    /// Draws what is queued and reads its depth. False, and what was known stays known, if nothing
    /// was drawn or the device cannot read.
    bool read(CullFrame& frame);
    /// Allocates what read() needs, if it has not yet.
    void make_room(const View& view) { depth_.make_room(view); }
    bool known() const { return depth_.known(); }

    void test_candidates(CullFrame& frame);
    /// Draws or opens what is not hidden, near to far. True when drawing that waits costs more than
    /// `max_waiting_us` and the device can read: the caller may read(), and calls again. False when
    /// all is revealed.
    bool reveal(CullFrame& frame, double max_waiting_us);
    /// What was drawn before the last read(): is it hidden now? Keeps all that is drawn.
    void retest(CullFrame& frame);

    /// One box, and the shape of what it bounds, against what was read last.
    bool hidden(const CullFrame& frame, const HierarchyCut::Entry& entry);
    /// ... of a node, counted as a test.
    bool node_hidden(const CullFrame& frame, NodeId node);

    /// Boxes tested in this frame one by one: those of candidates and of what is drawn not
    /// included.
    size_t single_tests() const { return single_tests_; }
    /// ... and those of what was drawn before the last read().
    size_t drawn_before_read() const { return drawn_before_read_; }
    /// Microseconds that tests of shapes took in this frame.
    double shapes_us() const { return shapes_us_; }

private:
    using Entry = HierarchyCut::Entry;

    /// What tests need of some candidates, one after the other in memory: nodes and items are all
    /// over it, and reading depth back has displaced them from the caches.
    struct Tests {
        std::vector<Aabb> boxes;
        std::vector<ScreenBounds> bounds;
        std::vector<uint32_t> max_texels;
        std::vector<const ItemShapes::Placed*> shapes; ///< null: none; empty: none of them has one
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

    size_t drawn_before_read_ = 0; ///< how many of cut_.drawn(), when depth was last read
    size_t single_tests_ = 0;
    Tests drawn_tests_;
    Tests candidate_tests_;

    /// What reveal() has to do.
    struct ToReveal {
        std::vector<CutCandidate> stack; ///< the nearest on top
        /// How many at the bottom are candidates, known to be in the frustum.
        size_t candidates = 0;
        bool candidates_tested = false;     ///< ... against the depth that was read last
        std::optional<CutCandidate> paused; ///< where reveal() returned to its caller
        bool is_candidate = false;          ///< of the current one
    };
    ToReveal to_reveal_;

    const SecondsClock* clock_ = nullptr;
    ShareEstimate shape_hidden_share_;
    double shape_us_;        ///< what the test of one takes; smoothed
    double shapes_us_ = 0.0; ///< of this frame
};

} // namespace occlude
