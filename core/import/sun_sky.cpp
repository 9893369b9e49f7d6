#include "core/import/sun_sky.h"

#include <algorithm>
#include <cmath>

#include "core/import/spectrum.h"

namespace qray {
namespace {

constexpr double kPiD = std::numbers::pi;
constexpr double kSunRadius = 0.5358 / 2 * kPiD / 180;  // as seen, radians
// Candela per square metre of a spectrum of constant 1 W / (m^2 sr nm): 683 lm/W times the
// integral of the eye's sensitivity, 106.857 nm.
constexpr double kCandela = 683 * 106.856895;

// Perez' distribution, relative: theta from the zenith, gamma from the sun.
struct Perez {
  double a, b, c, d, e;
  double operator()(double theta, double gamma) const {
    return (1 + a * std::exp(b / std::max(std::cos(theta), 1e-3))) *
           (1 + c * std::exp(d * gamma) + e * std::cos(gamma) * std::cos(gamma));
  }
};

// Preetham et al., appendix A.2: luminance (cd / m^2) and chromaticity.
class Sky {
 public:
  Sky(double turbidity, double sun_theta) : sun_theta_(sun_theta) {
    const double t = turbidity, s = sun_theta, s2 = s * s, s3 = s2 * s;
    perez_[0] = {0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251,
                 0.1206 * t - 2.5771, -0.0670 * t + 0.3703};
    perez_[1] = {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125,
                 -0.0641 * t - 0.8989, -0.0033 * t + 0.0452};
    perez_[2] = {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102,
                 -0.0441 * t - 1.6537, -0.0109 * t + 0.0529};
    const double chi = (4.0 / 9 - t / 120) * (kPiD - 2 * s);
    zenith_[0] = 1000 * ((4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192);
    zenith_[1] = t * t * (0.00166 * s3 - 0.00375 * s2 + 0.00209 * s) +
                 t * (-0.02903 * s3 + 0.06377 * s2 - 0.03202 * s + 0.00394) +
                 (0.11693 * s3 - 0.21196 * s2 + 0.06052 * s + 0.25886);
    zenith_[2] = t * t * (0.00275 * s3 - 0.00610 * s2 + 0.00317 * s) +
                 t * (-0.04214 * s3 + 0.08970 * s2 - 0.04153 * s + 0.00516) +
                 (0.15346 * s3 - 0.26756 * s2 + 0.06670 * s + 0.26688);
  }

  Rgb radiance(double theta, double gamma) const {
    double yxy[3];
    for (int i = 0; i < 3; ++i)
      yxy[i] = zenith_[i] * perez_[i](theta, gamma) / perez_[i](0, sun_theta_);
    const double luminance = std::max(0.0, yxy[0]) / kCandela;
    return chromatic(luminance, yxy[1], yxy[2]);
  }

 private:
  static Rgb chromatic(double y, double cx, double cy) {
    const double x = cx / cy * y, z = (1 - cx - cy) / cy * y;
    const auto positive = [](double v) { return static_cast<float>(std::max(0.0, v)); };
    return {positive(3.240479 * x - 1.537150 * y - 0.498535 * z),
            positive(-0.969256 * x + 1.875991 * y + 0.041556 * z),
            positive(0.055648 * x - 0.204043 * y + 1.057311 * z)};
  }

  double sun_theta_;
  Perez perez_[3];
  double zenith_[3];
};

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

// Appendix A.1, without water and other gases, which absorb beyond 690 nm.
Rgb sun_radiance(double theta, double turbidity) {
  if (theta >= kPiD / 2) return {};
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
// are.
void add_sun(const SunSky& p, Image& image) {
  const int w = image.width(), h = image.height();
  const double sun_theta = std::acos(std::clamp(static_cast<double>(p.to_sun.y), -1.0, 1.0));
  const double radius = std::min(kSunRadius * p.sun_radius_scale, kPiD / 4);
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
  const Rgb radiance =
      sun_radiance(sun_theta, p.turbidity) * static_cast<float>(p.sun_scale * exact / sum);
  for (const auto& [index, share] : covered) {
    const int x = static_cast<int>(index % static_cast<size_t>(w));
    const int y = static_cast<int>(index / static_cast<size_t>(w));
    image.set_rgb(x, y, image.rgb(x, y) + radiance * static_cast<float>(share));
  }
}

}  // namespace

Image draw_sun_sky(const SunSky& p, int width, int height) {
  const double sun_theta = std::acos(std::clamp(static_cast<double>(p.to_sun.y), -1.0, 1.0));
  // The model has no night: the sun is at the horizon at least.
  const Sky sky(p.turbidity, std::min(sun_theta, kPiD / 2 - 0.01));
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
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
