// The figures of two published models of daylight: Hosek and Wilkie, "An Analytic Model for Full
// Spectral Sky-Dome Radiance" (2012), in its version for red, green and blue, and their "Adding a
// Solar Radiance Function to the Hosek Skylight Model" (2013).
#pragma once

namespace qray {

// Turbidity 1..10; ground of albedo 0, 1; control points over the sun's height; colour channel.
extern const double kSkyShape[10][2][6][3][9];
extern const double kSkyRadiance[10][2][6][3];
// The mean over the sun's disk, W / (m^2 sr nm). Turbidity 1..10; the sun at 2 to 88 degrees above
// the horizon in equal steps; colour channel.
extern const double kSunRadiance[10][30][3];

}  // namespace qray
