// A clear sky and its sun as an environment picture. The sky is Hosek and Wilkie's (2012), the sun
// theirs (2013) or that of Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight"
// (1999); the sun's place after Blanco-Muriel et al., "Computing the Solar Vector" (2001).
// Radiances are W / (m^2 sr nm), as Mitsuba has them. Pure functions.
#pragma once

#include "core/image/image.h"

namespace qray {

constexpr double kSunDegrees = 0.5358;  // of the sun's disk, as seen

enum class SunModel { kHosekWilkie, kPreetham };

struct SunSky {
  Vec3 to_sun{0, 1, 0};  // unit; +y is up
  double turbidity = 3;  // 1 (very clear) .. 10 (hazy)
  Rgb albedo{0.3f};      // of the ground
  SunModel sun_model = SunModel::kHosekWilkie;
  double sky_scale = 1, sun_scale = 1;
  double sun_radius_scale = 1;
  bool extend = false;  // the sky fades out below the horizon rather than ending at it
};

struct SunTime {
  int year = 2010, month = 7, day = 10;
  double hour = 15;                                 // of the zone's clock
  double timezone = 9;                              // hours ahead of Greenwich
  double latitude = 35.6894, longitude = 139.6917;  // degrees, north and east
};

// Latitude-longitude, its top row +y and its centre -z. pre: an even height. Black where the sun is
// below the horizon: the models have no night.
Image draw_sun_sky(const SunSky& parameters, int width, int height);
// Unit: east is +x, south +z.
Vec3 sun_direction(const SunTime& time);

}  // namespace qray
