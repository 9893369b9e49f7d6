#include "core/import/gltf_mesh.h"

#include <algorithm>

#include "core/import/gltf_draco.h"

namespace qray {
namespace {

size_t triangles_of(int mode, size_t corners) {
  if (mode == kGltfTriangles) return corners / 3;
  return corners < 3 ? 0 : corners - 2;
}

// The corners of triangle `i`, as the specification winds them (3.7.2.1).
std::array<size_t, 3> corners_of(int mode, size_t i) {
  if (mode == kGltfTriangles) return {3 * i, 3 * i + 1, 3 * i + 2};
  if (mode == kGltfTriangleFan) return {i + 1, i + 2, 0};
  return {i, i + 1 + i % 2, i + 2 - i % 2};
}

// Makes `triangles` count in the vertices they use, and returns which these are: files may keep
// the vertices of many primitives in one accessor.
std::vector<uint32_t> keep_used(std::vector<std::array<uint32_t, 3>>& triangles) {
  std::vector<uint32_t> used;
  used.reserve(3 * triangles.size());
  for (const auto& t : triangles) used.insert(used.end(), t.begin(), t.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (auto& t : triangles)
    for (uint32_t& v : t)
      v = static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
  return used;
}

// False where one is no direction.
bool make_unit(std::vector<Vec3>& normals) {
  for (Vec3& n : normals) {
    const float norm = length(n);
    if (!(norm > 0 && std::isfinite(norm))) return false;
    n = n / norm;
  }
  return true;
}

}  // namespace

Mesh GltfMeshes::read(int mesh_index, int primitive_index, const GltfMaterials::Converted& material,
                      const GltfPose& pose) {
  const GltfModel& model = import_.document.model();
  const GltfModel::Mesh& source = model.meshes[static_cast<size_t>(mesh_index)];
  const GltfModel::Primitive& primitive = source.primitives[static_cast<size_t>(primitive_index)];
  const JsonNode place = import_.document.at("meshes", mesh_index)
                             .get("primitives")
                             .at(static_cast<size_t>(primitive_index));
  Mesh mesh;
  mesh.name = source.name;
  mesh.material = material.id;
  if (primitive.mode < kGltfTriangles) {
    import_.warn(place,
                 primitive.mode == kGltfPoints ? "points are left out" : "lines are left out");
    return mesh;
  }
  import_.expect_extensions(place, {"KHR_materials_variants", "KHR_draco_mesh_compression"});
  std::optional<GltfUnpacked> unpacked;
  if (const auto draco = find_extension(place, "KHR_draco_mesh_compression"))
    unpacked = unpack_draco(*draco, primitive, import_.document);
  const int mode = unpacked ? kGltfTriangles : primitive.mode;

  // Counts first: what is read is at most three vertices a triangle.
  const auto attribute = [&primitive](const std::string& name) {
    const auto it = primitive.attributes.find(name);
    return it == primitive.attributes.end() ? -1 : it->second;
  };
  if (attribute("POSITION") < 0) place.get("attributes").fail("expected a POSITION");
  const size_t no_limit = std::numeric_limits<size_t>::max();
  const auto accessor = [&](const std::string& name, int components) {
    const int index = attribute(name);
    if (unpacked)
      if (const auto it = unpacked->attributes.find(name); it != unpacked->attributes.end())
        return GltfAccessor(import_, index, it->second, components, no_limit);
    return GltfAccessor(import_, index, components, no_limit);
  };
  const GltfAccessor positions = accessor("POSITION", 3);
  std::optional<GltfAccessor> indices;
  if (unpacked)
    indices.emplace(import_, std::max(primitive.indices, 0), unpacked->indices, 1, no_limit);
  else if (primitive.indices >= 0)
    indices.emplace(import_, primitive.indices, 1, no_limit);
  const size_t corner_count = indices ? indices->count() : positions.count();
  const size_t triangles = triangles_of(mode, corner_count);
  triangle_count_ += triangles;
  if (triangle_count_ > import_.limits.max_triangles) {
    place.fail("expected at most " + std::to_string(import_.limits.max_triangles) + " triangles",
               ErrorCode::kTooLarge);
  }

  const std::vector<uint32_t> corners = indices ? indices->read_indices() : std::vector<uint32_t>{};
  mesh.triangles.resize(triangles);
  for (size_t i = 0; i < triangles; ++i) {
    const std::array<size_t, 3> at = corners_of(mode, i);
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t v = corners.empty() ? static_cast<uint32_t>(at[c]) : corners[at[c]];
      if (v >= positions.count()) {
        place.get("indices").fail("expected indices below " + std::to_string(positions.count()) +
                                  ", got " + std::to_string(v) + " at " + std::to_string(at[c]));
      }
      mesh.triangles[i][c] = v;
    }
  }
  if (mesh.triangles.empty()) return mesh;
  std::vector<uint32_t> wanted;
  if (indices && positions.count() > corner_count) wanted = keep_used(mesh.triangles);

  mesh.positions = positions.read<Vec3>(wanted);
  const auto checked = [&](GltfAccessor found) {
    if (found.count() != positions.count())
      found.node().get("count").fail_expected(std::to_string(positions.count()) +
                                              ", as of the positions");
    return found;
  };
  const auto find = [&](const std::string& name, int components) -> std::optional<GltfAccessor> {
    if (attribute(name) < 0) return {};
    return checked(accessor(name, components));
  };
  const auto normals = find("NORMAL", 3);
  if (normals) mesh.normals = normals->read<Vec3>(wanted);
  for (size_t t = 0; t < std::min(primitive.targets.size(), pose.weights.size()); ++t) {
    if (pose.weights[t] == 0) continue;
    const auto target = [&](const std::string& name, int n) -> std::optional<GltfAccessor> {
      const auto it = primitive.targets[t].find(name);
      if (it == primitive.targets[t].end()) return {};
      return checked(GltfAccessor(import_, it->second, n, no_limit));
    };
    add_gltf_target(mesh, target, static_cast<float>(pose.weights[t]), wanted);
  }
  if (!pose.joints.empty()) apply_gltf_skin(mesh, place, find, pose.joints, wanted);
  if (normals) {
    if (!make_unit(mesh.normals)) {
      import_.warn(normals->node(), "has normals without a direction: drawn flat");
      mesh.normals.clear();
    }
  }
  const auto read_uvs = [&](int set) {
    const auto found = find("TEXCOORD_" + std::to_string(set), 2);
    std::vector<Vec2> uvs = found ? found->read<Vec2>(wanted) : std::vector<Vec2>{};
    for (Vec2& uv : uvs) uv.y = 1 - uv.y;
    return uvs;
  };
  mesh.uvs = read_uvs(material.uv_sets.empty() ? 0 : material.uv_sets[0]);
  if (material.uv_sets.size() == 2) mesh.second_uvs = read_uvs(material.uv_sets[1]);
  if (const int color = attribute("COLOR_0"); color >= 0) {
    const bool alpha = model.accessors[static_cast<size_t>(color)].components == 4;
    read_colors(mesh, *find("COLOR_0", alpha ? 4 : 3), wanted, material);
  }
  return mesh;
}

void GltfMeshes::read_colors(Mesh& mesh, const GltfAccessor& colors,
                             std::span<const uint32_t> wanted,
                             const GltfMaterials::Converted& material) {
  if (material.unlit) return import_.warn(colors.node(), "unlit colours of vertices are left out");
  bool clamped = false, transparent = false;
  for (const auto& rgba : colors.read<std::array<float, 4>>(wanted)) {
    transparent = transparent || (colors.components() == 4 && rgba[3] != 1);
    Rgb& rgb = mesh.colors.emplace_back(rgba[0], rgba[1], rgba[2]);
    for (int c = 0; c < 3; ++c) {
      clamped = clamped || !(rgb[c] >= 0 && rgb[c] <= 1);
      rgb[c] = rgb[c] > 0 ? std::min(rgb[c], 1.0f) : 0;
    }
  }
  if (clamped) import_.warn(colors.node(), "colours outside 0..1 are drawn as the nearest");
  if (transparent && !material.opaque)
    import_.warn(colors.node(), "the alpha of vertices is left out");
}

}  // namespace qray
