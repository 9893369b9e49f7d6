#include "core/import/gltf_pose.h"

namespace qray {
namespace {

using Four = std::array<float, 4>;

void add(Transform& sum, const Transform& t, double weight) {
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) sum.rows[r][c] += weight * t.rows[r][c];
}

}  // namespace

std::optional<std::vector<Transform>> read_gltf_joints(
    GltfImport& import, int skin, const std::vector<std::optional<Transform>>& to_world) {
  const GltfModel::Skin& s = import.document.model().skins[static_cast<size_t>(skin)];
  const JsonNode place = import.document.at("skins", skin);
  std::vector<std::array<float, 16>> inverse;
  if (s.inverse_matrices >= 0) {
    const GltfAccessor matrices(import, s.inverse_matrices, 16, import.limits.max_instances);
    if (matrices.count() < s.joints.size())
      matrices.node().get("count").fail_expected("at least " + std::to_string(s.joints.size()) +
                                                 ", as many as joints");
    inverse = matrices.read<std::array<float, 16>>();
  }
  std::vector<Transform> out;
  for (size_t j = 0; j < s.joints.size(); ++j) {
    const std::optional<Transform>& joint = to_world[static_cast<size_t>(s.joints[j])];
    if (!joint) {
      import.warn(place.get("joints").at(j), "the joint is not in the scene: drawn without skin");
      return {};
    }
    out.push_back(inverse.empty() ? *joint : joint->after(transform_of_columns(inverse[j])));
  }
  return out;
}

void add_gltf_target(Mesh& mesh, const GltfAttribute& target, float weight,
                     std::span<const uint32_t> wanted) {
  const auto add = [&](std::vector<Vec3>& to, const char* name) {
    const auto accessor = target(name, 3);
    if (!accessor || to.empty()) return;
    const std::vector<Vec3> moves = accessor->read<Vec3>(wanted);
    for (size_t i = 0; i < to.size(); ++i) to[i] += moves[i] * weight;
  };
  add(mesh.positions, "POSITION");
  add(mesh.normals, "NORMAL");
}

void apply_gltf_skin(Mesh& mesh, const JsonNode& primitive, const GltfAttribute& find,
                     std::span<const Transform> joints, std::span<const uint32_t> wanted) {
  std::vector<Transform> blended(mesh.positions.size());
  for (Transform& t : blended) t.rows = {};
  std::vector<double> sums(blended.size());
  for (int set = 0; set < 16; ++set) {
    const std::string number = std::to_string(set);
    const auto ids = find("JOINTS_" + number, 4), weights = find("WEIGHTS_" + number, 4);
    if (!ids || !weights) {
      if (set == 0)
        primitive.get("attributes").fail("expected JOINTS_0 and WEIGHTS_0 for its skin");
      break;
    }
    const std::vector<Four> id = ids->read<Four>(wanted), weight = weights->read<Four>(wanted);
    for (size_t i = 0; i < blended.size(); ++i) {
      for (size_t k = 0; k < 4; ++k) {
        const float w = weight[i][k];
        if (!(w > 0 && std::isfinite(w))) continue;
        if (!(id[i][k] >= 0 && id[i][k] < static_cast<float>(joints.size())))
          ids->node().fail("expected joints below " + std::to_string(joints.size()));
        add(blended[i], joints[static_cast<size_t>(id[i][k])], w);
        sums[i] += w;
      }
    }
  }
  for (size_t i = 0; i < blended.size(); ++i) {
    if (!(sums[i] > 0)) {  // a vertex of no joint follows the first
      blended[i] = joints[0];
      sums[i] = 1;
    }
    for (auto& row : blended[i].rows)
      for (double& v : row) v /= sums[i];
    mesh.positions[i] = blended[i].point(mesh.positions[i]);
    if (mesh.normals.empty()) continue;
    const Vec3 n = blended[i].normals() * mesh.normals[i];
    if (length(n) > 0) mesh.normals[i] = normalize(n);
  }
}

}  // namespace qray
