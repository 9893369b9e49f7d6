#include "core/image/flip.h"

#include <cmath>
#include <numeric>
#include <vector>

#include "core/base/check.h"

namespace qray {
namespace {

constexpr float kQc = 0.7f, kPc = 0.4f, kPt = 0.95f;  // colour remap
constexpr float kQf = 0.5f, kFeatureWidthDeg = 0.082f;

using Plane = std::vector<float>;  // one channel, rows from the top

struct Planes {
  int width, height;
  Plane c[3];
  Planes(int w, int h) : width(w), height(h) {
    for (Plane& p : c) p.resize(static_cast<size_t>(w) * static_cast<size_t>(h));
  }
};

// Rec.709 primaries and D65 as exact fractions of the chromaticities.
constexpr Vec3 rgb_to_xyz(Vec3 c) {
  return {static_cast<float>(10135552.0 / 24577794) * c.x +
              static_cast<float>(8788810.0 / 24577794) * c.y +
              static_cast<float>(4435075.0 / 24577794) * c.z,
          static_cast<float>(2613072.0 / 12288897) * c.x +
              static_cast<float>(8788810.0 / 12288897) * c.y +
              static_cast<float>(887015.0 / 12288897) * c.z,
          static_cast<float>(1425312.0 / 73733382) * c.x +
              static_cast<float>(8788810.0 / 73733382) * c.y +
              static_cast<float>(70074185.0 / 73733382) * c.z};
}
Vec3 xyz_to_rgb(Vec3 c) {
  return {3.241003275f * c.x - 1.537398934f * c.y - 0.498615861f * c.z,
          -0.969224334f * c.x + 1.875930071f * c.y + 0.041554224f * c.z,
          0.055639423f * c.x - 0.204011202f * c.y + 1.057148933f * c.z};
}
constexpr Vec3 kWhite = rgb_to_xyz({1, 1, 1});

Vec3 rgb_to_ycxcz(Vec3 c) {
  const Vec3 n = rgb_to_xyz(c);
  const float x = n.x / kWhite.x, y = n.y / kWhite.y, z = n.z / kWhite.z;
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}
Vec3 ycxcz_to_rgb(Vec3 c) {
  const float y = (c.x + 16) / 116;
  return xyz_to_rgb({(c.y / 500 + y) * kWhite.x, y * kWhite.y, (y - c.z / 200) * kWhite.z});
}
// L*a*b*, chroma scaled by the Hunt effect (section 4.1.2).
Vec3 rgb_to_hunt_lab(Vec3 c) {
  const Vec3 n = rgb_to_xyz(c);
  const auto f = [](float t) {
    constexpr float kDelta = 6.0f / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0f / 29;
  };
  const float x = f(n.x / kWhite.x), y = f(n.y / kWhite.y), z = f(n.z / kWhite.z);
  const float l = 116 * y - 16;
  return {l, 0.01f * l * 500 * (x - y), 0.01f * l * 200 * (y - z)};
}
float hyab(Vec3 a, Vec3 b) { return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z); }

// kernel has 2 radius + 1 taps; the picture's edge pixels continue outward.
Plane convolve(const Plane& in, int width, int height, const std::vector<float>& kernel,
               bool rows) {
  const int radius = static_cast<int>(kernel.size()) / 2;
  Plane out(in.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float sum = 0;
      for (int k = -radius; k <= radius; ++k) {
        const int xk = rows ? std::clamp(x + k, 0, width - 1) : x;
        const int yk = rows ? y : std::clamp(y + k, 0, height - 1);
        sum += kernel[static_cast<size_t>(k + radius)] *
               in[static_cast<size_t>(yk) * static_cast<size_t>(width) + static_cast<size_t>(xk)];
      }
      out[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)] = sum;
    }
  return out;
}
Plane convolve(const Plane& in, int width, int height, const std::vector<float>& along_x,
               const std::vector<float>& along_y) {
  return convolve(convolve(in, width, height, along_x, true), width, height, along_y, false);
}

// A contrast sensitivity function as a sum of two Gaussians, eq. 4 and table 1. `a` is per
// frequency; in space each is a sqrt(pi/b) exp(-pi^2 x^2 / b), x in degrees.
struct Sensitivity {
  float a1, b1, a2, b2;
};
constexpr Sensitivity kSensitivities[3] = {
    {1, 0.0047f, 0, 1e-5f}, {1, 0.0053f, 0, 1e-5f}, {34.1f, 0.04f, 13.5f, 0.025f}};
constexpr float kWidestB = 0.04f;

void filter_sensitivity(Planes& p, float pixels_per_degree) {
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidestB / (2 * kPi * kPi)) * pixels_per_degree));
  for (int channel = 0; channel < 3; ++channel) {
    const Sensitivity& s = kSensitivities[channel];
    Plane total(p.c[channel].size());
    float mass = 0;
    for (const auto& [a, b] : {std::pair{s.a1, s.b1}, std::pair{s.a2, s.b2}}) {
      if (a == 0) continue;
      std::vector<float> kernel;
      for (int k = -radius; k <= radius; ++k)
        kernel.push_back(std::exp(-sqr(kPi * static_cast<float>(k) / pixels_per_degree) / b));
      const float height = a * std::sqrt(kPi / b);
      mass += height * sqr(std::accumulate(kernel.begin(), kernel.end(), 0.0f));
      const Plane part = convolve(p.c[channel], p.width, p.height, kernel, kernel);
      for (size_t i = 0; i < total.size(); ++i) total[i] += height * part[i];
    }
    for (float& v : total) v /= mass;
    p.c[channel] = std::move(total);
  }
}

// Strength of edges and of points in the achromatic channel in [0, 1], section 4.2.
struct Features {
  Plane edges, points;
};
Features find_features(const Plane& y, int width, int height, float pixels_per_degree) {
  const float sd = 0.5f * kFeatureWidthDeg * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sd));
  std::vector<float> smooth, slope, bend;
  float smooth_sum = 0, slope_sum = 0, bend_up = 0, bend_down = 0;
  for (int k = -radius; k <= radius; ++k) {
    const float x = static_cast<float>(k), g = std::exp(-sqr(x) / (2 * sqr(sd)));
    smooth.push_back(g);
    slope.push_back(-x * g);
    bend.push_back((sqr(x / sd) - 1) * g);
    smooth_sum += g;
    slope_sum += std::max(0.0f, slope.back());
    (bend.back() > 0 ? bend_up : bend_down) += std::abs(bend.back());
  }
  // Positive weights sum to 1, negative to -1.
  for (float& v : smooth) v /= smooth_sum;
  for (float& v : slope) v /= slope_sum;
  for (float& v : bend) v /= v > 0 ? bend_up : bend_down;

  const auto strength = [&](const std::vector<float>& kernel) {
    Plane x = convolve(y, width, height, kernel, smooth);
    const Plane v = convolve(y, width, height, smooth, kernel);
    for (size_t i = 0; i < x.size(); ++i) x[i] = std::hypot(x[i], v[i]);
    return x;
  };
  return {strength(slope), strength(bend)};
}

// Colour as seen, and features.
struct Seen {
  std::vector<Vec3> lab;
  Features features;
};
Seen see(const Image& image, float pixels_per_degree) {
  Planes p(image.width(), image.height());
  const size_t count = p.c[0].size();
  for (size_t i = 0; i < count; ++i) {
    const float* c = &image.data()[i * 3];
    const Vec3 opponent = rgb_to_ycxcz(
        {std::clamp(c[0], 0.0f, 1.0f), std::clamp(c[1], 0.0f, 1.0f), std::clamp(c[2], 0.0f, 1.0f)});
    for (int k = 0; k < 3; ++k) p.c[k][i] = opponent[k];
  }
  Plane y = p.c[0];
  for (float& v : y) v = (v + 16) / 116;
  Seen seen;
  seen.features = find_features(y, p.width, p.height, pixels_per_degree);

  filter_sensitivity(p, pixels_per_degree);
  seen.lab.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const Vec3 c = ycxcz_to_rgb({p.c[0][i], p.c[1][i], p.c[2][i]});
    seen.lab[i] = rgb_to_hunt_lab(max(min(c, {1, 1, 1}), {0, 0, 0}));
  }
  return seen;
}

// Eq. 9: the largest difference in the sRGB gamut (green to blue) goes to 1, most of the scale to
// the small ones.
float remap_color(float difference) {
  static const float largest =
      std::pow(hyab(rgb_to_hunt_lab({0, 1, 0}), rgb_to_hunt_lab({0, 0, 1})), kQc);
  const float v = std::pow(difference, kQc), knee = kPc * largest;
  return v < knee ? v * kPt / knee : kPt + (v - knee) / (largest - knee) * (1 - kPt);
}

}  // namespace

Image flip_map(const Image& picture, const Image& reference, float pixels_per_degree) {
  QRAY_CHECK(picture.channels() == 3 && reference.channels() == 3 &&
             picture.width() == reference.width() && picture.height() == reference.height());
  const Seen a = see(picture, pixels_per_degree), b = see(reference, pixels_per_degree);
  Image map(picture.width(), picture.height(), 1);
  for (size_t i = 0; i < map.data().size(); ++i) {
    const float color = remap_color(hyab(a.lab[i], b.lab[i]));
    const float feature = std::max(std::abs(a.features.edges[i] - b.features.edges[i]),
                                   std::abs(a.features.points[i] - b.features.points[i]));
    const float features = std::pow(feature / std::numbers::sqrt2_v<float>, kQf);
    map.data()[i] = std::pow(color, 1 - features);  // eq. 13
  }
  return map;
}

}  // namespace qray
