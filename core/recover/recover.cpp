#include "core/recover/recover.h"

#include <algorithm>

#include "core/recover/bilinear.h"
#include "core/recover/fast_recovery.h"
#include "core/recover/pyramid_pass.h"
#include "core/recover/shrink.h"
#include "core/recover/upsample.h"

namespace qray {
namespace {

int even(int n) { return n + n % 2; }

// The picture moved by (dx, dy) to the right and down, to even sides; the edges go on.
Image moved(const Image& image, int dx, int dy) {
  Image out(even(image.width() + dx), even(image.height() + dy), image.channels());
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      for (int c = 0; c < image.channels(); ++c)
        out.at(x, y, c) = image.at(std::clamp(x - dx, 0, image.width() - 1),
                                   std::clamp(y - dy, 0, image.height() - 1), c);
  return out;
}

// What the network makes of the first pixels of the blocks, whatever its energy.
Image guess(const Network& net, const RecoveryInput& input, TaskPool& pool) {
  if (net.hidden == 0) return bilinear_recovery(input.colour);
  FastRecovery recovery(net, input.colour.width(), input.colour.height());
  return recovery.run(input.features, input.colour, input.noise, pool);
}

// What the pyramid makes of all pixels, and the samples by as much as they are surer.
Image clean(std::span<const float> pyramid, const RecoveryInput& input, TaskPool& pool) {
  PyramidPass pass;
  const Image guessed = pass.recover(pyramid, {input, exposure_of(input.colour)}, &pool);
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

// Of all pixels: the mean of what each of the four of the blocks makes of the picture.
Image mean_of_guesses(const Network& net, const RecoveryInput& input, TaskPool& pool) {
  Image mean(input.colour.width(), input.colour.height(), 3);
  for (int dy : {0, 1})
    for (int dx : {0, 1}) {
      const Image part = guess(
          net,
          {moved(input.features, dx, dy), moved(input.colour, dx, dy), moved(input.noise, dx, dy)},
          pool);
      for (int y = 0; y < mean.height(); ++y)
        for (int x = 0; x < mean.width(); ++x)
          mean.set_rgb(x, y, mean.rgb(x, y) + part.rgb(x + dx, y + dy) * 0.25f);
    }
  return mean;
}

Recovered with_lights(Recovered recovered, const RecoveryInput& input) {
  for (size_t i = 0; i < input.shown.data().size(); ++i)
    recovered.picture.data()[i] += input.shown.data()[i];
  return recovered;
}

}  // namespace

Recovered recover_quarter(const Network& net, const RecoveryInput& input, TaskPool& pool) {
  Image picture =
      net.pyramid.empty()
          ? guess(net, input, pool)
          : upsampled(clean(net.pyramid, first_pixels(input, pool), pool), input.features, pool);
  if (net.hidden == 0) return with_lights({std::move(picture)}, input);
  return with_lights(balanced(std::move(picture), input.colour, 2, pool), input);
}

Recovered recover_all(const Network& net, const RecoveryInput& input, TaskPool& pool) {
  Image picture = net.pyramid.empty() ? shrink_towards(mean_of_guesses(net, input, pool),
                                                       input.colour, input.own_error, pool)
                                      : clean(net.pyramid, input, pool);
  return with_lights(balanced(std::move(picture), input.colour, 1, pool), input);
}

}  // namespace qray
