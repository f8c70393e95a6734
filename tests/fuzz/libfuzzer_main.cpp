// One program per target for libFuzzer: OCCLUDE_FUZZ_TARGET is the function of targets.h.
#include "fuzz/targets.h"

#include <cstddef>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    occlude::fuzz::OCCLUDE_FUZZ_TARGET({data, size});
    return 0;
}
