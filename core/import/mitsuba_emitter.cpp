#include "core/import/mitsuba_emitter.h"

#include <cmath>

#include "core/image/image_io.h"
#include "core/image/tonemap.h"
#include "core/import/mitsuba_color.h"

namespace qray {
namespace {

Vec3 column(const Transform& t, size_t c) {
  return {static_cast<float>(t.rows[0][c]), static_cast<float>(t.rows[1][c]),
          static_cast<float>(t.rows[2][c])};
}

Rgb read_light(const MitsubaNode& emitter, std::string_view name, MitsubaImport& import) {
  return find_color(emitter, name, Rgb{1.0f}, ColorUse::kEmission, import);
}

void add_point(const MitsubaNode& emitter, MitsubaImport& import) {
  PunctualLight light;
  light.intensity = read_light(emitter, "intensity", import);
  if (const std::optional<Transform> t = find_transform(emitter, "to_world"))
    light.position = column(*t, 3);
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
  light.position = column(t, 3);
  light.direction = normalize(column(t, 2));
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
  const Vec3 direction = find_point(emitter, "direction").value_or(column(t, 2));
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
  const Vec3 x = normalize(column(*t, 0)), y = normalize(column(*t, 1)),
             z = normalize(column(*t, 2));
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

}  // namespace

void read_emitter(const MitsubaNode& emitter, MitsubaImport& import) {
  if (emitter.type == "point") return add_point(emitter, import);
  if (emitter.type == "spot") return add_spot(emitter, import);
  if (emitter.type == "directional") return add_directional(emitter, import);
  if (emitter.type == "envmap") return add_environment_map(emitter, import);
  if (emitter.type == "constant") {
    if (claim_sky(emitter, import))
      import.out.scene.environment.radiance = read_light(emitter, "radiance", import);
    return;
  }
  import.warn(emitter, "emitters of type \"" + emitter.type + "\" are left out");
}

}  // namespace qray
