#include "core/recover/infer_loops.h"

namespace qray {
const InferLoops& common_loops() { return kLoops; }
}  // namespace qray
