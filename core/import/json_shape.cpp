#include "core/import/json_scene.h"
#include "core/import/primitives.h"
#include "core/scene/transform.h"

namespace qray {
namespace {

constexpr float kMinLength = 1e-6f;                                       // metres
constexpr Mat3 kPolesAtY{{Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}};  // of exact spheres

constexpr std::string_view kShapes[] = {"positions", "file",     "quad", "box",
                                        "sphere",    "cylinder", "disk"};

float positive(const JsonNode& node) { return node.number(kMinLength, kMaxCoordinate); }

int segments(const JsonNode& node) {
  const auto v = node.find("segments");
  return v ? v->integer(3, 4096) : 48;
}

std::array<uint32_t, 4> read_indices(const JsonNode& node, size_t corners, size_t vertex_count) {
  if (!node.is_array() || node.size() != corners)
    node.fail_expected("an array of " + std::to_string(corners) + " indices");
  if (vertex_count == 0) node.fail("expected positions to refer to");
  std::array<uint32_t, 4> out{};
  for (size_t i = 0; i < corners; ++i)
    out[i] = static_cast<uint32_t>(node.at(i).integer(0, static_cast<int>(vertex_count - 1)));
  return out;
}

Mesh read_inline(const JsonNode& node, const SceneLimits& limits) {
  Mesh mesh;
  const JsonNode positions = node.get("positions");
  for (size_t i = 0; i < positions.size(); ++i) mesh.positions.push_back(positions.at(i).vec3());
  if (const auto normals = node.find("normals")) {
    for (size_t i = 0; i < normals->size(); ++i)
      mesh.normals.push_back(normalize(normals->at(i).direction()));
  }
  if (const auto uvs = node.find("uvs")) {
    for (size_t i = 0; i < uvs->size(); ++i) {
      const std::vector<float> uv = uvs->at(i).numbers(2);
      mesh.uvs.push_back({uv[0], uv[1]});
    }
  }
  if (const auto colors = node.find("colors")) {
    for (size_t i = 0; i < colors->size(); ++i) {
      const std::vector<float> c = colors->at(i).numbers(3);
      mesh.colors.push_back({c[0], c[1], c[2]});
    }
  }
  if (node.has("triangles") == node.has("quads"))
    node.fail("expected either \"triangles\" or \"quads\" with \"positions\"");
  const bool quads = node.has("quads");
  const JsonNode faces = node.get(quads ? "quads" : "triangles");
  if (faces.size() > limits.max_triangles) {
    faces.fail("expected at most " + std::to_string(limits.max_triangles) + " triangles",
               ErrorCode::kTooLarge);
  }
  for (size_t i = 0; i < faces.size(); ++i) {
    const auto v = read_indices(faces.at(i), quads ? 4 : 3, mesh.positions.size());
    mesh.triangles.push_back({v[0], v[1], v[2]});
    if (quads) mesh.triangles.push_back({v[0], v[2], v[3]});
  }
  return mesh;
}

Mesh read_sphere(const JsonNode& node) {
  node.only({"center", "radius", "subdivisions", "smooth", "exact"});
  const auto exact = node.find("exact");
  for (const char* key : {"subdivisions", "smooth"})
    if (const auto v = node.find(key); v && exact) v->fail("expected only without \"exact\"");
  if (exact && exact->boolean()) {
    Mesh mesh;
    mesh.sphere = Sphere{node.get("center").vec3(), positive(node.get("radius")), false, kPolesAtY};
    return mesh;
  }
  const auto subdivisions = node.find("subdivisions");
  Mesh mesh = make_sphere(node.get("center").vec3(), positive(node.get("radius")),
                          subdivisions ? subdivisions->integer(0, 7) : 4);
  if (const auto smooth = node.find("smooth"); smooth && !smooth->boolean()) mesh.normals.clear();
  return mesh;
}

Mesh read_cylinder(const JsonNode& node) {
  node.only({"base", "height", "radius", "top_radius", "segments", "caps"});
  const float radius = positive(node.get("radius"));
  const auto top_radius = node.find("top_radius");
  const auto caps = node.find("caps");
  return make_cylinder(node.get("base").vec3(), positive(node.get("height")), radius,
                       top_radius ? positive(*top_radius) : radius, segments(node),
                       !caps || caps->boolean());
}

Mesh read_primitive(const JsonNode& node, std::string_view shape) {
  if (shape == "quad") {
    node.only({"origin", "edge1", "edge2"});
    return make_quad(node.get("origin").vec3(), node.get("edge1").direction(),
                     node.get("edge2").direction());
  }
  if (shape == "box") {
    node.only({"min", "max"});
    const Vec3 lo = node.get("min").vec3(), hi = node.get("max").vec3();
    for (int i = 0; i < 3; ++i)
      if (!(lo[i] < hi[i])) node.get("max").fail("expected more than \"min\" on every axis");
    return make_box(lo, hi);
  }
  if (shape == "sphere") return read_sphere(node);
  if (shape == "cylinder") return read_cylinder(node);
  node.only({"center", "normal", "radius", "segments"});
  return make_disk(node.get("center").vec3(), node.get("normal").direction(),
                   positive(node.get("radius")), segments(node));
}

Transform read_matrix(const JsonNode& node) {
  const std::vector<float> m = node.numbers(16);
  const float last_row[] = {0, 0, 0, 1};
  Transform t;
  for (size_t i = 0; i < 16; ++i) {
    if (i < 12)
      t.rows[i / 4][i % 4] = m[i];
    else if (m[i] != last_row[i - 12])
      node.at(i).fail_expected("the last row to be 0, 0, 0, 1");
  }
  return t;
}

Vec3 read_scale(const JsonNode& node) {
  const auto factor = [](const JsonNode& n) {
    const float v = n.number(-kMaxCoordinate, kMaxCoordinate);
    if (std::abs(v) < kMinLength) n.fail_expected("a factor of 1e-6 or more in size");
    return v;
  };
  if (node.is_number()) {
    const float all = factor(node);
    return {all, all, all};
  }
  if (!node.is_array() || node.size() != 3) node.fail_expected("a number or [x, y, z]");
  return {factor(node.at(0)), factor(node.at(1)), factor(node.at(2))};
}

Transform read_transform(const JsonNode& node) {
  node.only({"matrix", "scale", "rotate", "translate"});
  if (const auto matrix = node.find("matrix")) {
    for (const char* key : {"scale", "rotate", "translate"})
      if (const auto v = node.find(key)) v->fail("expected \"matrix\" alone");
    return read_matrix(*matrix);
  }
  Transform t;
  if (const auto scale = node.find("scale")) t = Transform::scaling(read_scale(*scale));
  if (const auto rotate = node.find("rotate")) {
    rotate->only({"axis", "deg"});
    t = Transform::rotation(rotate->get("axis").direction(), rotate->get("deg").number(-360, 360))
            .after(t);
  }
  if (const auto translate = node.find("translate"))
    t = Transform::translation(translate->vec3()).after(t);
  return t;
}

}  // namespace

Mesh read_shape(const JsonNode& node, const SceneLimits& limits) {
  std::string_view shape;
  for (const std::string_view name : kShapes) {
    if (!node.has(name)) continue;
    if (!shape.empty()) {
      node.get(name).fail("expected one shape a mesh, this has \"" + std::string(shape) +
                          "\" already");
    }
    shape = name;
  }
  if (shape.empty()) {
    node.fail(
        "expected one of \"positions\", \"file\", \"quad\", \"box\", \"sphere\", "
        "\"cylinder\", \"disk\"");
  }
  if (shape != "positions") {
    for (const char* key : {"triangles", "quads", "normals", "uvs", "colors"})
      if (const auto v = node.find(key)) v->fail("expected only with \"positions\"");
  }
  if (shape == "file") return {};
  Mesh mesh =
      shape == "positions" ? read_inline(node, limits) : read_primitive(node.get(shape), shape);
  apply_placement(node, mesh);
  return mesh;
}

Transform read_placement(const JsonNode& node) {
  const auto placement = node.find("transform");
  if (!placement) return {};
  const Transform transform = read_transform(*placement);
  const double determinant = transform.determinant();
  if (!(std::abs(determinant) > 1e-20 && std::isfinite(determinant)))
    placement->fail("expected a map that keeps volume, this one is flat or not finite");
  return transform;
}

void apply_placement(const JsonNode& node, Mesh& mesh) {
  if (const auto transform = node.find("transform")) {
    const Transform placement = read_placement(node);
    if (mesh.sphere && !placement.keeps_spheres())
      transform->fail("expected one scale for all directions of an exact sphere");
    placement.apply(mesh);
  }
  if (const auto flip = node.find("flip"); flip && flip->boolean()) flip_winding(mesh);
}

}  // namespace qray
