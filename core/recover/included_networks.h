// Networks that need no training of one's own. Any thread.
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/recover/weights_file.h"

namespace qray {

// No network at all: bilinear interpolation.
inline Network no_network() { return {0, {}}; }

// "bilinear", "untrained" or "default", the one trained on the included scenes (docs/recover.md).
// Else kInvalid.
Result<Network> included_network(std::string_view name);

// A file's network; where it has no pyramid, with the default one's.
Network with_pyramid(Network network);

}  // namespace qray
