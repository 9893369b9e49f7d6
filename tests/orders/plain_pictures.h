// Pictures as plain floats in place of OpenImageIO, whose 265 shared libraries make each fork of
// the process five times as slow. What reads a picture here is all that the server's records need.
#pragma once

#include "core/image/image_library.h"

namespace qray::server::test {

const ImageLibrary& plain_pictures();

}  // namespace qray::server::test
