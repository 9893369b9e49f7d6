// Open Image Denoise, where its library is on the machine: a peer to measure ours against, and for
// people who have it. Found at run time, so that nothing needs it. Any thread; its own threads
// work.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/image/image.h"

namespace qray {

class OpenImageDenoise {
 public:
  // Version 2, as the loader of the system finds it. kUnsupported where there is none.
  static Result<std::shared_ptr<const OpenImageDenoise>> open();
  virtual ~OpenImageDenoise() = default;

  // A picture of all pixels, by the filter of the best quality, with albedo and normal that were
  // filtered before. `features`: kFeatures channels.
  virtual Result<Image> denoise(const Image& features, const Image& colour, int threads) const = 0;
};

}  // namespace qray
