// The inner loops of Kernel::simd in a library that is built without Highway (OCCLUDE_SIMD=OFF):
// those of Kernel::scalar.
#include <occlude/backends/cpu_fast/detail/bin_raster.h>
#include <occlude/backends/cpu_fast/detail/triangle_setup.h>

namespace occlude::cpu_fast {

const BinKernels& simd_bin_kernels()
{
    return bin_kernels(Kernel::scalar);
}

const SetupKernels& simd_setup_kernels()
{
    return setup_kernels(Kernel::scalar);
}

} // namespace occlude::cpu_fast
