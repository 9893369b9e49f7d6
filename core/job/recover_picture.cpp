#include "core/job/recover_picture.h"

#include "core/base/check.h"
#include "core/render/features.h"

namespace qray {

static_assert(kFeatureChannels == kFeatures);

Result<RecoveryInput> recovery_input(const PreparedScene& scene, const RenderSettings& settings,
                                     const Film& film, TaskPool& pool, std::stop_token stop) {
  const std::shared_ptr<const Image> noise = film.noise();
  QRAY_CHECK(noise != nullptr);
  Image smooth(noise->width(), noise->height(), 1), own = smooth;
  for (size_t i = 0; i < smooth.data().size(); ++i) {
    const float* at = &noise->data()[kFilmNoiseChannels * i];
    smooth.data()[i] = at[kRelativeError] / (1 + at[kRelativeError]);
    own.data()[i] = at[kOwnError];
  }
  Result<Image> features = render_features(scene, settings, pool, std::move(stop));
  if (!features.ok()) return features.error();
  return RecoveryInput{std::move(features).value(), film.develop(), std::move(smooth),
                       std::move(own)};
}

Result<Image> recover_picture(const PreparedScene& scene, const RenderSettings& settings,
                              const Network& network, const Film& film, TaskPool& pool,
                              std::stop_token stop) {
  const Result<RecoveryInput> input = recovery_input(scene, settings, film, pool, std::move(stop));
  if (!input.ok()) return input.error();
  return settings.pixels == Pixels::kAll ? recover_all(network, input.value(), pool)
                                         : recover_quarter(network, input.value(), pool);
}

}  // namespace qray
