// A layer of a picture as something to look at. Pure; any thread.
#pragma once

#include "core/image/picture_layers.h"

namespace qray {

// Three channels, linear, for encode_image(). Colours ("RGB") stay as they are. Three numbers
// between -1 and 1 ("XYZ" of a normal) go from black to white; other numbers from the least to the
// greatest that are there, a single one in viridis. Hashes of names ("rgba" of Cryptomatte) and
// whole numbers that name something (a layer "..._id") each have a colour.
Image layer_view(const PictureLayer& layer);

}  // namespace qray
