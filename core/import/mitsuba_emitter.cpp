#include "core/import/mitsuba_emitter.h"

#include <cmath>

#include "core/image/image_io.h"
#include "core/image/tonemap.h"
#include "core/import/mitsuba_color.h"
#include "core/import/sun_sky.h"

namespace qray {
namespace {

Rgb read_light(const MitsubaNode& emitter, std::string_view name, MitsubaImport& import) {
  return find_color(emitter, name, Rgb{1.0f}, ColorUse::kEmission, import);
}

void add_point(const MitsubaNode& emitter, MitsubaImport& import) {
  PunctualLight light;
  light.intensity = read_light(emitter, "intensity", import);
  if (const std::optional<Transform> t = find_transform(emitter, "to_world"))
    light.position = t->column(3);
  if (const std::optional<Vec3> position = find_point(emitter, "position"))
    light.position = *position;
  import.out.scene.lights.push_back(light);
}

void add_spot(const MitsubaNode& emitter, MitsubaImport& import) {
  PunctualLight light;
  light.kind = LightKind::kSpot;
  light.falloff = SpotFalloff::kLinearAngle;
  light.intensity = read_light(emitter, "intensity", import);
  const Transform t = find_transform(emitter, "to_world").value_or(Transform{});
  light.position = t.column(3);
  light.direction = normalize(t.column(2));
  const double outer = find_number(emitter, "cutoff_angle").value_or(20);
  const double inner = find_number(emitter, "beam_width").value_or(outer * 0.75);
  if (!(outer > 0 && outer <= 180 && inner >= 0 && inner <= outer))
    emitter.fail("expected angles of 0 <= beamWidth <= cutoffAngle <= 180");
  light.outer_rad = static_cast<float>(outer * std::numbers::pi / 180);
  // A sharp edge is a very steep one.
  light.inner_rad =
      std::min(static_cast<float>(inner * std::numbers::pi / 180), light.outer_rad * 0.9999f);
  if (const MitsubaNode* texture = find_parameter(emitter, "texture"))
    import.warn(*texture, "what the spot projects is left out");
  import.out.scene.lights.push_back(light);
}

void add_directional(const MitsubaNode& emitter, MitsubaImport& import) {
  PunctualLight light;
  light.kind = LightKind::kDirectional;
  light.intensity = read_light(emitter, "irradiance", import);
  const Transform t = find_transform(emitter, "to_world").value_or(Transform{});
  const Vec3 direction = find_point(emitter, "direction").value_or(t.column(2));
  if (!(length(direction) > 0)) emitter.fail("expected a direction with a length");
  light.direction = normalize(direction);
  import.out.scene.lights.push_back(light);
}

bool claim_sky(const MitsubaNode& emitter, MitsubaImport& import) {
  if (!import.out.scene.environment.present()) return true;
  import.warn(emitter, "only the first sky is drawn");
  return false;
}

// Our picture's middle is -z, Mitsuba's +z; to the right of it lies -x there.
Mat3 sky_to_world(const MitsubaNode& emitter, MitsubaImport& import) {
  const std::optional<Transform> t = find_transform(emitter, "to_world");
  if (!t) return Mat3::rotation_y(180);
  const Vec3 x = normalize(t->column(0)), y = normalize(t->column(1)), z = normalize(t->column(2));
  if (std::abs(dot(x, y)) + std::abs(dot(y, z)) + std::abs(dot(z, x)) > 1e-3f)
    import.warn(emitter, "only what of the map is a rotation is drawn");
  return {{Vec3{-x.x, y.x, -z.x}, Vec3{-x.y, y.y, -z.y}, Vec3{-x.z, y.z, -z.z}}};
}

bool stores_linear_light(const std::filesystem::path& path) {
  const std::string extension = path.extension();
  return extension != ".png" && extension != ".jpg" && extension != ".jpeg" &&
         extension != ".JPG" && extension != ".PNG";
}

void add_environment_map(const MitsubaNode& emitter, MitsubaImport& import) {
  if (!claim_sky(emitter, import)) return;
  const MitsubaNode* file = find_parameter(emitter, "filename");
  if (!file) emitter.fail("expected a \"filename\" of the picture");
  Environment& environment = import.out.scene.environment;
  environment.image_path = import.document.find_file(*file, file->need("value"));
  const Result<Image> read =
      read_image(environment.image_path, static_cast<uint64_t>(import.limits.max_pixels));
  if (!read.ok()) file->fail(read.error().message, read.error().code);
  const Image& stored = read.value();
  const bool linear = stores_linear_light(environment.image_path);
  environment.image = Image(stored.width(), stored.height(), 3);
  for (int y = 0; y < stored.height(); ++y) {
    for (int x = 0; x < stored.width(); ++x) {
      const Rgb value = stored.rgb(x, y);
      environment.image.set_rgb(x, y, linear ? value : srgb_to_linear(value));
    }
  }
  const double scale = find_number(emitter, "scale").value_or(1);
  if (!(scale >= 0)) find_parameter(emitter, "scale")->fail("expected a scale from 0");
  environment.radiance = Rgb{static_cast<float>(scale)};
  environment.to_world = sky_to_world(emitter, import);
}

SunTime read_time(const MitsubaNode& emitter) {
  const auto number = [&](const char* name, double fallback, double lo, double hi) {
    const double v = find_number(emitter, name).value_or(fallback);
    if (!(v >= lo && v <= hi)) {
      find_parameter(emitter, name)
          ->fail("expected " + std::to_string(static_cast<int>(lo)) + ".." +
                 std::to_string(static_cast<int>(hi)));
    }
    return v;
  };
  SunTime t;
  t.year = static_cast<int>(number("year", t.year, 1900, 2100));
  t.month = static_cast<int>(number("month", t.month, 1, 12));
  t.day = static_cast<int>(number("day", t.day, 1, 31));
  t.hour = number("hour", t.hour, 0, 24) + number("minute", 0, 0, 60) / 60 +
           number("second", 0, 0, 60) / 3600;
  t.timezone = number("timezone", t.timezone, -12, 14);
  t.latitude = number("latitude", t.latitude, -90, 90);
  t.longitude = number("longitude", t.longitude, -180, 180);
  return t;
}

// Up is the emitter's +y, in Mitsuba 3 its +z.
Mat3 sun_sky_to_world(const MitsubaNode& emitter, bool z_up) {
  const Transform t = find_transform(emitter, "to_world").value_or(Transform{});
  const Vec3 x = normalize(t.column(0));
  const Vec3 y = normalize(t.column(z_up ? 2 : 1));
  const Vec3 z = normalize(t.column(z_up ? 1 : 2)) * (z_up ? -1.0f : 1.0f);
  return {{Vec3{x.x, y.x, z.x}, Vec3{x.y, y.y, z.y}, Vec3{x.z, y.z, z.z}}};
}

void add_sun_sky(const MitsubaNode& emitter, MitsubaImport& import) {
  if (!claim_sky(emitter, import)) return;
  constexpr int kWidth = 1024;  // a third of a degree
  import.expect_only(emitter,
                     {"turbidity", "albedo",           "year",         "month",    "day",
                      "hour",      "minute",           "second",       "timezone", "latitude",
                      "longitude", "sun_direction",    "resolution",   "scale",    "sky_scale",
                      "sun_scale", "sun_radius_scale", "sun_aperture", "extend",   "to_world"});
  const bool mitsuba3 = import.document.version >= 3;
  const auto scale = [&](const char* name, double fallback) {
    const double v = find_number(emitter, name).value_or(fallback);
    if (!(v >= 0)) find_parameter(emitter, name)->fail("expected a number from 0");
    return v;
  };
  SunSky p;
  p.turbidity = find_number(emitter, "turbidity").value_or(3);
  if (!(p.turbidity >= 1 && p.turbidity <= 10))
    find_parameter(emitter, "turbidity")->fail("expected 1..10");
  p.albedo =
      find_color(emitter, "albedo", Rgb{mitsuba3 ? 0.3f : 0.2f}, ColorUse::kReflectance, import);
  if (!(max_component(p.albedo) <= 1)) find_parameter(emitter, "albedo")->fail("expected 0..1");
  p.sun_model = mitsuba3 ? SunModel::kHosekWilkie : SunModel::kPreetham;
  const double both = scale("scale", 1);
  p.sky_scale = emitter.type == "sun" ? 0 : scale("sky_scale", both);
  p.sun_scale = emitter.type == "sky" ? 0 : scale("sun_scale", both);
  p.sun_radius_scale = scale("sun_radius_scale", scale("sun_aperture", kSunDegrees) / kSunDegrees);
  p.extend = find_flag(emitter, "extend").value_or(false);
  Environment& environment = import.out.scene.environment;
  environment.to_world = sun_sky_to_world(emitter, mitsuba3);
  if (const std::optional<Vec3> to_sun = find_point(emitter, "sun_direction")) {
    if (!(length(*to_sun) > 0)) emitter.fail("expected a sunDirection with a length");
    p.to_sun = environment.to_world.transposed() * normalize(*to_sun);
  } else {
    p.to_sun = sun_direction(read_time(emitter));
  }
  if (!(p.to_sun.y > 0))
    import.warn(emitter, "the sun is below the horizon: neither it nor the sky shines");
  environment.radiance = Rgb{1.0f};
  environment.image = draw_sun_sky(p, kWidth, kWidth / 2);
}

}  // namespace

void read_emitter(const MitsubaNode& emitter, MitsubaImport& import) {
  if (emitter.type == "point") return add_point(emitter, import);
  if (emitter.type == "spot") return add_spot(emitter, import);
  if (emitter.type == "directional") return add_directional(emitter, import);
  if (emitter.type == "envmap") return add_environment_map(emitter, import);
  if (emitter.type == "sunsky" || emitter.type == "sky" || emitter.type == "sun")
    return add_sun_sky(emitter, import);
  if (emitter.type == "constant") {
    if (claim_sky(emitter, import))
      import.out.scene.environment.radiance = read_light(emitter, "radiance", import);
    return;
  }
  import.warn(emitter, "emitters of type \"" + emitter.type + "\" are left out");
}

}  // namespace qray
