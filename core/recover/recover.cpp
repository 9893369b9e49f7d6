#include "core/recover/recover.h"

#include "core/recover/bilinear.h"
#include "core/recover/pyramid_pass.h"
#include "core/recover/shrink.h"
#include "core/recover/upsample.h"

namespace qray {
namespace {

// What the network makes of all pixels, and the samples by as much as they are surer.
Image clean(const Network& net, const RecoveryInput& input, TaskPool& pool) {
  PyramidPass pass;
  const Image guessed = pass.recover(net.values, {input, exposure_of(input.colour)}, &pool);
  return shrink_towards(guessed, input.colour, input.own_error, pool);
}

// Of each block of 2 x 2 the first pixel: a picture of its own.
Image first_pixels(const Image& image, TaskPool& pool) {
  Image out = Image::unset(image.width() / 2, image.height() / 2, image.channels());
  pool.run(static_cast<size_t>(out.height()), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < out.width(); ++x)
      for (int c = 0; c < out.channels(); ++c) out.at(x, y, c) = image.at(2 * x, 2 * y, c);
  });
  return out;
}
RecoveryInput first_pixels(const RecoveryInput& input, TaskPool& pool) {
  return {first_pixels(input.features, pool), first_pixels(input.colour, pool),
          first_pixels(input.noise, pool), first_pixels(input.own_error, pool)};
}

Recovered with_lights(Recovered recovered, const RecoveryInput& input) {
  for (size_t i = 0; i < input.shown.data().size(); ++i)
    recovered.picture.data()[i] += input.shown.data()[i];
  return recovered;
}

}  // namespace

Recovered recover_quarter(const Network& net, const RecoveryInput& input, TaskPool& pool) {
  if (net.empty()) return with_lights({bilinear_recovery(input.colour)}, input);
  const RecoveryInput known = first_pixels(input, pool);
  Image picture = upsampled(clean(net, known, pool), input.features, pool);
  return with_lights(balanced(std::move(picture), known.colour, known.own_error, pool), input);
}

Recovered recover_all(const Network& net, const RecoveryInput& input, TaskPool& pool) {
  if (net.empty()) return with_lights({input.colour}, input);
  return with_lights(balanced(clean(net, input, pool), input.colour, input.own_error, pool), input);
}

}  // namespace qray
