#include "core/import/spectrum.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

// The 2-degree colour matching functions of CIE 1931 and the illuminant D65, both as published at
// 5 nm from 360 to 830 nm (CIE 15).
struct CieRow {
  double x, y, z, d65;
};
constexpr int kFirstNm = 360, kStepNm = 5;
// clang-format off
constexpr CieRow kCie[] = {
    {0.0001299, 3.917e-06, 0.0006061, 46.6383}, {0.0002321, 6.965e-06, 0.001086, 49.3637},
    {0.0004149, 1.239e-05, 0.001946, 52.0891}, {0.0007416, 2.202e-05, 0.003486, 51.0323},
    {0.001368, 3.9e-05, 0.006450001, 49.9755}, {0.002236, 6.4e-05, 0.01054999, 52.3118},
    {0.004243, 0.00012, 0.02005001, 54.6482}, {0.00765, 0.000217, 0.03621, 68.7015},
    {0.01431, 0.000396, 0.06785001, 82.7549}, {0.02319, 0.00064, 0.1102, 87.1204},
    {0.04351, 0.00121, 0.2074, 91.486}, {0.07763, 0.00218, 0.3713, 92.4589},
    {0.13438, 0.004, 0.6456, 93.4318}, {0.21477, 0.0073, 1.03905, 90.057},
    {0.2839, 0.0116, 1.3856, 86.6823}, {0.3285, 0.01684, 1.62296, 95.7736},
    {0.34828, 0.023, 1.74706, 104.865}, {0.34806, 0.0298, 1.7826, 110.936},
    {0.3362, 0.038, 1.77211, 117.008}, {0.3187, 0.048, 1.7441, 117.41},
    {0.2908, 0.06, 1.6692, 117.812}, {0.2511, 0.0739, 1.5281, 116.336},
    {0.19536, 0.09098, 1.28764, 114.861}, {0.1421, 0.1126, 1.0419, 115.392},
    {0.09564, 0.13902, 0.8129501, 115.923}, {0.05795001, 0.1693, 0.6162, 112.367},
    {0.03201, 0.20802, 0.46518, 108.811}, {0.0147, 0.2586, 0.3533, 109.082},
    {0.0049, 0.323, 0.272, 109.354}, {0.0024, 0.4073, 0.2123, 108.578},
    {0.0093, 0.503, 0.1582, 107.802}, {0.0291, 0.6082, 0.1117, 106.296},
    {0.06327, 0.71, 0.07824999, 104.79}, {0.1096, 0.7932, 0.05725001, 106.239},
    {0.1655, 0.862, 0.04216, 107.689}, {0.2257499, 0.9148501, 0.02984, 106.047},
    {0.2904, 0.954, 0.0203, 104.405}, {0.3597, 0.9803, 0.0134, 104.225},
    {0.4334499, 0.9949501, 0.008749999, 104.046}, {0.5120501, 1.0, 0.005749999, 102.023},
    {0.5945, 0.995, 0.0039, 100.0}, {0.6784, 0.9786, 0.002749999, 98.1671},
    {0.7621, 0.952, 0.0021, 96.3342}, {0.8425, 0.9154, 0.0018, 96.0611},
    {0.9163, 0.87, 0.001650001, 95.788}, {0.9786, 0.8163, 0.0014, 92.2368},
    {1.0263, 0.757, 0.0011, 88.6856}, {1.0567, 0.6949, 0.001, 89.3459},
    {1.0622, 0.631, 0.0008, 90.0062}, {1.0456, 0.5668, 0.0006, 89.8026},
    {1.0026, 0.503, 0.00034, 89.5991}, {0.9384, 0.4412, 0.00024, 88.6489},
    {0.8544499, 0.381, 0.00019, 87.6987}, {0.7514, 0.321, 0.0001, 85.4936},
    {0.6424, 0.265, 4.999999e-05, 83.2886}, {0.5419, 0.217, 3e-05, 83.4939},
    {0.4479, 0.175, 2e-05, 83.6992}, {0.3608, 0.1382, 1e-05, 81.863}, {0.2835, 0.107, 0.0, 80.0268},
    {0.2187, 0.0816, 0.0, 80.1207}, {0.1649, 0.061, 0.0, 80.2146}, {0.1212, 0.04458, 0.0, 81.2462},
    {0.0874, 0.032, 0.0, 82.2778}, {0.0636, 0.0232, 0.0, 80.281}, {0.04677, 0.017, 0.0, 78.2842},
    {0.0329, 0.01192, 0.0, 74.0027}, {0.0227, 0.00821, 0.0, 69.7213},
    {0.01584, 0.005723, 0.0, 70.6652}, {0.01135916, 0.004102, 0.0, 71.6091},
    {0.008110916, 0.002929, 0.0, 72.979}, {0.005790346, 0.002091, 0.0, 74.349},
    {0.004109457, 0.001484, 0.0, 67.9765}, {0.002899327, 0.001047, 0.0, 61.604},
    {0.00204919, 0.00074, 0.0, 65.7448}, {0.001439971, 0.00052, 0.0, 69.8856},
    {0.0009999493, 0.0003611, 0.0, 72.4863}, {0.0006900786, 0.0002492, 0.0, 75.087},
    {0.0004760213, 0.0001719, 0.0, 69.3398}, {0.0003323011, 0.00012, 0.0, 63.5927},
    {0.0002348261, 8.48e-05, 0.0, 55.0054}, {0.0001661505, 6e-05, 0.0, 46.4182},
    {0.000117413, 4.24e-05, 0.0, 56.6118}, {8.307527e-05, 3e-05, 0.0, 66.8054},
    {5.870652e-05, 2.12e-05, 0.0, 65.0941}, {4.150994e-05, 1.499e-05, 0.0, 63.3828},
    {2.935326e-05, 1.06e-05, 0.0, 63.8434}, {2.067383e-05, 7.4657e-06, 0.0, 64.304},
    {1.455977e-05, 5.2578e-06, 0.0, 61.8779}, {1.025398e-05, 3.7029e-06, 0.0, 59.4519},
    {7.221456e-06, 2.6078e-06, 0.0, 55.7054}, {5.085868e-06, 1.8366e-06, 0.0, 51.959},
    {3.581652e-06, 1.2934e-06, 0.0, 54.6998}, {2.522525e-06, 9.1093e-07, 0.0, 57.4406},
    {1.776509e-06, 6.4153e-07, 0.0, 58.8765}, {1.251141e-06, 4.5181e-07, 0.0, 60.3125},
};
// clang-format on
constexpr int kRows = sizeof(kCie) / sizeof(kCie[0]);

CieRow cie_at(double nm) {
  const double at = (nm - kFirstNm) / kStepNm;
  const int i = std::clamp(static_cast<int>(at), 0, kRows - 2);
  const double t = at - i;
  const CieRow &a = kCie[i], &b = kCie[i + 1];
  return {std::lerp(a.x, b.x, t), std::lerp(a.y, b.y, t), std::lerp(a.z, b.z, t),
          std::lerp(a.d65, b.d65, t)};
}

// Planck's law, W / (m^2 sr nm).
double planck(double nm, double kelvin) {
  constexpr double kPlanck = 6.62607015e-34, kLight = 299792458.0, kBoltzmann = 1.380649e-23;
  const double m = nm * 1e-9;
  const double radiance = 2 * kPlanck * kLight * kLight / std::pow(m, 5) /
                          std::expm1(kPlanck * kLight / (kBoltzmann * kelvin * m));
  return radiance * 1e-9;
}

// `value` of nm against the three functions; 1 everywhere has the luminance 1.
template <class Function>
Rgb integrate(SpectrumWeight weight, const Function& value) {
  constexpr double kFineNm = 0.5;
  constexpr int kSamples = static_cast<int>((kRows - 1) * kStepNm / kFineNm);
  double x = 0, y = 0, z = 0, white = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double nm = kFirstNm + (i + 0.5) * kFineNm;
    const CieRow cie = cie_at(nm);
    const double light = weight == SpectrumWeight::kD65 ? cie.d65 : 1;
    const double v = value(nm) * light;
    white += cie.y * light;
    x += v * cie.x;
    y += v * cie.y;
    z += v * cie.z;
  }
  // To linear Rec.709 (ITU-R BT.709). A colour that it cannot show loses its negative part.
  const double rgb[] = {3.240479 * x - 1.537150 * y - 0.498535 * z,
                        -0.969256 * x + 1.875991 * y + 0.041556 * z,
                        0.055648 * x - 0.204043 * y + 1.057311 * z};
  Rgb out;
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(std::max(0.0, rgb[i] / white));
  return out;
}

}  // namespace

Rgb spectrum_to_rgb(const std::vector<SpectrumPoint>& points, SpectrumWeight weight) {
  return integrate(weight, [&points](double nm) {
    const auto after =
        std::upper_bound(points.begin(), points.end(), nm,
                         [](double value, const SpectrumPoint& p) { return value < p.nm; });
    if (after == points.begin() || after == points.end()) return 0.0;
    const auto before = after - 1;
    return std::lerp(before->value, after->value, (nm - before->nm) / (after->nm - before->nm));
  });
}

Rgb blackbody_to_rgb(double kelvin) {
  return integrate(SpectrumWeight::kEqualEnergy,
                   [kelvin](double nm) { return planck(nm, kelvin); });
}

}  // namespace qray
