#include "core/import/mitsuba_shape.h"

#include <cmath>

#include "core/base/file.h"
#include "core/import/mitsuba_normals.h"
#include "core/import/obj.h"
#include "core/import/ply.h"
#include "core/import/primitives.h"

namespace qray {
namespace {

constexpr uint64_t kMaxSerializedBytes = uint64_t{1} << 30;
constexpr int kDiskSegments = 64;
// Those that are not exact, together; a single one has no more than 64 rings, 2 degrees each.
constexpr double kSphereTriangles = 200'000;
constexpr int kMinSphereRings = 12, kMaxSphereRings = 64;

void flip_v(Mesh& mesh) {
  for (Vec2& uv : mesh.uvs) uv.y = 1 - uv.y;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 p = mesh.positions[t[0]];
    sum += static_cast<double>(length(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p)));
  }
  return sum / 2;
}

// About the origin, so that the area becomes `exact`.
void scale_to_area(Mesh& mesh, double exact) {
  const auto factor = static_cast<float>(std::sqrt(exact / area(mesh)));
  for (Vec3& p : mesh.positions) p = p * factor;
}

Mesh unit_cube() {
  // The corner where uv is (0, 0), that where u is 1, and that where v is 1, of each face.
  constexpr Vec3 kFaces[6][3] = {
      {{1, -1, -1}, {1, -1, 1}, {-1, -1, -1}}, {{1, 1, -1}, {-1, 1, -1}, {1, 1, 1}},
      {{1, -1, -1}, {1, 1, -1}, {1, -1, 1}},   {{1, -1, 1}, {1, 1, 1}, {-1, -1, 1}},
      {{-1, -1, 1}, {-1, 1, 1}, {-1, -1, -1}}, {{1, 1, -1}, {1, -1, -1}, {-1, 1, -1}}};
  Mesh mesh;
  for (const auto& face : kFaces) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    const Mesh quad = make_quad(face[0], face[1] - face[0], face[2] - face[0]);
    mesh.positions.insert(mesh.positions.end(), quad.positions.begin(), quad.positions.end());
    mesh.uvs.insert(mesh.uvs.end(), quad.uvs.begin(), quad.uvs.end());
    for (const auto& [a, b, c] : quad.triangles)
      mesh.triangles.push_back({first + a, first + b, first + c});
  }
  return mesh;
}

// u = phi / 2 pi, v = theta / pi from the pole +z, which Mitsuba counts downward.
Mesh unit_sphere(int rings) {
  const int segments = 2 * rings;
  Mesh mesh;
  for (int i = 0; i <= rings; ++i) {
    const double theta = std::numbers::pi * i / rings;
    for (int j = 0; j <= segments; ++j) {
      const double phi = 2 * std::numbers::pi * (j % segments) / segments;
      const Vec3 n{static_cast<float>(std::sin(theta) * std::cos(phi)),
                   static_cast<float>(std::sin(theta) * std::sin(phi)),
                   static_cast<float>(std::cos(theta))};
      mesh.positions.push_back(n);
      mesh.normals.push_back(n);
      mesh.uvs.push_back({static_cast<float>(j) / static_cast<float>(segments),
                          1 - static_cast<float>(i) / static_cast<float>(rings)});
    }
  }
  const auto row = static_cast<uint32_t>(segments + 1);
  for (uint32_t i = 0; i < static_cast<uint32_t>(rings); ++i) {
    for (uint32_t j = 0; j + 1 < row; ++j) {
      const uint32_t a = i * row + j, below = a + row;
      if (i > 0) mesh.triangles.push_back({a, below, a + 1});
      if (i + 1 < static_cast<uint32_t>(rings)) mesh.triangles.push_back({a + 1, below, below + 1});
    }
  }
  scale_to_area(mesh, 4 * std::numbers::pi);
  return mesh;
}

// u = radius, v = phi / 2 pi.
Mesh unit_disk() {
  Mesh mesh;
  for (int i = 0; i < kDiskSegments; ++i) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    const float u[] = {static_cast<float>(i) / kDiskSegments,
                       static_cast<float>(i + 1) / kDiskSegments};
    mesh.positions.push_back({0, 0, 0});
    mesh.uvs.push_back({0, 1 - (u[0] + u[1]) / 2});
    for (const float v : u) {
      mesh.positions.push_back({std::cos(2 * kPi * v), std::sin(2 * kPi * v), 0});
      mesh.uvs.push_back({1, 1 - v});
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  scale_to_area(mesh, std::numbers::pi);
  return mesh;
}

Mesh sphere(const MitsubaNode& shape, bool exact, int rings) {
  const Vec3 center = find_point(shape, "center").value_or(Vec3{0, 0, 0});
  const auto radius = static_cast<float>(find_number(shape, "radius").value_or(1));
  if (!(radius > 0)) find_parameter(shape, "radius")->fail("expected a radius over 0");
  if (exact) {
    Mesh mesh;
    mesh.sphere = Sphere{center, radius, false, Mat3{}};
    return mesh;
  }
  Mesh mesh = unit_sphere(rings);
  for (Vec3& p : mesh.positions) p = center + p * radius;
  return mesh;
}

// Open, from p0 to p1.
Mesh cylinder(const MitsubaNode& shape) {
  const Vec3 p0 = find_point(shape, "p0").value_or(Vec3{0, 0, 0});
  const Vec3 p1 = find_point(shape, "p1").value_or(Vec3{0, 0, 1});
  const double radius = find_number(shape, "radius").value_or(1);
  const Vec3 axis = p1 - p0;
  if (!(radius > 0) || !(length(axis) > 0)) shape.fail("expected a radius and a length over 0");
  // A regular polygon of the circle's circumference.
  const double outer =
      std::numbers::pi / kDiskSegments / std::sin(std::numbers::pi / kDiskSegments);
  const auto r = static_cast<float>(radius * outer);
  Mesh mesh = make_cylinder({0, 0, 0}, length(axis), r, r, kDiskSegments, /*caps=*/false);
  const Vec3 y = normalize(axis), across = std::abs(y.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 0, 1};
  const Vec3 x = normalize(cross(across, y)), z = cross(x, y);
  Transform placed;
  for (int i = 0; i < 3; ++i) placed.rows[static_cast<size_t>(i)] = {x[i], y[i], z[i], p0[i]};
  placed.apply(mesh);
  return mesh;
}

// Mitsuba's front is where the vertex normals point, ours where the winding does.
void face_along_normals(Mesh& mesh) {
  if (mesh.normals.empty()) return;
  for (auto& t : mesh.triangles) {
    const Vec3 p = mesh.positions[t[0]];
    const Vec3 ng = cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p);
    if (dot(ng, mesh.normals[t[0]] + mesh.normals[t[1]] + mesh.normals[t[2]]) < 0)
      std::swap(t[1], t[2]);
  }
}

bool is_file_shape(const MitsubaNode& shape) {
  return shape.type == "obj" || shape.type == "ply" || shape.type == "serialized";
}

template <class Visit>
void each_shape(const MitsubaNode& node, const Visit& visit) {
  if (node.tag == "shape") visit(node);
  for (const MitsubaNode& child : node.children) each_shape(child, visit);
}

}  // namespace

MitsubaShapes::MitsubaShapes(MitsubaImport& import) : import_(import) {
  double spheres = 0;
  each_shape(import.document.root, [&](const MitsubaNode& shape) {
    if (shape.type == "sphere") ++spheres;
    if (const std::string* name = find_text(shape, "filename")) ++uses_[*name];
  });
  // A sphere of n rings has about 4 n^2 triangles.
  const double rings = std::sqrt(kSphereTriangles / 4 / std::max(spheres, 1.0));
  sphere_rings_ = std::clamp(static_cast<int>(rings), kMinSphereRings, kMaxSphereRings);
}

std::vector<Mesh> MitsubaShapes::read(const MitsubaNode& shape, bool instanced) {
  const std::optional<Transform> to_world = find_transform(shape, "to_world");
  const bool exact = !instanced && (!to_world || to_world->keeps_spheres());
  std::vector<Mesh> meshes =
      is_file_shape(shape) ? read_file_shape(shape) : read_object_space(shape, exact);
  const bool flip = find_flag(shape, "flip_normals").value_or(false);
  for (Mesh& mesh : meshes) {
    if (to_world) {
      to_world->apply(mesh);
      // The winding alone says what is in front of a mesh without normals, mirrored or not.
      if (is_file_shape(shape) && mesh.normals.empty() && to_world->determinant() < 0)
        flip_winding(mesh);
    }
    face_along_normals(mesh);
    if (flip) flip_winding(mesh);
  }
  return meshes;
}

std::vector<Mesh> MitsubaShapes::read_object_space(const MitsubaNode& shape, bool exact) {
  if (shape.type == "cube") return {unit_cube()};
  if (shape.type == "sphere") return {sphere(shape, exact, sphere_rings_)};
  if (shape.type == "disk") return {unit_disk()};
  if (shape.type == "cylinder") return {cylinder(shape)};
  if (shape.type == "rectangle") {
    Mesh mesh = make_quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    flip_v(mesh);
    return {mesh};
  }
  import_.warn(shape, "shapes of type \"" + shape.type + "\" are left out");
  return {};
}

std::vector<Mesh> MitsubaShapes::read_file_shape(const MitsubaNode& shape) {
  const std::string* name = find_text(shape, "filename");
  if (!name) shape.fail("expected a \"filename\" of the shape");
  const std::filesystem::path path =
      import_.document.find_file(*find_parameter(shape, "filename"), *name);
  const bool again = --uses_[*name] > 0;
  std::vector<Mesh> meshes;
  bool face_normals = find_flag(shape, "face_normals").value_or(false);
  if (shape.type == "serialized") {
    SerializedShape read = read_serialized_shape(shape, path);
    face_normals = face_normals || read.face_normals;
    meshes.push_back(std::move(read.mesh));
  } else if (const auto kept = meshes_.find(path); kept != meshes_.end()) {
    meshes = again ? kept->second : std::move(kept->second);
    if (!again) meshes_.erase(kept);
  } else {
    meshes = read_mesh_file(shape, path);
    if (again) meshes_.emplace(path, meshes);
  }
  const std::optional<double> angle = find_number(shape, "max_smooth_angle");
  // Mitsuba's v = 0 is a picture's top, which its OBJ reader turns around unless told otherwise.
  const bool stored_upward = shape.type == "obj";
  const bool turned = find_flag(shape, "flip_tex_coords").value_or(stored_upward);
  for (Mesh& mesh : meshes) {
    if (!turned) flip_v(mesh);
    if (face_normals)
      mesh.normals.clear();
    else if (angle)
      smooth_normals(mesh, static_cast<float>(*angle));
    else if (mesh.normals.empty())
      smooth_normals(mesh);
  }
  return meshes;
}

std::vector<Mesh> MitsubaShapes::read_mesh_file(const MitsubaNode& shape,
                                                const std::filesystem::path& path) {
  if (shape.type == "ply") {
    std::vector<Mesh> meshes;
    meshes.push_back(read_ply(path, import_.limits));
    return meshes;
  }
  return read_obj(path, import_.limits).meshes;
}

SerializedShape MitsubaShapes::read_serialized_shape(const MitsubaNode& shape,
                                                     const std::filesystem::path& path) {
  if (serialized_path_ != path) {
    Result<Bytes> bytes = read_file(path, kMaxSerializedBytes);
    if (!bytes.ok()) shape.fail(bytes.error().message, bytes.error().code);
    serialized_ = std::move(bytes).value();
    serialized_path_ = path;
  }
  const double index = find_number(shape, "shape_index").value_or(0);
  if (!(index >= 0 && index < 1e9 && index == std::floor(index)))
    find_parameter(shape, "shape_index")->fail("expected a whole number from 0");
  return read_serialized(serialized_, static_cast<size_t>(index), import_.limits, path.filename());
}

}  // namespace qray
