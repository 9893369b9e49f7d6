// A view for files that bring none. Pure function.
#pragma once

#include "core/scene/scene.h"

namespace qray {

// A box open at +z (a Cornell box) is seen whole from outside its opening, a closed room from
// inside its +z wall, anything else from the front, a little above and to the right. Where fronts
// are known to be where the file has them, a wall is one whose front is inside, and a room any
// place that fronts surround, seen along its longest free line. pre: indices in range.
Camera fit_camera(const Scene& scene, bool fronts_are_known = false);

}  // namespace qray
