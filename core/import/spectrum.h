// Spectra as linear Rec.709, by the CIE 1931 2-degree observer. Pure functions.
#pragma once

#include <vector>

#include "core/math/vec.h"

namespace qray {

struct SpectrumPoint {
  double nm, value;
};

// What a spectrum is seen under: Mitsuba 0.x integrates all under equal energy, so that a white of
// constant 1 is (1.20, 0.95, 0.91); later ones integrate reflectances under D65.
enum class SpectrumWeight { kEqualEnergy, kD65 };

// pre: wavelengths rise. Linear between points, 0 outside of them; a spectrum of constant 1 has the
// luminance 1.
Rgb spectrum_to_rgb(const std::vector<SpectrumPoint>& points, SpectrumWeight weight);
// W / (m^2 sr), as a spectrum_to_rgb of radiances a nanometre. pre: kelvin > 0.
Rgb blackbody_to_rgb(double kelvin);

}  // namespace qray
