#include "core/import/sun_sky.h"

#include <algorithm>
#include <cmath>

#include "core/import/daylight_data.h"
#include "core/import/spectrum.h"

namespace qray {
namespace {

constexpr double kPiD = std::numbers::pi;
constexpr double kSunRadius = kSunDegrees / 2 * kPiD / 180;  // as seen, radians
constexpr double kLeastRadius = 0.1 * kPiD / 180;            // meets samples of any pixel
// The model's radiances are of colours of luminance 1 where the eye's sensitivity, summed, is this.
constexpr double kEyeSum = 106.7502593994140625;

// Between neighbours of a list of `count`: the lower's index, and the share of the upper.
struct Between {
  int low;
  double high_share;
};
Between between(double position, int count) {
  const double at = std::clamp(position, 0.0, count - 1.0);
  const int low = std::min(static_cast<int>(at), count - 2);
  return {low, at - low};
}

// Hosek and Wilkie 2012, eq. 8 and 11. The figures are linear in turbidity and in the ground's
// albedo, and Bezier curves over the cube root of the sun's height.
class Sky {
 public:
  Sky(double turbidity, Rgb albedo, double sun_height_rad) {
    const Between t = between(turbidity - 1, 10);
    const double x = std::cbrt(std::clamp(2 * sun_height_rad / kPiD, 0.0, 1.0)), y = 1 - x;
    const double weights[] = {std::pow(y, 5),         5 * std::pow(y, 4) * x,
                              10 * y * y * y * x * x, 10 * y * y * x * x * x,
                              5 * y * std::pow(x, 4), std::pow(x, 5)};
    for (int i = 0; i < 4; ++i) {
      const int of_turbidity = t.low + i / 2, of_albedo = i % 2;
      const double turbidity_share = i / 2 ? t.high_share : 1 - t.high_share;
      for (int p = 0; p < 6; ++p) {
        for (int c = 0; c < 3; ++c) {
          const double a = static_cast<double>(albedo[c]);
          const double w = weights[p] * turbidity_share * (of_albedo ? a : 1 - a);
          for (int k = 0; k < 9; ++k)
            shape_[c][k] += w * kSkyShape[of_turbidity][of_albedo][p][c][k];
          radiance_[c] += w * kSkyRadiance[of_turbidity][of_albedo][p][c] / kEyeSum;
        }
      }
    }
  }

  // theta from the zenith, gamma from the sun.
  Rgb radiance(double theta, double gamma) const {
    const double cos_theta = std::max(std::cos(theta), 0.0), cos_gamma = std::cos(gamma);
    Rgb out;
    for (int c = 0; c < 3; ++c) {
      const double(&k)[9] = shape_[c];
      const double horizon = 1 + k[0] * std::exp(k[1] / (cos_theta + 0.01));
      const double halo =
          (1 + cos_gamma * cos_gamma) / std::pow(1 + k[8] * k[8] - 2 * k[8] * cos_gamma, 1.5);
      const double shape = k[2] + k[3] * std::exp(k[4] * gamma) + k[5] * cos_gamma * cos_gamma +
                           k[6] * halo + k[7] * std::sqrt(cos_theta);
      out[c] = static_cast<float>(std::max(0.0, horizon * shape * radiance_[c]));
    }
    return out;
  }

 private:
  double shape_[3][9] = {}, radiance_[3] = {};
};

// Hosek and Wilkie 2013.
Rgb hosek_sun_radiance(double theta, double turbidity) {
  const Between t = between(turbidity - 1, 10);
  const Between h = between((90 - theta * 180 / kPiD - 2) * 29 / 86, 30);
  Rgb out;
  for (int c = 0; c < 3; ++c) {
    const auto at = [&](int i) {
      return std::lerp(kSunRadiance[i][h.low][c], kSunRadiance[i][h.low + 1][c], h.high_share);
    };
    out[c] = static_cast<float>(std::lerp(at(t.low), at(t.low + 1), t.high_share));
  }
  return out;
}

// Ozone's absorption, 1/cm, from 440 nm at every 10; none below.
constexpr double kOzone[] = {.0,   .003, .006, .009, .014, .021, .03,  .04,  .048, .063, .075,
                             .085, .103, .12,  .12,  .115, .125, .12,  .105, .09,  .079, .067,
                             .057, .048, .036, .028, .023, .018, .014, .011, .01,  .009};
// Of the sun above the air, W / (m^2 sr nm), from 380 nm at every 10.
constexpr double kSun[] = {16559.0, 16233.7, 21127.5, 25888.2, 25829.1, 24232.3, 26760.5, 29658.3,
                           30545.4, 30057.5, 30663.7, 28830.4, 28712.1, 27825.0, 27100.6, 27233.6,
                           26361.3, 25503.8, 25060.2, 25311.6, 25355.9, 25134.2, 24631.5, 24173.2,
                           23685.3, 23212.1, 22827.7, 22339.8, 21970.2, 21526.7, 21097.9, 20728.3,
                           20240.4, 19870.8, 19427.2, 19072.4, 18628.9, 18259.2};

// Preetham et al., appendix A.1, without water and other gases, which absorb beyond 690 nm.
Rgb preetham_sun_radiance(double theta, double turbidity) {
  const double degrees = theta * 180 / kPiD;
  const double mass = 1 / (std::cos(theta) + 0.15 * std::pow(93.885 - degrees, -1.253));
  const double beta = 0.04608365822050 * turbidity - 0.04586025928522;
  std::vector<SpectrumPoint> points;
  for (size_t i = 0; i < std::size(kSun); ++i) {
    const double nm = 380 + 10.0 * static_cast<double>(i), um = nm / 1000;
    const double rayleigh = std::exp(-mass * 0.008735 * std::pow(um, -4.08));
    const double aerosol = std::exp(-mass * beta * std::pow(um, -1.3));
    const double ozone = i < 6 ? 1 : std::exp(-mass * kOzone[i - 6] * 0.35);
    points.push_back({nm, kSun[i] * rayleigh * aerosol * ozone});
  }
  return spectrum_to_rgb(points, SpectrumWeight::kEqualEnergy);
}

Vec3 pixel_direction(double x, double y, int width, int height) {
  const double phi = (x / width - 0.5) * 2 * kPiD, theta = y / height * kPiD;
  return {static_cast<float>(std::sin(theta) * std::sin(phi)), static_cast<float>(std::cos(theta)),
          static_cast<float>(-std::sin(theta) * std::cos(phi))};
}

// Spreads the disk over the pixels it covers, so that its irradiance is exact however coarse they
// are. What the horizon hides of it is left out.
void add_sun(const SunSky& p, Image& image) {
  const int w = image.width(), h = image.height();
  const double sun_theta = std::acos(std::clamp(static_cast<double>(p.to_sun.y), -1.0, 1.0));
  const double radius = std::clamp(kSunRadius * p.sun_radius_scale, kLeastRadius, kPiD / 4);
  const auto cos_radius = static_cast<float>(std::cos(radius));
  constexpr int kFine = 8;                         // squared: samples of a pixel
  std::vector<std::pair<size_t, double>> covered;  // solid angles
  double sum = 0;
  for (int y = 0; y < h; ++y) {
    const double theta = (y + 0.5) / h * kPiD;
    if (std::abs(theta - sun_theta) > radius + kPiD / h) continue;
    const double solid_angle = 2 * kPiD / w * kPiD / h * std::sin(theta);
    for (int x = 0; x < w; ++x) {
      int inside = 0;
      for (int i = 0; i < kFine * kFine; ++i) {
        const Vec3 d =
            pixel_direction(x + (i % kFine + 0.5) / kFine, y + (i / kFine + 0.5) / kFine, w, h);
        inside += dot(d, p.to_sun) >= cos_radius;
      }
      if (inside == 0) continue;
      const double share = solid_angle * inside / (kFine * kFine);
      covered.emplace_back(static_cast<size_t>(y) * static_cast<size_t>(w) + static_cast<size_t>(x),
                           static_cast<double>(inside) / (kFine * kFine));
      sum += share;
    }
  }
  if (covered.empty()) return;
  const double exact = 2 * kPiD * (1 - std::cos(kSunRadius));
  const Rgb disk = p.sun_model == SunModel::kPreetham
                       ? preetham_sun_radiance(sun_theta, p.turbidity)
                       : hosek_sun_radiance(sun_theta, p.turbidity);
  const Rgb radiance = disk * static_cast<float>(p.sun_scale * exact / sum);
  for (const auto& [index, share] : covered) {
    if (index >= static_cast<size_t>(w) * static_cast<size_t>(h) / 2) continue;
    const int x = static_cast<int>(index % static_cast<size_t>(w));
    const int y = static_cast<int>(index / static_cast<size_t>(w));
    image.set_rgb(x, y, image.rgb(x, y) + radiance * static_cast<float>(share));
  }
}

}  // namespace

Image draw_sun_sky(const SunSky& p, int width, int height) {
  Image image(width, height, 3);
  if (!(p.to_sun.y > 0)) return image;
  const double sun_height = std::asin(std::min(static_cast<double>(p.to_sun.y), 1.0));
  const Sky sky(p.turbidity, p.albedo, sun_height);
  for (int y = 0; y < (p.extend ? height : height / 2); ++y) {
    const double theta = (y + 0.5) / height * kPiD;
    // Below the horizon, what is at it, dimmed smoothly to nothing.
    const double depth = std::clamp(2 - 2 * theta / kPiD, 0.0, 1.0);
    const double fade = theta < kPiD / 2 ? 1 : depth * depth * (3 - 2 * depth);
    for (int x = 0; x < width; ++x) {
      const double at = std::min(theta, kPiD / 2 - 0.001);
      const Vec3 d = pixel_direction(x + 0.5, at / kPiD * height, width, height);
      const double gamma = std::acos(std::clamp(static_cast<double>(dot(d, p.to_sun)), -1.0, 1.0));
      image.set_rgb(x, y, sky.radiance(at, gamma) * static_cast<float>(fade * p.sky_scale));
    }
  }
  if (p.sun_scale > 0) add_sun(p, image);
  return image;
}

Vec3 sun_direction(const SunTime& t) {
  const double hours = t.hour - t.timezone;  // universal time
  // The Julian day of noon of the date.
  const long a = (t.month - 14) / 12;
  const long julian = 1461L * (t.year + 4800 + a) / 4 + 367L * (t.month - 2 - 12 * a) / 12 -
                      3L * ((t.year + 4900 + a) / 100) / 4 + t.day - 32075;
  const double days = static_cast<double>(julian) - 0.5 + hours / 24 - 2451545.0;

  const double omega = 2.1429 - 0.0010394594 * days;
  const double mean = 4.8950630 + 0.017202791698 * days;
  const double anomaly = 6.2400600 + 0.0172019699 * days;
  const double longitude = mean + 0.03341607 * std::sin(anomaly) +
                           0.00034894 * std::sin(2 * anomaly) - 0.0001134 -
                           0.0000203 * std::sin(omega);
  const double obliquity = 0.4090928 - 6.2140e-9 * days + 0.0000396 * std::cos(omega);
  const double ascension =
      std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
  const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));

  const double sidereal = 6.6974243242 + 0.0657098283 * days + hours;
  const double hour_angle = (sidereal * 15 + t.longitude) * kPiD / 180 - ascension;
  const double latitude = t.latitude * kPiD / 180;
  const double theta = std::acos(std::cos(latitude) * std::cos(hour_angle) * std::cos(declination) +
                                 std::sin(declination) * std::sin(latitude));
  const double azimuth =  // from north over east
      std::atan2(-std::sin(hour_angle), std::tan(declination) * std::cos(latitude) -
                                            std::sin(latitude) * std::cos(hour_angle));
  return {static_cast<float>(std::sin(azimuth) * std::sin(theta)),
          static_cast<float>(std::cos(theta)),
          static_cast<float>(-std::cos(azimuth) * std::sin(theta))};
}

}  // namespace qray
