#include "core/recover/pyramid_loops.h"

namespace qray {
const PyramidLoops& common_pyramid_loops() { return kPyramidLoops; }
}  // namespace qray
