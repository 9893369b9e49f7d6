#include "core/scene/validate.h"

#include <cstdio>

#include "core/scene/value_ranges.h"

namespace qray {
namespace {

constexpr int kMaxDepth = 128;

std::string show(float v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", static_cast<double>(v));
  return text;
}
std::string show(Rgb v) { return "[" + show(v.r) + ", " + show(v.g) + ", " + show(v.b) + "]"; }
std::string show(Vec3 v) { return show(Rgb{v.x, v.y, v.z}); }

Error wrong(std::string place, const std::string& expected, const std::string& got,
            ErrorCode code = ErrorCode::kInvalid) {
  return {code, "expected " + expected + ", got " + got, std::move(place)};
}

bool in_range(float v, float lo, float hi) { return v >= lo && v <= hi; }  // false for NaN
bool in_range(Rgb v, float lo, float hi) {
  return in_range(v.r, lo, hi) && in_range(v.g, lo, hi) && in_range(v.b, lo, hi);
}
bool in_range(Vec3 v, float lo, float hi) { return in_range(Rgb{v.x, v.y, v.z}, lo, hi); }
bool is_coordinate(Vec3 v) { return in_range(v, -kMaxCoordinate, kMaxCoordinate); }

template <class T>
Status check_range(const std::string& place, T v, float lo, float hi) {
  if (in_range(v, lo, hi)) return {};
  char range[64];
  std::snprintf(range, sizeof range, "%g..%g", static_cast<double>(lo), static_cast<double>(hi));
  return wrong(place, range, show(v));
}

Status check_texture(const std::string& place, TextureId id, size_t count) {
  if (!id.valid() || id.value < count) return {};
  return wrong(place, "a texture below " + std::to_string(count), std::to_string(id.value));
}

Status check_param(const std::string& place, const ColorParam& param, float hi, size_t textures) {
  const Status status = check_range(place, param.value, 0, hi);
  return status.ok() ? check_texture(place, param.texture, textures) : status;
}
Status check_param(const std::string& place, const FloatParam& param, size_t textures, float lo = 0,
                   float hi = 1) {
  if (param.channel < 0 || param.channel > kLuminance)
    return wrong(place, "a channel of 0..4", std::to_string(param.channel));
  const Status status = check_range(place, param.value, lo, hi);
  return status.ok() ? check_texture(place, param.texture, textures) : status;
}

// A blend's parts come before it, so that no blend is part of itself.
Status check_blend(const Material& m, const std::string& at, size_t index) {
  if (m.kind != MaterialKind::kBlend) return {};
  const struct {
    const char* name;
    MaterialId id;
  } parts[] = {{"/first", m.first}, {"/second", m.second}};
  for (const auto& part : parts) {
    if (part.id.value < index) continue;
    return wrong(at + part.name, "a material before this one",
                 part.id.valid() ? std::to_string(part.id.value) : "none");
  }
  return {};
}

Status check_material(const Material& m, size_t index, size_t textures) {
  const std::string at = "/materials/" + std::to_string(index);
  const float specular = m.kind == MaterialKind::kPrincipled ? kMaxSpecular : 1;
  for (const Status& status :
       {check_param(at + "/reflectance", m.reflectance, 1, textures),
        check_param(at + "/roughness", m.roughness, textures),
        check_param(at + "/anisotropy", m.anisotropy, textures),
        check_range(at + "/anisotropy_rad", m.anisotropy_rad, -kMaxTurn, kMaxTurn),
        check_range(at + "/eta", m.eta, 0, kMaxIndex),
        check_range(at + "/k", m.k, 0, kMaxIndex),
        check_range(at + "/ior", m.ior, 1, 4),
        check_param(at + "/specular", m.specular, specular, textures),
        check_param(at + "/transmittance", m.transmittance, 1, textures),
        check_range(at + "/absorption", m.absorption, 0, kMaxAbsorption),
        check_param(at + "/metallic", m.metallic, textures),
        check_param(at + "/transmission", m.transmission, textures),
        check_param(at + "/clearcoat", m.clearcoat, textures),
        check_param(at + "/clearcoat_roughness", m.clearcoat_roughness, textures),
        check_param(at + "/sheen", m.sheen, m.disney ? kMaxSpecular : 1, textures),
        check_param(at + "/sheen_roughness", m.sheen_roughness, textures),
        check_param(at + "/specular_weight", m.specular_weight, textures),
        check_param(at + "/diffuse_transmission", m.diffuse_transmission, textures),
        check_param(at + "/diffuse_transmission_color", m.diffuse_transmission_color, 1, textures),
        check_param(at + "/iridescence", m.iridescence, textures),
        check_range(at + "/film_ior", m.film_ior, 1, 4),
        check_param(at + "/film_nm", m.film_nm, textures, 0, kMaxFilmNm),
        check_range(at + "/film_least_nm", m.film_least_nm, 0, kMaxFilmNm),
        check_texture(at + "/coat_normal_map", m.coat_normal_map, textures),
        check_range(at + "/coat_normal_map/scale", m.coat_normal_scale, -kMaxSlope, kMaxSlope),
        check_blend(m, at, index),
        check_param(at + "/weight", m.blend_weight, textures),
        check_param(at + "/opacity", m.opacity, textures),
        check_range(at + "/alpha_cutoff", m.alpha_cutoff, 0, 1),
        check_texture(at + "/normal_map", m.normal_map, textures),
        check_range(at + "/normal_map/scale", m.normal_scale, -kMaxSlope, kMaxSlope),
        check_param(at + "/bump_map", m.bump_map, textures, -kMaxSlope, kMaxSlope),
        check_param(at + "/emission", m.emission, kMaxRadiance, textures)}) {
    if (!status.ok()) return status;
  }
  return {};
}

// Per-vertex data is there for every vertex or for none.
Status check_count(const std::string& place, size_t count, size_t vertex_count) {
  if (count == 0 || count == vertex_count) return {};
  return wrong(place, std::to_string(vertex_count) + ", one a position", std::to_string(count));
}

Status check_mesh(const Mesh& mesh, const std::string& at, size_t material_count) {
  if (mesh.material.value >= material_count) {
    return wrong(at + "/material", "a material below " + std::to_string(material_count),
                 mesh.material.valid() ? std::to_string(mesh.material.value) : "none");
  }
  if (const auto& sphere = mesh.sphere) {
    if (!is_coordinate(sphere->center))
      return wrong(at + "/sphere/center", "numbers within 1e6 m", show(sphere->center));
    if (!in_range(sphere->radius, 0, kMaxCoordinate))
      return wrong(at + "/sphere/radius", "0..1e6 m", show(sphere->radius));
    if (!mesh.positions.empty() || !mesh.triangles.empty())
      return wrong(at + "/sphere", "no triangles beside it", std::to_string(mesh.triangles.size()));
  }
  const size_t vertex_count = mesh.positions.size();
  for (const Status& status :
       {check_count(at + "/normals", mesh.normals.size(), vertex_count),
        check_count(at + "/uvs", mesh.uvs.size(), vertex_count),
        check_count(at + "/second_uvs", mesh.second_uvs.size(), vertex_count),
        check_count(at + "/colors", mesh.colors.size(), vertex_count)}) {
    if (!status.ok()) return status;
  }
  const auto item = [&at](const char* list, size_t i) {
    return at + "/" + list + "/" + std::to_string(i);
  };
  for (size_t i = 0; i < vertex_count; ++i) {
    if (!is_coordinate(mesh.positions[i]))
      return wrong(item("positions", i), "numbers within 1e6 m", show(mesh.positions[i]));
  }
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    const float n = length(mesh.normals[i]);
    if (!in_range(n, 0.99f, 1.01f))
      return wrong(item("normals", i), "a unit vector", show(mesh.normals[i]));
  }
  for (const auto& [name, uvs] : {std::pair{"uvs", &mesh.uvs}, {"second_uvs", &mesh.second_uvs}}) {
    for (size_t i = 0; i < uvs->size(); ++i) {
      const Vec3 uv{(*uvs)[i].x, (*uvs)[i].y, 0};
      if (!is_coordinate(uv)) return wrong(item(name, i), "numbers within 1e6", show(uv));
    }
  }
  for (size_t i = 0; i < mesh.colors.size(); ++i) {
    if (!in_range(mesh.colors[i], 0, 1))
      return wrong(item("colors", i), "0..1", show(mesh.colors[i]));
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const uint32_t v : mesh.triangles[i]) {
      if (v >= vertex_count) {
        return wrong(item("triangles", i), "indices below " + std::to_string(vertex_count),
                     std::to_string(v));
      }
    }
  }
  return {};
}

Status check_environment(const Environment& environment) {
  const std::string at = "/environment";
  Status status = check_range(at + "/radiance", environment.radiance, 0, kMaxRadiance);
  if (!status.ok()) return status;
  const Mat3& m = environment.to_world;
  for (int i = 0; i < 9; ++i) {
    const size_t row = static_cast<size_t>(i / 3), other = static_cast<size_t>(i % 3);
    if (!(std::abs(dot(m.rows[row], m.rows[other]) - (row == other ? 1.0f : 0.0f)) < 1e-3f))
      return wrong(at + "/to_world", "a rotation",
                   show(m.rows[row]) + " in row " + std::to_string(row));
  }
  const Image& image = environment.image;
  if (image.empty()) return {};
  if (image.channels() != 3)
    return wrong(at + "/image", "3 channels", std::to_string(image.channels()));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (in_range(image.rgb(x, y), 0, kMaxRadiance)) continue;
      return wrong(at + "/image", "values of 0..1e12",
                   show(image.rgb(x, y)) + " at pixel (" + std::to_string(x) + ", " +
                       std::to_string(y) + ")");
    }
  }
  return {};
}

Status check_light(const PunctualLight& light, const std::string& at) {
  const bool directional = light.kind == LightKind::kDirectional;
  const Status status = check_range(at + (directional ? "/irradiance" : "/intensity"),
                                    light.intensity, 0, kMaxRadiance);
  if (!status.ok()) return status;
  if (!directional && !is_coordinate(light.position))
    return wrong(at + "/position", "numbers within 1e6 m", show(light.position));
  if (light.kind == LightKind::kPoint) return {};
  if (!in_range(length(light.direction), 0.999f, 1.001f))
    return wrong(at + "/direction", "a unit vector", show(light.direction));
  if (directional) return {};
  if (!(light.outer_rad > 0 && light.outer_rad <= kPi * 1.0001f))
    return wrong(at + "/outer_deg", "more than 0, at most 180 degrees",
                 show(light.outer_rad) + " radians");
  if (!(light.inner_rad >= 0 && light.inner_rad <= light.outer_rad))
    return wrong(at + "/inner_deg", "0 to the outer angle", show(light.inner_rad) + " radians");
  return {};
}

Status check_instance(const Instance& instance, const std::string& at, const Scene& scene,
                      const std::vector<Bounds3>& boxes) {
  if (instance.mesh.value >= scene.meshes.size()) {
    return wrong(at + "/mesh", "a mesh below " + std::to_string(scene.meshes.size()),
                 instance.mesh.valid() ? std::to_string(instance.mesh.value) : "none");
  }
  if (scene.meshes[instance.mesh.value].sphere)
    return wrong(at + "/mesh", "a mesh of triangles", "an exact sphere");
  if (instance.material.valid() && instance.material.value >= scene.materials.size()) {
    return wrong(at + "/material", "a material below " + std::to_string(scene.materials.size()),
                 std::to_string(instance.material.value));
  }
  const double determinant = instance.to_world.determinant();
  if (!(std::abs(determinant) > 1e-20 && std::isfinite(determinant)))
    return wrong(at + "/transform", "a map that keeps volume", "one that is flat or not finite");
  const Bounds3& box = boxes[instance.mesh.value];
  for (int i = 0; i < 8 && !box.empty(); ++i) {
    const Vec3 corner = instance.to_world.point(
        {i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z});
    if (!is_coordinate(corner))
      return wrong(at + "/transform", "a place within 1e6 m", show(corner));
  }
  return {};
}

Status check_instances(const Scene& scene) {
  if (scene.instances.empty()) return {};
  std::vector<Bounds3> boxes(scene.meshes.size());
  for (size_t m = 0; m < scene.meshes.size(); ++m)
    for (const Vec3 p : scene.meshes[m].positions) boxes[m].add(p);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Status status =
        check_instance(scene.instances[i], "/instances/" + std::to_string(i), scene, boxes);
    if (!status.ok()) return status;
  }
  return {};
}

Status check_size(const Scene& scene, const SceneLimits& limits) {
  const int sides[] = {scene.width, scene.height};
  for (int i = 0; i < 2; ++i) {
    if (sides[i] < 1 || sides[i] > limits.max_dimension_px) {
      return wrong("/size/" + std::to_string(i), "1.." + std::to_string(limits.max_dimension_px),
                   std::to_string(sides[i]));
    }
  }
  const int64_t pixels = int64_t{scene.width} * scene.height;
  if (pixels > limits.max_pixels) {
    return wrong("/size", "at most " + std::to_string(limits.max_pixels) + " pixels",
                 std::to_string(pixels), ErrorCode::kTooLarge);
  }
  if (scene.max_depth < 1 || scene.max_depth > kMaxDepth) {
    return wrong("/max_depth", "1.." + std::to_string(kMaxDepth), std::to_string(scene.max_depth));
  }
  return {};
}

Status check_counts(const Scene& scene, const SceneLimits& limits) {
  if (scene.materials.size() > limits.max_materials) {
    return wrong("/materials", "at most " + std::to_string(limits.max_materials),
                 std::to_string(scene.materials.size()), ErrorCode::kTooLarge);
  }
  if (scene.cameras.size() > limits.max_cameras) {
    return wrong("/cameras", "at most " + std::to_string(limits.max_cameras),
                 std::to_string(scene.cameras.size()), ErrorCode::kTooLarge);
  }
  if (scene.lights.size() > limits.max_lights) {
    return wrong("/lights", "at most " + std::to_string(limits.max_lights),
                 std::to_string(scene.lights.size()), ErrorCode::kTooLarge);
  }
  if (scene.instances.size() > limits.max_instances) {
    return wrong("/instances", "at most " + std::to_string(limits.max_instances),
                 std::to_string(scene.instances.size()), ErrorCode::kTooLarge);
  }
  const size_t triangles = scene.triangle_count();
  if (triangles > limits.max_triangles) {
    return wrong("/meshes", "at most " + std::to_string(limits.max_triangles) + " triangles",
                 std::to_string(triangles), ErrorCode::kTooLarge);
  }
  return {};
}

// What cannot be hit, sampled or given a normal in floats: its length is a sum of squares, which
// must not fall below the smallest normal float, 1e-38.
size_t drop_degenerate(Mesh& mesh) {
  constexpr float kMinDoubleArea = 1e-18f, kMinRadius = 1e-9f;
  if (mesh.sphere && mesh.sphere->radius < kMinRadius) {
    mesh.sphere.reset();
    return 1;
  }
  return std::erase_if(mesh.triangles, [&mesh](const auto& tri) {
    const Vec3 p = mesh.positions[tri[0]];
    const Vec3 n = cross(mesh.positions[tri[1]] - p, mesh.positions[tri[2]] - p);
    return !(length(n) > kMinDoubleArea);
  });
}

// Their instances too.
void drop_empty_meshes(Scene& scene) {
  std::vector<MeshId> kept(scene.meshes.size());
  uint32_t count = 0;
  for (size_t m = 0; m < scene.meshes.size(); ++m)
    if (!scene.meshes[m].empty()) kept[m] = MeshId(count++);
  for (Instance& instance : scene.instances) instance.mesh = kept[instance.mesh.value];
  std::erase_if(scene.instances, [](const Instance& instance) { return !instance.mesh.valid(); });
  std::erase_if(scene.meshes, [](const Mesh& mesh) { return mesh.empty(); });
}

}  // namespace

Status validate_camera(const Camera& camera, const std::string& place) {
  const struct {
    const char* name;
    Vec3 value;
  } vectors[] = {{"/position", camera.position}, {"/target", camera.target}, {"/up", camera.up}};
  for (const auto& v : vectors)
    if (!is_coordinate(v.value))
      return wrong(place + v.name, "numbers within 1e6 m", show(v.value));
  if (!(camera.vertical_fov_deg > 0 && camera.vertical_fov_deg < 180)) {
    return wrong(place + "/vertical_fov_deg", "more than 0 and less than 180",
                 show(camera.vertical_fov_deg));
  }
  Status status =
      check_range(place + "/aperture_radius", camera.aperture_radius, 0, kMaxCoordinate);
  if (status.ok())
    status = check_range(place + "/focus_distance", camera.focus_distance, 0, kMaxCoordinate);
  if (status.ok()) status = check_range(place + "/near_clip", camera.near_clip, 0, kMaxCoordinate);
  if (status.ok()) status = check_range(place + "/height", camera.height, 0, kMaxCoordinate);
  if (!status.ok()) return status;
  const Vec3 view = camera.target - camera.position;
  if (!(length(view) > 1e-6f))
    return wrong(place + "/target", "a point away from the position", show(camera.target));
  // The sine of the angle between them: a degenerate basis would make NaN rays.
  const Vec3 side = cross(normalize(view), camera.up);
  if (!(length(side) > 1e-4f * length(camera.up)))
    return wrong(place + "/up", "a direction other than the view's", show(camera.up));
  return {};
}

Result<ValidateReport> validate(Scene& scene, const SceneLimits& limits) {
  for (const Status& status : {check_size(scene, limits), validate_camera(scene.camera),
                               check_counts(scene, limits), check_environment(scene.environment)}) {
    if (!status.ok()) return status.error();
  }
  for (const NamedCamera& own : scene.cameras) {
    if (const Status status = validate_camera(own.camera, "/cameras/" + own.name); !status.ok())
      return status.error();
  }
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const Status status = check_material(scene.materials[i], i, scene.textures.size());
    if (!status.ok()) return status.error();
  }
  for (size_t i = 0; i < scene.textures.size(); ++i) {
    const UvTransform& t = scene.textures[i].uv_transform;
    for (const float v : {t.u[0], t.u[1], t.u[2], t.v[0], t.v[1], t.v[2]}) {
      if (!in_range(v, -kMaxCoordinate, kMaxCoordinate)) {
        return wrong("/textures/" + std::to_string(i) + "/uv_transform", "numbers within 1e6",
                     show(v));
      }
    }
  }
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const Status status = check_light(scene.lights[i], "/lights/" + std::to_string(i));
    if (!status.ok()) return status.error();
  }
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const Status status =
        check_mesh(scene.meshes[i], "/meshes/" + std::to_string(i), scene.materials.size());
    if (!status.ok()) return status.error();
  }
  if (const Status status = check_instances(scene); !status.ok()) return status.error();
  ValidateReport report;
  for (Mesh& mesh : scene.meshes) report.dropped_triangles += drop_degenerate(mesh);
  drop_empty_meshes(scene);
  if (scene.meshes.empty())
    return Error{ErrorCode::kInvalid, "expected at least one shape with an area", "/meshes"};
  return report;
}

}  // namespace qray
