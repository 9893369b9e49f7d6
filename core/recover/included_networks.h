// Networks that need no training of one's own. Any thread.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/recover/weights_file.h"

namespace qray {

// "bilinear" (an empty one), "untrained" or "default", the one trained on the included scenes
// (docs/recover.md). Else kInvalid.
Result<Network> included_network(std::string_view name);

}  // namespace qray
