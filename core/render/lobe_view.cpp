#include "core/render/lobe_view.h"

#include "core/guide/huang.h"
#include "core/image/false_color.h"
#include "core/render/direction_cube.h"
#include "core/render/pixel_probe.h"

namespace qray {
namespace {

const Rgb kBelow{0.18f};

Vec3 direction_of(int x, int y) {
  const float phi = (static_cast<float>(x) + 0.5f) * (2 * kPi / kLobeWidth) - kPi;
  const float up = kPi / 2 - (static_cast<float>(y) + 0.5f) * (kPi / kLobeHeight);
  return {-std::cos(up) * std::sin(phi), std::sin(up), std::cos(up) * std::cos(phi)};
}

void draw_sphere(const GuideSampler& guide, const GuidePoint& at, bool known, Vec3 facing,
                 Image& image) {
  for (int y = 0; y < kLobeHeight; ++y)
    for (int x = 0; x < kLobeWidth; ++x) {
      const Vec3 w = direction_of(x, y);
      const float pdf_w = known ? guide.pdf_w(at, w) : 0;
      const Rgb color = viridis(log_scale(pdf_w, kLobeLow, kLobeHigh));
      const bool above = dot(w, facing) > 0;
      if (pdf_w > 0) image.set_rgb(x, y, above ? color : lerp(0.7f, color, kBelow));
      if (!(pdf_w > 0) && !above) image.set_rgb(x, y, kBelow);
    }
}

void draw_cube(const HuangGuide& guide, const GuidePoint& at, Image& image) {
  const HuangGuide::Values* values = guide.values(at.key);
  const HuangGuide::Values shares = hemisphere_shares26(at.frame.z);
  const float largest = values ? *std::max_element(values->begin(), values->end()) : 0;
  std::array<Rgb, kDirections26> colors;
  for (size_t a = 0; a < colors.size(); ++a) {
    colors[a] = shares[a] > 0 ? viridis(largest > 0 ? (*values)[a] / largest : 0) : kBelow;
  }
  const Image cube = draw_direction_cube(kLobeHeight, kLobeHeight, colors);
  for (int y = 0; y < cube.height(); ++y)
    for (int x = 0; x < cube.width(); ++x) image.set_rgb(kLobeWidth + x, y, cube.rgb(x, y));
}

}  // namespace

Result<LobeView> render_lobe_view(const PreparedScene& scene, const RenderSettings& settings,
                                  const GuideInspector& guide, int x, int y) {
  const Result<std::optional<PixelProbe>> probe = probe_pixel(scene, settings, &guide, x, y);
  if (!probe.ok()) return probe.error();
  if (!probe.value())
    return Error{ErrorCode::kInvalid, "no surface is seen through this pixel", "/x"};
  const GuidePoint& at = probe.value()->state->at;
  const auto* huang = dynamic_cast<const HuangGuide*>(&guide);
  LobeView view;
  view.known = at.state.valid() && guide.mixture(at, {}).guide > 0;
  view.image = Image(huang ? kLobeWidth + kLobeHeight : kLobeWidth, kLobeHeight, 3);
  draw_sphere(guide, at, view.known, probe.value()->seen.facing, view.image);
  if (huang) draw_cube(*huang, at, view.image);
  return view;
}

}  // namespace qray
