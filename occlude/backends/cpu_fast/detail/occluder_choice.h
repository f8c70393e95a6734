// Which occluders of a frame are rasterised, in what order, and how many of them.
#pragma once

#include <occlude/backends/cpu_fast/cpu_fast_scene.h>
#include <occlude/backends/cpu_fast/occluder_buffer.h>
#include <occlude/core/ids.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude::cpu_fast {

struct OccluderLimits {
    float budget_us = 0.0f;           ///< per frame; 0: none
    uint64_t max_triangles = 0;       ///< per frame; 0: no limit
    float min_px_per_triangle = 0.0f; ///< of the item's rectangle on the screen
    double (*clock_us)() = nullptr;   ///< for the budget; null: a steady clock of the system
};

/// Rasterises those that hide most per triangle first, in chunks. An occluder that lies behind
/// those of the chunks before it is left out: it would hide nothing.
class OccluderChoice {
public:
    void begin_frame();
    /// An item that the renderer draws in this frame. Counts once per frame.
    void add(ItemId id, const CpuFastItem& item);
    /// Rasterises what waits, as far as the limits of the frame reach.
    void rasterize(OccluderBuffer& buffer, const OccluderLimits& limits);
    /// Learns which occluders hid nothing: in the next frames they come last. Only frames that left
    /// occluders out are worth that.
    void end_frame(const OccluderBuffer& buffer);

    /// Microseconds that rasterize() took in this frame; 0 without a budget.
    float spent_us() const { return spent_us_; }

private:
    struct Candidate {
        CpuFastItem item = {};
        ItemId id = {};
        uint32_t work = 0;
        float value = 0.0f; ///< pixels per triangle
        float nearest = 0.0f;
        PixelRect rect = {};
    };
    struct History {
        uint32_t added_in = 0;   ///< the frame
        uint32_t useless_in = 0; ///< the last frame in which it hid nothing, or 0
    };

    void rate(const OccluderBuffer& buffer, const OccluderLimits& limits);
    uint64_t add_chunk(OccluderBuffer& buffer, uint64_t most_work, uint64_t most_triangles);
    uint64_t work_left(const OccluderLimits& limits, double spent_us) const;

    std::vector<Candidate> waiting_; ///< since the last call of rasterize()
    std::vector<Candidate> used_;    ///< rasterised in this frame
    std::vector<History> history_;   ///< by ItemId
    uint32_t frame_ = 0;
    bool left_out_ = false;
    uint64_t triangles_ = 0; ///< rasterised in this frame
    float spent_us_ = 0.0f;
    float us_per_work_ = 0.2f; ///< at first more than any processor needs
};

} // namespace occlude::cpu_fast
