#include "core/recover/pyramid_rows.h"

#if defined(__x86_64__)
#pragma GCC target("avx512f,avx512vl,avx512bw,avx512dq,avx2,fma,prefer-vector-width=512")
#define QRAY_LOOPS_OF_AVX512  // g++ 12 does not define __AVX512F__ by the pragma
#endif
#include "core/recover/pyramid_loops.h"

namespace qray {
const PyramidLoops& avx512_pyramid_loops() { return kPyramidLoops; }
}  // namespace qray
