#include "core/job/recover_picture.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/recover/included_networks.h"
#include "core/render/features.h"

namespace qray {

static_assert(kFeatureChannels == kFeatures);

constexpr float kRaysCountFor = 4;  // samples, of what lights show of themselves

Result<Recovery> included_recovery(const std::string& name) {
  if (name == "oidn") {
    Result<std::shared_ptr<const OpenImageDenoise>> peer = OpenImageDenoise::open();
    if (!peer.ok()) return peer.error();
    return Recovery{name, Network{}, std::move(peer).value()};
  }
  Result<Network> network = included_network(name);
  if (!network.ok()) return network.error();
  return Recovery{name, std::move(network).value()};
}

Status check_recovery(const Recovery& recovery, const RenderSettings& settings) {
  if (!recovery.peer || settings.pixels == Pixels::kAll) return {};
  return Error{ErrorCode::kInvalid, "expected 'all', of which alone oidn makes a picture",
               "/pixels"};
}

Result<RecoveryInput> recovery_input(const PreparedScene& scene, const RenderSettings& settings,
                                     const Film& film, TaskPool& pool, std::stop_token stop) {
  const std::shared_ptr<const Image> noise = film.noise();
  QRAY_CHECK(noise != nullptr);
  Result<FeaturePictures> rays = render_features(scene, settings, pool, std::move(stop));
  if (!rays.ok()) return rays.error();
  Image smooth = Image::unset(noise->width(), noise->height(), 1),
        own = Image::unset(noise->width(), noise->height(), 1), colour, shown;
  pool.run(2, [&](size_t i, int) { i == 0 ? colour = film.develop() : shown = film.seen(); });
  const size_t width = static_cast<size_t>(noise->width());
  pool.run(static_cast<size_t>(noise->height()), [&](size_t row, int) {
    for (size_t i = row * width; i < (row + 1) * width; ++i) {
      const float* at = &noise->data()[kFilmNoiseChannels * i];
      smooth.data()[i] = at[kRelativeError] / (1 + at[kRelativeError]);
      own.data()[i] = at[kOwnError];
      for (size_t k = 3 * i; k < 3 * i + 3; ++k) {
        float& seen = shown.data()[k];
        colour.data()[k] = std::max(0.0f, colour.data()[k] - seen);
        seen = (at[kSamples] * seen + kRaysCountFor * rays.value().emitted.data()[k]) /
               (at[kSamples] + kRaysCountFor);
      }
    }
  });
  return RecoveryInput{std::move(rays.value().features), std::move(colour), std::move(smooth),
                       std::move(own), std::move(shown)};
}

Result<Recovered> recover_picture(const PreparedScene& scene, const RenderSettings& settings,
                                  const Recovery& recovery, const Film& film, TaskPool& pool,
                                  std::stop_token stop) {
  Result<RecoveryInput> input = recovery_input(scene, settings, film, pool, std::move(stop));
  if (!input.ok()) return input.error();
  if (recovery.peer) {
    // It sees the whole picture, and what shines as white.
    Image& features = input.value().features;
    for (int y = 0; y < features.height(); ++y)
      for (int x = 0; x < features.width(); ++x)
        for (int c = 0; c < 3; ++c)
          features.at(x, y, c) =
              std::min(1.0f, features.at(x, y, c) + input.value().shown.at(x, y, c));
    Result<Image> picture = recovery.peer->denoise(features, film.develop(), pool.threads());
    if (!picture.ok()) return picture.error();
    return Recovered{std::move(picture).value()};
  }
  return settings.pixels == Pixels::kAll ? recover_all(recovery.network, input.value(), pool)
                                         : recover_quarter(recovery.network, input.value(), pool);
}

}  // namespace qray
