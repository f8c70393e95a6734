// The kernels of Kernel::simd in a library that is built without Highway (OCCLUDE_SIMD=OFF). They
// process one value after the other, as Kernel::scalar does, with results equal to the bit.
#include <occlude/screen/detail/box_projector.h>
#include <occlude/screen/detail/pyramid_kernels.h>

namespace occlude {

void detail::project_boxes_simd(const BoxProjector& p, std::span<const Aabb> boxes,
                                BoundsBlock& bounds)
{
    for (size_t i = 0; i < boxes.size(); ++i) {
        ScreenBounds one;
        p.project(boxes[i], one);
        bounds.set(i, one);
    }
}

void detail::build_levels_simd(std::span<const PyramidLevel> levels, int base, float* texels)
{
    build_levels(levels, base, texels, &reduce_rows);
}

void detail::coarse_hides_simd(std::span<const PyramidLevel> levels, int base, const float* texels,
                               const BoundsBlock& bounds, size_t count,
                               BoundsBlock::Field<uint8_t>& hidden)
{
    for (size_t i = 0; i < count; ++i) {
        const bool hides = bounds.valid[i] != 0 &&
                           coarse_hides(levels, base, texels, bounds.rect(i), bounds.near_depth[i]);
        hidden[i] = hides ? 1 : 0;
    }
}

} // namespace occlude
