#include "core/render/environment_light.h"

#include <algorithm>
#include <cmath>

#include "core/math/distribution.h"
#include "core/math/warp.h"

namespace qray {

EnvironmentLight::EnvironmentLight(const Environment& environment)
    : environment_(environment),
      width_(environment.image.width()),
      height_(environment.image.height()) {
  if (environment.image.empty()) {
    mean_luminance_ = luminance(environment.radiance);
    return;
  }
  const size_t w = static_cast<size_t>(width_), h = static_cast<size_t>(height_);
  row_sine_.assign(h + 2, 0);
  for (size_t j = 1; j <= h; ++j)
    row_sine_[j] = std::sin(kPi * (static_cast<float>(j) - 0.5f) / static_cast<float>(h));
  cell_cdf_.resize((h + 1) * (w + 1));
  std::vector<float> cells(w), rows(h + 1);
  double sum = 0;
  for (size_t row = 0; row <= h; ++row) {
    for (size_t x = 0; x < w; ++x)
      cells[x] = cell_weight(static_cast<int>(x), static_cast<int>(row));
    const double height = row == 0 || row == h ? 0.5 : 1;
    rows[row] = static_cast<float>(
        height * fill_cdf(cells, std::span(cell_cdf_).subspan(row * (w + 1), w + 1)));
    sum += double{rows[row]};
  }
  row_cdf_.resize(h + 2);
  fill_cdf(rows, row_cdf_);
  // The integral over the sphere is 2 pi^2 of the mean over the picture.
  mean_luminance_ = luminance(environment.radiance) * (kPi / 2) *
                    static_cast<float>(sum / static_cast<double>(w * h));
}

float EnvironmentLight::node(int column, int row) const {
  const int y = std::clamp(row - 1, 0, height_ - 1);  // at the poles the sine is 0
  return luminance(environment_.image.rgb(column == width_ ? 0 : column, y)) *
         row_sine_[static_cast<size_t>(row)];
}

float EnvironmentLight::cell_weight(int column, int row) const {
  return 0.25f * (node(column, row) + node(column + 1, row) + node(column, row + 1) +
                  node(column + 1, row + 1));
}

EnvironmentLight::Place EnvironmentLight::place(Vec3 wi) const {
  const Vec3 d = environment_.to_world.transposed() * wi;
  const float sin_theta = std::sqrt(d.x * d.x + d.z * d.z);
  const float u = 0.5f + std::atan2(d.x, -d.z) * (0.5f * kInvPi);
  const float x = u * static_cast<float>(width_) - 0.5f;
  const float column = std::floor(x);
  Place at{(static_cast<int>(column) + width_) % width_, 0, {x - column, 0}, sin_theta};
  // From the nearer pole, or rounding would take what is close to the other one.
  const float from_pole =
      std::atan2(sin_theta, std::abs(d.y)) * kInvPi * static_cast<float>(height_);
  if (from_pole < 0.5f) {  // half as high as other cells
    at.row = d.y > 0 ? 0 : height_;
    at.offset.y = d.y > 0 ? 2 * from_pole : 1 - 2 * from_pole;
    return at;
  }
  const float rows = (d.y > 0 ? from_pole : static_cast<float>(height_) - from_pole) + 0.5f;
  at.row = std::clamp(static_cast<int>(rows), 0, height_);
  at.offset.y = std::min(rows - static_cast<float>(at.row), 1.0f);
  return at;
}

EnvironmentLight::Sample EnvironmentLight::sample(Vec2 u) const {
  if (width_ == 0) return {square_to_uniform_sphere(u), kUniformSpherePdfW};
  const CdfPick row = pick_by_cdf(row_cdf_, u.y);
  const size_t columns = static_cast<size_t>(width_) + 1;
  const CdfPick column = pick_by_cdf(
      std::span(cell_cdf_).subspan(static_cast<size_t>(row.index) * columns, columns), u.x);
  Place at{column.index, row.index, {}, 0};
  const float n00 = node(at.column, at.row), n10 = node(at.column + 1, at.row);
  const float n01 = node(at.column, at.row + 1), n11 = node(at.column + 1, at.row + 1);
  const float y = sample_linear(row.offset, n00 + n10, n01 + n11);
  at.offset = {sample_linear(column.offset, lerp(y, n00, n01), lerp(y, n10, n11)), y};

  const bool south = at.row == height_;
  const float from_pole = south         ? 0.5f * (1 - y)
                          : at.row == 0 ? 0.5f * y
                                        : static_cast<float>(at.row) - 0.5f + y;
  const float theta = kPi * from_pole / static_cast<float>(height_);
  const float phi =
      2 * kPi *
      ((static_cast<float>(at.column) + 0.5f + at.offset.x) / static_cast<float>(width_) - 0.5f);
  at.sin_theta = std::sin(theta);
  const Vec3 d{at.sin_theta * std::sin(phi), (south ? -1 : 1) * std::cos(theta),
               -at.sin_theta * std::cos(phi)};
  return {environment_.to_world * d, pdf_w(at)};
}

float EnvironmentLight::pdf_w(Vec3 wi) const {
  return width_ == 0 ? kUniformSpherePdfW : pdf_w(place(wi));
}

// The cell's probability is read from the table that sample() walks: what rounding does to the one
// it does to the other.
float EnvironmentLight::pdf_w(const Place& at) const {
  const float n00 = node(at.column, at.row), n10 = node(at.column + 1, at.row);
  const float n01 = node(at.column, at.row + 1), n11 = node(at.column + 1, at.row + 1);
  const float mean = 0.25f * (n00 + n10 + n01 + n11);
  if (!(mean > 0 && at.sin_theta > 0)) return 0;
  const float value = lerp(at.offset.y, lerp(at.offset.x, n00, n10), lerp(at.offset.x, n01, n11));
  const size_t row = static_cast<size_t>(at.row);
  const size_t cell = row * (static_cast<size_t>(width_) + 1) + static_cast<size_t>(at.column);
  const float probability =
      (row_cdf_[row + 1] - row_cdf_[row]) * (cell_cdf_[cell + 1] - cell_cdf_[cell]);
  const float height = at.row == 0 || at.row == height_ ? 0.5f : 1.0f;
  const float area = height / (static_cast<float>(width_) * static_cast<float>(height_));
  return probability / area * (value / mean) / (2 * kPi * kPi * at.sin_theta);
}

Rgb EnvironmentLight::radiance(Vec3 wi) const {
  if (width_ == 0) return environment_.radiance;
  const Image& image = environment_.image;
  const Place at = place(wi);
  const int x0 = at.column, x1 = x0 + 1 == width_ ? 0 : x0 + 1;
  const int y0 = std::max(at.row - 1, 0), y1 = std::min(at.row, height_ - 1);
  const Rgb top = lerp(at.offset.x, image.rgb(x0, y0), image.rgb(x1, y0));
  const Rgb bottom = lerp(at.offset.x, image.rgb(x0, y1), image.rgb(x1, y1));
  return environment_.radiance * lerp(at.offset.y, top, bottom);
}

float EnvironmentLight::brightest() const {
  float texel = width_ == 0 ? 1.0f : 0.0f;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x)
      texel = std::max(texel, luminance(environment_.image.rgb(x, y)));
  return texel * luminance(environment_.radiance);
}

}  // namespace qray
