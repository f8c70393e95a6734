// The masked depth of a whole grid: bins, and the farthest depth of each.
#pragma once

#include <occlude/backends/cpu_fast/detail/instance_transform.h>
#include <occlude/backends/cpu_fast/detail/masked_bin.h>
#include <occlude/backends/cpu_fast/detail/prim.h>

#include <cstdint>
#include <span>
#include <vector>

namespace occlude::cpu_fast {

class MaskedDepth {
public:
    /// Nothing hides anything. Bins are cleared when they are written first.
    void clear(const Grid& grid);

    /// A bin to be filled. Its farthest depth afterwards goes to set_farthest(). Different bins may
    /// be written by different threads.
    MaskedBin& write(size_t bin);
    float farthest(size_t bin) const { return farthest_[bin]; }
    void set_farthest(size_t bin, float depth) { farthest_[bin] = depth; }

    /// True only if every cell of the rectangle hides what is at `nearest` or beyond. Precondition:
    /// the rectangle is not empty and lies in the grid.
    bool hides(const CellRect& cells, float nearest) const;
    /// Depth by cells, row by row from the bottom. Precondition: `out` has the grid's size.
    void expand(std::span<float> out) const;

private:
    float depth_at(int x, int y) const;

    Grid grid_;
    std::vector<MaskedBin> bins_;
    std::vector<float> farthest_;
    std::vector<uint8_t> written_;
};

} // namespace occlude::cpu_fast
