// The interface of every algorithm: one object per view, whose cull() makes one frame.
#pragma once

#include <occlude/core/frame_report.h>
#include <occlude/core/ids.h>
#include <occlude/core/messages.h>
#include <occlude/core/query_device.h>
#include <occlude/core/view.h>
#include <occlude/cull/algorithm_traits.h>
#include <occlude/cull/parts/frame_record.h>
#include <occlude/hierarchy/hierarchy.h>

#include <span>
#include <utility>

namespace occlude {

/// Refuses a temporary hierarchy, which would be destroyed before the first frame: `ChcPlusPlus
/// culler(build_bvh(items));` does not compile.
class HierarchyRef {
public:
    HierarchyRef(const Hierarchy& hierarchy) // implicit, so that callers can pass the hierarchy
                                             // itself
        : hierarchy_(&hierarchy)
    {
    }
    HierarchyRef(const Hierarchy&& temporary) = delete;

    operator const Hierarchy&() const { return *hierarchy_; }

private:
    const Hierarchy* hierarchy_;
};

/// One view's culler over one hierarchy: it owns the view's temporal state. Two eyes, a shadow map
/// and a reflection are four cullers over one hierarchy. Not thread-safe; different cullers may run
/// in different threads on different devices, since the hierarchy is const while culling.
///
/// An algorithm derives from this and declares two names for the registry: `kTraits`, its
/// AlgorithmTraits, and `Options`, unless it has none.
class Culler {
public:
    using Options = NoOptions;

    /// Keeps a reference: `hierarchy` must outlive the culler and stay at its address. Between
    /// frames it may be refitted, or another hierarchy may be assigned to it; a changed structure
    /// resets the culler. If it was moved from, the culler draws nothing, and builds with
    /// assertions stop.
    explicit Culler(HierarchyRef hierarchy)
        : hierarchy_(hierarchy)
    {
    }
    virtual ~Culler() = default;
    Culler(const Culler&) = delete;
    Culler& operator=(const Culler&) = delete;

    /// Culls and draws one whole frame on `device`, from begin_frame to end_frame. An exception
    /// from `device` passes through after end_frame, and the next cull() starts from a reset.
    FrameReport cull(const View& view, QueryDevice& device);

    /// Forgets everything seen and all work under way: for a camera cut, a new level, another
    /// device. Tests without an answer are abandoned, and the next frames spend their tickets.
    void reset();

    /// Forgets everything seen, and spends the tickets that are still unspent on `device`, which is
    /// the device of its last frames. Call it between frames, before a culler that the device
    /// outlives is destroyed. Blocks until the tests are answered.
    void release(QueryDevice& device);

    /// The items drawn by the last cull(), in draw order, each once. Valid until the next cull().
    std::span<const ItemId> drawn_items() const { return record_.drawn_items; }

    /// The decisions of the last cull() and their reasons; for a never_cull item, the decision
    /// about its node. Valid until the next cull().
    const DecisionLog& decisions() const { return record_.decisions; }

    const Hierarchy& hierarchy() const { return hierarchy_; }

    /// The receiver of faults of the device and of the view; none by default. Each fault is
    /// reported once:
    ///   culler.lost_answers   the device lost answers, which count as visible
    ///   culler.depth_read     a read-back of depth failed
    ///   culler.empty_view     the view has no pixel: nothing is culled
    ///   culler.useless_clock  the host's clock stands still or is coarse: hints are used
    void set_message_handler(MessageHandler handler) { messages_ = Messages{std::move(handler)}; }

protected:
    /// One frame of the algorithm. `frame` counts from 0 since the last reset.
    virtual void cull_frame(class CullFrame& frame) = 0;
    /// Clears everything that cull_frame() leaves: states, queues, batches. The last frame may have
    /// ended half-way.
    virtual void reset_state() = 0;
    /// Called when the node ids of the hierarchy have lost their meaning since the last frame.
    /// Forgets everything; an algorithm whose state survives overrides it.
    virtual void structure_changed() { reset(); }
    virtual Guarantee guarantee() const { return Guarantee::exact(); }
    /// The guarantee of a frame in which a node with at most `threshold` visible samples is hidden.
    static Guarantee by_threshold(uint64_t threshold)
    {
        return threshold == 0 ? Guarantee::exact() : Guarantee::approximate(threshold);
    }

    /// Gives up a test that has no answer yet. Later frames spend its ticket as soon as the answer
    /// arrives, so that the device can use the place for another test.
    void abandon(Ticket ticket) { record_.tickets.abandon(ticket); }

private:
    void report_faults(const class CullFrame& frame, const FrameReport& report);

    const Hierarchy& hierarchy_;
    uint64_t seen_structure_ = 0;
    uint64_t next_frame_ = 0;
    bool in_frame_ = false; ///< cull() was entered and has not returned
    FrameRecord record_;    ///< of the last frame
    Messages messages_;
};

} // namespace occlude
