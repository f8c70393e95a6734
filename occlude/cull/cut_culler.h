// The traversal that `two_phase` and `adaptive` share: two phases over a cut that is kept from
// frame to frame. An algorithm says what is opened, what is worth a test and when depth is read.
//
//    the cut of the last frame --> in the frustum?
//                                    visible then --> draw at once, near to far     draw_expected
//                                    hidden, new  --> test --> hidden: kept         test_candidates
//                                                         --> visible: draw, or     reveal
//                                                             test what it consists of
//                                    outside      --> kept
//    at the end: what was drawn before the last look at depth is tested by it       retest
//                quiet siblings become their parent                                 finish_cut
//
// Guarantees  exact: every item in the frustum is drawn, or lies in an entry that a test in this
// very
//             frame found hidden. What was visible and is tested again comes back into the frustum
//             as a candidate (rule R8).
// Cost        O(entries of the cut) a frame, which follows the visible boundary. Nothing is kept
// per
//             node of the tree.
#pragma once

#include <occlude/cull/culler.h>
#include <occlude/cull/parts/cull_frame.h>
#include <occlude/cull/parts/depth_tests.h>
#include <occlude/cull/parts/hierarchy_cut.h>
#include <occlude/hierarchy/item_shapes.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace occlude {

class CutCuller : public Culler {
public:
    const HierarchyCut& cut() const { return cut_; }

    /// True if something of `node` was found visible by the last frame and will be drawn first in
    /// the next. O(entries of the cut).
    bool visible(NodeId node) const;

protected:
    using Entry = HierarchyCut::Entry;
    using State = HierarchyCut::State;

    struct Candidate {
        Entry entry;
        PlaneMask mask = Frustum::kAllPlanes;
        float distance = 0.0f;
        uint32_t together = 0; ///< for `adaptive`: number of the part of a failed group, or 0
    };

    explicit CutCuller(const Hierarchy& hierarchy, DepthTests depth = DepthTests{},
                       bool use_shapes = true)
        : Culler(hierarchy)
        , depth_(depth)
        , use_shapes_(use_shapes)
    {
    }

    // --- what the algorithm decides ---

    /// False if `node` is drawn as a whole where it is visible.
    virtual bool opens(NodeId node) const = 0;
    /// How many texels the test of faces may look at, and that of a shape again.
    virtual uint32_t most_texels(const Entry& entry) const = 0;
    /// Is something of which nothing is known tested, or drawn at once?
    virtual bool worth_testing(const Entry&) const { return true; }
    /// Is the shape of something tested whose box is not hidden?
    virtual bool worth_shape(const Entry&) const { return true; }
    /// ... and the answer, for which the program took `us` since shape_clock() was asked.
    virtual void shape_answered(bool /*hidden*/, double /*us*/) {}
    virtual double shape_clock() const { return 0.0; }
    /// False if what was visible turned out hidden since the last frame.
    virtual bool still_visible(const Entry&) const { return true; }
    /// Asked while things are revealed, before each test: reads depth again if that is due.
    virtual bool read_again(CullFrame& frame) = 0;
    /// A test of something new has an answer.
    virtual void answered(bool /*hidden*/) {}
    /// The entry need not be drawn in this frame.
    virtual void spared(const Entry&) {}
    /// It was drawn and is hidden: the next frame probably need not.
    virtual void wasted(const Entry&) {}
    /// May hidden parts of `node`, all of them, become one entry?
    virtual bool merges(CullFrame& frame, NodeId node);

    // --- one frame, in order ---

    /// Parts the cut into what is outside, what was visible and is drawn at once, and the rest.
    void sort_out(CullFrame& frame);
    void draw_expected(CullFrame& frame);
    /// Reads depth (DepthTests::read): retest() tests by it all that is drawn by then.
    bool read(CullFrame& frame);
    /// Where the candidates and what is drawn already are on the screen: while the device draws.
    void project_all(CullFrame& frame);
    void test_candidates(CullFrame& frame);
    void reveal(CullFrame& frame);
    void retest(CullFrame& frame);
    /// One in a few of the nodes that can be closed again is tried, by a hash of `seed`.
    void finish_cut(CullFrame& frame, uint64_t seed);

    // --- entries ---

    const Aabb& box_of(const Entry& entry) const
    {
        return entry.is_item() ? hierarchy().item_bounds()[entry.place].box
                               : hierarchy().node(entry.node).box;
    }
    uint64_t triangles_of(const Entry& entry) const
    {
        return entry.is_item() ? hierarchy().item_bounds()[entry.place].triangles
                               : hierarchy().node(entry.node).subtree_triangles;
    }
    uint64_t items_of(const Entry& entry) const
    {
        return entry.is_item() ? 1 : hierarchy().node(entry.node).subtree_items;
    }
    /// False for what has no parts, or is drawn whole.
    bool opens(const Entry& entry) const { return !entry.is_item() && opens(entry.node); }
    /// Has the node more than one part: children and own items?
    bool has_parts(NodeId node) const
    {
        const Node& n = hierarchy().node(node);
        return n.child_count > 0 || n.own_items > 1;
    }

    bool visit(CullFrame& frame, Candidate& candidate) const;
    void draw(CullFrame& frame, const Candidate& candidate, Decision decision) const;
    /// What an opened node consists of: its own items and its children, the farthest first.
    void add_parts(const CullFrame& frame, const Candidate& candidate, std::vector<Candidate>& out);
    bool hidden(const CullFrame& frame, const Entry& entry)
    {
        return depth_.hides(frame.view(), box_of(entry), most_texels(entry)) ||
               shape_hidden(frame, entry, shape_of(entry));
    }
    /// Found hidden; not drawn in this frame unless `decision` is undecided.
    void keep_hidden(CullFrame& frame, Entry entry, Decision decision);
    void keep_visible(Entry entry);
    void keep_outside(Entry entry);

    HierarchyCut cut_;
    DepthTests depth_;
    bool all_drawn_ = false;            ///< everything is drawn already, and tests decide nothing
    std::vector<Candidate> drawn_;      ///< visible in the last frame, then what this one reveals
    size_t drawn_before_read_ = 0;      ///< so many of them, before depth was last read
    std::vector<Candidate> candidates_; ///< hidden or unknown, in the frustum
    std::vector<Candidate> stack_;
    double tests_ = 0.0; ///< one by one, in reveal and merges

private:
    /// What tests need of some candidates, one after the other in memory: nodes and items are all
    /// over it, and reading depth back has displaced them from the caches.
    struct Tests {
        std::vector<Aabb> boxes;
        std::vector<ScreenBounds> bounds;
        std::vector<uint32_t> most_texels;
        std::vector<const ItemShapes::Placed*> shapes; ///< null: none; empty: none of them has one
        std::vector<uint8_t> hidden;
    };
    void prepare(const CullFrame& frame, std::span<const Candidate> candidates, Tests& tests) const;
    void test(const CullFrame& frame, std::span<const Candidate> candidates, Tests& tests);
    bool has_shapes() const
    {
        return use_shapes_ && hierarchy().shapes() != nullptr && !hierarchy().shapes()->empty();
    }
    const ItemShapes::Placed* shape_of(const Entry& entry) const;
    bool shape_hidden(const CullFrame& frame, const Entry& entry, const ItemShapes::Placed* shape);
    void open(CullFrame& frame, const Candidate& candidate, bool tested);

    struct Part {
        float distance;
        NodeId node;
        uint32_t place;
    };
    bool use_shapes_;
    std::vector<Part> parts_;
    std::vector<std::pair<float, uint32_t>> order_; ///< of what is drawn first, by distance
    Tests drawn_tests_;
    Tests candidate_tests_;
};

} // namespace occlude
