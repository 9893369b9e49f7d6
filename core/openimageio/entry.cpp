#include "core/openimageio/entry.h"

namespace qray::openimageio {

extern "C" __attribute__((visibility("default"))) const ImageLibrary* qray_image_library();

extern "C" const ImageLibrary* qray_image_library() {
  static constexpr ImageLibrary kLibrary{.read_image = read_image,
                                         .read_image_row = read_image_row,
                                         .read_image_metadata = read_image_metadata,
                                         .encode_image = encode_image,
                                         .encode_layers = encode_layers,
                                         .read_layer_names = read_layer_names,
                                         .read_layer = read_layer,
                                         .write_gif = write_gif,
                                         .read_picture_info = read_picture_info,
                                         .read_picture_rows = read_picture_rows,
                                         .read_picture_bytes = read_picture_bytes};
  return &kLibrary;
}

}  // namespace qray::openimageio
