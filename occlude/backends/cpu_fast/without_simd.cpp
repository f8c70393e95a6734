// The inner loops of Kernel::simd in a library that is built without Highway (OCCLUDE_SIMD=OFF):
// those of Kernel::scalar.
#include <occlude/backends/cpu_fast/detail/tile_raster.h>

namespace occlude::cpu_fast {

const TileKernels& simd_tile_kernels()
{
    return tile_kernels(Kernel::scalar);
}

} // namespace occlude::cpu_fast
