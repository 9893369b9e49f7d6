#include "core/image/metrics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace qray {
namespace {

Status check(const Image& image, const char* which) {
  if (image.channels() != 3 || image.empty()) {
    return Error{ErrorCode::kInvalid,
                 "has " + std::to_string(image.channels()) + " channels, expected 3", which};
  }
  for (size_t i = 0; i < image.data().size(); ++i) {
    if (std::isfinite(image.data()[i])) continue;
    const size_t pixel = i / 3, width = static_cast<size_t>(image.width());
    return Error{ErrorCode::kInvalid,
                 "pixel (" + std::to_string(pixel % width) + ", " + std::to_string(pixel / width) +
                     ") is not finite",
                 which};
  }
  return {};
}

std::string size_text(const Image& image) {
  return std::to_string(image.width()) + "x" + std::to_string(image.height());
}

}  // namespace

double relmse(const Image& picture, const Image& reference) {
  double sum = 0;
  for (size_t i = 0; i < reference.data().size(); ++i) {
    const double x = static_cast<double>(picture.data()[i]),
                 r = static_cast<double>(reference.data()[i]);
    sum += (x - r) * (x - r) / (r * r + 0.01);
  }
  return sum / static_cast<double>(reference.data().size());
}

Result<ImageDifference> image_difference(const Image& picture, const Image& reference) {
  if (const Status s = check(picture, "picture"); !s.ok()) return s.error();
  if (const Status s = check(reference, "reference"); !s.ok()) return s.error();
  if (picture.width() != reference.width() || picture.height() != reference.height()) {
    return Error{ErrorCode::kInvalid,
                 "is " + size_text(picture) + ", expected the reference's " + size_text(reference),
                 "picture"};
  }

  ImageDifference result;
  const size_t pixels = picture.data().size() / 3;
  std::vector<double> errors(pixels);
  double light = 0, reference_light = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const float *x = &picture.data()[i * 3], *r = &reference.data()[i * 3];
    for (int c = 0; c < 3; ++c) {
      const double difference = static_cast<double>(x[c]) - r[c];
      errors[i] += difference * difference / (static_cast<double>(r[c]) * r[c] + 0.01) / 3;
      result.max_abs = std::max(result.max_abs, std::abs(difference));
    }
    light += luminance({x[0], x[1], x[2]});
    reference_light += luminance({r[0], r[1], r[2]});
  }

  const size_t kept = pixels - pixels / 1000;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(kept) - 1,
                   errors.end());
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(kept);
  const double small = std::accumulate(errors.begin(), middle, 0.0);
  const double large = std::accumulate(middle, errors.end(), 0.0);
  result.relmse = (small + large) / static_cast<double>(pixels);
  result.relmse_trimmed = small / static_cast<double>(kept);
  result.mean_ratio = light == reference_light ? 1 : light / reference_light;

  const Image flip = flip_map(picture, reference);
  result.flip =
      std::accumulate(flip.data().begin(), flip.data().end(), 0.0) / static_cast<double>(pixels);
  return result;
}

}  // namespace qray
