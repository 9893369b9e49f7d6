// A clear sky and its sun as an environment picture: Preetham, Shirley and Smits, "A Practical
// Analytic Model for Daylight" (1999); the sun's place after Blanco-Muriel et al., "Computing the
// Solar Vector" (2001). Radiances are W / (m^2 sr nm), as Mitsuba has them. Pure functions.
#pragma once

#include "core/image/image.h"

namespace qray {

struct SunSky {
  Vec3 to_sun{0, 1, 0};  // unit; +y is up
  double turbidity = 3;  // 1.7 (very clear) .. 10 (hazy)
  double sky_scale = 1, sun_scale = 1;
  double sun_radius_scale = 1;
};

struct SunTime {
  int year = 2010, month = 7, day = 10;
  double hour = 15;                                 // of the zone's clock
  double timezone = 9;                              // hours ahead of Greenwich
  double latitude = 35.6894, longitude = 139.6917;  // degrees, north and east
};

// Latitude-longitude, its top row +y and its centre -z. Below the horizon the sky fades out.
Image draw_sun_sky(const SunSky& parameters, int width, int height);
// Unit: east is +x, south +z.
Vec3 sun_direction(const SunTime& time);

}  // namespace qray
