// Pictures as plain floats in place of OpenImageIO, for tests that start a server thousands of
// times: its 265 shared libraries take .2 s to load and make each fork of the process five times as
// slow. What the server's records need is read, and no textures.
#pragma once

#include "core/image/image_library.h"

namespace qray::server::test {

const ImageLibrary& plain_pictures();

}  // namespace qray::server::test
