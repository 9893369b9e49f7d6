#include "core/job/picture_passes.h"

#include <cctype>
#include <cmath>

#include "core/base/check.h"
#include "core/render/light_split.h"

namespace qray {
namespace {

// A channel of what is known of the noise, changed by `value`.
template <class Value>
Image of_noise(const Image& noise, FilmNoise channel, Value value) {
  Image out(noise.width(), noise.height(), 1);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) out.at(x, y, 0) = value(noise.at(x, y, channel));
  return out;
}

void add_light(const Film& film, const RenderSettings& settings, const LightSplit& split,
               std::vector<PictureLayer>& out) {
  const auto wants = [&](PicturePass pass) { return settings.picture_passes.has(pass); };
  if (wants(PicturePass::kDirect))
    out.push_back({"direct", "RGB", film.layer(film.layers().bounce(1))});
  if (wants(PicturePass::kIndirect)) out.push_back({"indirect", "RGB", film.indirect()});
  if (wants(PicturePass::kBounces))
    for (int i = 1; i <= film.layers().bounces; ++i)
      out.push_back({"bounce" + std::to_string(i), "RGB", film.layer(film.layers().bounce(i))});
  if (wants(PicturePass::kEmission)) out.push_back({"emission", "RGB", film.seen()});
  for (size_t g = 0; g < split.groups.size(); ++g)
    out.push_back({light_group_layer(split.groups[g]), "RGB",
                   film.layer(film.layers().group(static_cast<int>(g)))});
}

void add_noise(const Film& film, const RenderSettings& settings, std::vector<PictureLayer>& out) {
  if (!passes_need_noise(settings)) return;
  const std::shared_ptr<const Image> noise = film.noise();
  QRAY_CHECK(noise != nullptr);
  if (settings.picture_passes.has(PicturePass::kSamples))
    out.push_back({"samples", "X", of_noise(*noise, kSamples, [](float n) { return n; })});
  // What has no two halves of samples says nothing.
  const auto squared = [](float error) { return std::isfinite(error) ? error * error : -1.0f; };
  if (settings.picture_passes.has(PicturePass::kVariance))
    out.push_back({"variance", "X", of_noise(*noise, kOwnError, squared)});
}

}  // namespace

std::string light_group_layer(const std::string& group) {
  std::string name = "Combined_" + group;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
  return name;
}

bool passes_need_noise(const RenderSettings& settings) {
  return settings.picture_passes.has_any({PicturePass::kSamples, PicturePass::kVariance});
}

Result<LayeredPicture> make_picture_passes(const PreparedScene& scene,
                                           const RenderSettings& settings, const Film& film,
                                           const std::optional<Image>& recovered,
                                           const NeighbourFrames& neighbours, TaskPool& pool,
                                           std::stop_token stop) {
  const Result<LightSplit> split = light_split(scene.scene, settings);
  if (!split.ok()) return split.error();
  LayeredPicture out;
  out.layers.push_back({"", "RGB", recovered ? *recovered : film.develop()});
  if (settings.picture_passes.has(PicturePass::kSampled))
    out.layers.push_back({"sampled", "RGB", film.develop()});
  if (recovered && settings.picture_passes.has(PicturePass::kRecovered))
    out.layers.push_back({"recovered", "RGB", *recovered});
  add_light(film, settings, split.value(), out.layers);
  out.groups = split.value().groups.size();
  out.first_group = out.layers.size() - out.groups;
  add_noise(film, settings, out.layers);
  Result<SurfacePasses> surfaces =
      render_surface_passes(scene, settings, neighbours, pool, std::move(stop));
  if (!surfaces.ok()) return surfaces.error();
  for (PictureLayer& layer : surfaces.value().layers) out.layers.push_back(std::move(layer));
  out.metadata = std::move(surfaces.value().metadata);
  return out;
}

}  // namespace qray
