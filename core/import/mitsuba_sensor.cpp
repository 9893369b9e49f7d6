#include "core/import/mitsuba_sensor.h"

#include <cmath>

#include "core/scene/value_ranges.h"

namespace qray {
namespace {

constexpr double kFilmDiagonalMm = 43.266615305567875;  // of 36 x 24 mm
constexpr int kDeepest = 128;                           // as validate() allows

int read_size(const MitsubaNode& film, std::string_view name, int fallback, int most) {
  const std::optional<double> size = find_number(film, name);
  if (!size) return fallback;
  if (!(*size >= 1 && *size <= most && *size == std::floor(*size)))
    find_parameter(film, name)->fail("expected a whole number of 1.." + std::to_string(most));
  return static_cast<int>(*size);
}

// What a film holds, and the window of it that is drawn, from the top left corner; pixels.
struct Film {
  int width = 768, height = 576;
  int left = 0, top = 0, window_width = 768, window_height = 576;
};

Film read_film(const MitsubaNode& node, MitsubaImport& import) {
  Film film;
  const int most = import.limits.max_dimension_px;
  film.width = read_size(node, "width", film.width, most);
  film.height = read_size(node, "height", film.height, most);
  const auto edge = [&node](const char* name, int size) {
    const double at = find_number(node, name).value_or(0);
    if (!(at >= 0 && at < size && at == std::floor(at)))
      find_parameter(node, name)
          ->fail("expected a whole number from 0, below " + std::to_string(size));
    return static_cast<int>(at);
  };
  film.left = edge("crop_offset_x", film.width);
  film.top = edge("crop_offset_y", film.height);
  film.window_width = read_size(node, "crop_width", film.width - film.left, film.width - film.left);
  film.window_height =
      read_size(node, "crop_height", film.height - film.top, film.height - film.top);
  return film;
}

// "44mm" or "44".
double read_focal_length(const MitsubaNode& node) {
  std::string text = node.need("value");
  if (text.ends_with("mm")) text.resize(text.size() - 2);
  const double mm = parse_number(node, text);
  if (!(mm > 0)) node.fail("expected a focal length over 0");
  return mm;
}

// Half of what the picture's height spans, at distance 1.
double half_height(const MitsubaNode& sensor, double aspect) {
  const MitsubaNode* fov = find_parameter(sensor, "fov");
  const MitsubaNode* focal = find_parameter(sensor, "focal_length");
  if (!fov) {
    const double mm = focal ? read_focal_length(*focal) : 50;
    return kFilmDiagonalMm / 2 / mm / std::hypot(aspect, 1.0);
  }
  const double degrees = parse_number(*fov, fov->need("value"));
  if (!(degrees > 0 && degrees < 180)) fov->fail("expected an angle over 0 and under 180");
  const double half = std::tan(degrees * std::numbers::pi / 360);
  const std::string* axis = find_text(sensor, "fov_axis");
  const std::string name = axis ? *axis : "x";
  if (name == "y") return half;
  if (name == "x") return half / aspect;
  if (name == "smaller") return aspect > 1 ? half : half / aspect;
  if (name == "larger") return aspect > 1 ? half / aspect : half;
  if (name == "diagonal") return half / std::hypot(aspect, 1.0);
  find_parameter(sensor, "fov_axis")->fail("expected x, y, diagonal, smaller or larger");
}

// The picture's width is 2 in the sensor's space.
float orthographic_height(const MitsubaNode& sensor, const Transform& to_world, double aspect,
                          MitsubaImport& import) {
  const float across = length(to_world.column(0)), upward = length(to_world.column(1));
  if (std::abs(across - upward) > 1e-3f * upward)
    import.warn(sensor, "the picture is as wide as its height asks for: the map stretches it");
  const double height = 2 * static_cast<double>(upward) / aspect;
  if (!(height > 0 && height <= static_cast<double>(kMaxCoordinate)))
    sensor.fail("expected a map that gives the picture a height over 0, at most 1e6 m");
  return static_cast<float>(height);
}

// Of the window's middle, in its own sizes.
Vec2 shift_of(const MitsubaNode& sensor, const Film& film) {
  const auto shift = [](double offset, int edge, int part, int whole) {
    return static_cast<float>((edge + 0.5 * part - (0.5 - offset) * whole) / part);
  };
  return {shift(find_number(sensor, "principal_point_offset_x").value_or(0), film.left,
                film.window_width, film.width),
          -shift(find_number(sensor, "principal_point_offset_y").value_or(0), film.top,
                 film.window_height, film.height)};
}

// Mitsuba's camera looks along its +z and has its +x at the picture's left, which is right-handed.
// A map that mirrors, mirrors the picture.
void place(Camera& camera, const Transform& to_world) {
  camera.position = to_world.column(3);
  // As far as its distance from the origin, so that its rounding turns the view by nothing.
  camera.target =
      camera.position + normalize(to_world.column(2)) * std::max(1.0f, length(camera.position));
  camera.up = normalize(to_world.column(1));
  camera.mirrored = to_world.determinant() < 0;
}

std::optional<double> max_depth(const MitsubaNode& integrator, const MitsubaDocument& document,
                                int level) {
  if (const MitsubaNode* depth = find_parameter(integrator, "max_depth")) {
    const std::string& value = depth->need("value");
    // Parameters of integrators that are not known here may be anything.
    if (value.find('$') == std::string::npos) return parse_number(*depth, value);
  }
  if (integrator.type == "direct") return 2;
  for (const MitsubaNode& child : integrator.children) {
    const MitsubaNode& inner = document.resolve(child);
    if (inner.tag != "integrator" || level > 8) continue;
    if (const std::optional<double> depth = max_depth(inner, document, level + 1)) return depth;
  }
  return {};
}

}  // namespace

void read_sensor(const MitsubaNode& sensor, MitsubaImport& import) {
  Scene& scene = import.out.scene;
  Film film;
  const MitsubaNode* window = nullptr;
  for (const MitsubaNode& child : sensor.children) {
    const MitsubaNode& node = import.document.resolve(child);
    if (node.tag != "film") continue;
    film = read_film(node, import);
    window = &node;
  }
  scene.width = film.window_width;
  scene.height = film.window_height;
  const bool lens = sensor.type == "thinlens" || sensor.type == "telecentric";
  Camera& camera = scene.camera;
  if (sensor.type == "orthographic" || sensor.type == "telecentric")
    camera.projection = Projection::kOrthographic;
  else if (sensor.type == "spherical")
    camera.projection = Projection::kEquirectangular;
  else if (!lens && sensor.type != "perspective")
    import.warn(sensor, "sensors of type \"" + sensor.type + "\" are drawn as perspective");
  const Transform to_world = find_transform(sensor, "to_world").value_or(Transform{});
  place(camera, to_world);
  const double aspect = static_cast<double>(film.width) / film.height;
  const double part = static_cast<double>(scene.height) / film.height;
  if (camera.projection == Projection::kOrthographic) {
    camera.height =
        orthographic_height(sensor, to_world, aspect, import) * static_cast<float>(part);
  } else if (camera.projection == Projection::kPerspective) {
    camera.vertical_fov_deg =
        static_cast<float>(std::atan(half_height(sensor, aspect) * part) * 360 / std::numbers::pi);
  }
  if (camera.projection != Projection::kEquirectangular)
    camera.shift = shift_of(sensor, film);
  else if (scene.width != film.width || scene.height != film.height)
    window->fail("expected no window of a picture of all directions", ErrorCode::kUnsupported);
  if (const std::optional<double> near = find_number(sensor, "near_clip")) {
    if (!(*near >= 0)) find_parameter(sensor, "near_clip")->fail("expected a distance from 0");
    camera.near_clip = static_cast<float>(*near);
  }
  if (!lens) return;
  const double radius = find_number(sensor, "aperture_radius").value_or(0);
  if (!(radius >= 0)) find_parameter(sensor, "aperture_radius")->fail("expected a radius from 0");
  camera.aperture_radius = static_cast<float>(radius);
  if (const std::optional<double> focus = find_number(sensor, "focus_distance"))
    camera.focus_distance = static_cast<float>(*focus);
}

// Mitsuba counts a path's edges, we its surfaces: the light's is the last of both.
void read_integrator(const MitsubaNode& integrator, MitsubaImport& import) {
  const std::optional<double> depth = max_depth(integrator, import.document, 0);
  if (const MitsubaNode* hide = find_parameter(integrator, "hide_emitters");
      hide && find_flag(integrator, "hide_emitters").value_or(false))
    import.warn(*hide, "lights are drawn where they are seen");
  import.out.scene.max_depth =
      depth && *depth >= 1 && *depth <= kDeepest ? static_cast<int>(*depth) : kDeepest;
}

}  // namespace qray
