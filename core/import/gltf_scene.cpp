#include "core/import/gltf_scene.h"

#include <algorithm>
#include <utility>

#include "core/import/fit_camera.h"
#include "core/import/gltf_light.h"
#include "core/import/gltf_mesh.h"
#include "core/import/gltf_motion.h"

namespace qray {
namespace {

constexpr double kLeastVolume = 1e-20;     // of a map, as validate() wants it
constexpr size_t kMaxPathSteps = 250'000;  // nodes above all cameras that move

// What is wrong with them is no reason not to draw the scene at rest.
GltfMotions motions_of(GltfImport& import) {
  try {
    return read_gltf_motions(import);
  } catch (const ImportFailure& failure) {
    import.out.warn(failure.error.where, failure.error.message + "; nothing moves");
    return {};
  }
}

class GltfReader {
 public:
  GltfReader(GltfImport& import, std::optional<double> seconds)
      : import_(import),
        document_(import.document),
        materials_(import),
        meshes_(import),
        motions_(motions_of(import)),
        seconds_(seconds) {}

  void read() {
    warn_of_document();
    walk();
    tell_what_moves();
    add_meshes();
    Scene& scene = import_.out.scene;
    if (scene.meshes.empty()) document_.root().fail("expected a scene with triangles");
    if (!has_camera_) scene.camera = fit_camera(scene, /*fronts_are_known=*/true);
    if (!has_light_) scene.environment.radiance = Rgb{1.0f};
  }

 private:
  // A mesh, and the node that poses it; -1: it is as every node has it.
  using PosedMesh = std::pair<int, int>;
  // One in a place.
  struct Use {
    int node;
    Transform to_world;
  };

  void warn_of_document() {
    const JsonNode root = document_.root();
    import_.expect_extensions(root, {"KHR_lights_punctual", "KHR_materials_variants"});
    if (const auto variants = find_extension(root, "KHR_materials_variants"))
      import_.warn(*variants, "drawn with the materials of no variant");
    const GltfModel& model = document_.model();
    for (const auto* broken :
         {&model.images.broken(), &model.textures.broken(), &model.samplers.broken()})
      for (const auto& [index, error] : *broken)
        import_.out.warn(error.where, error.message + "; nothing drawn uses it");
    if (document_.count("scenes") > 1)
      import_.warn(root.get("scenes"), "only the default scene is drawn");
  }

  // The nodes of the scene, from the top; each has one parent, so no path is without an end.
  void walk() {
    struct Step {
      int node, parent;
      Transform above;
    };
    std::vector<Step> waiting;
    const std::vector<int> roots = find_roots();
    for (auto it = roots.rbegin(); it != roots.rend(); ++it) waiting.push_back({*it, -1, {}});
    std::vector<bool> visited(document_.model().nodes.size());
    to_world_.resize(visited.size());
    moves_.resize(visited.size());
    parents_.resize(visited.size(), -1);
    while (!waiting.empty()) {
      const Step step = waiting.back();
      waiting.pop_back();
      const auto index = static_cast<size_t>(step.node);
      if (visited[index])
        document_.at("nodes", step.node).fail("expected a node below one other at most, no cycles");
      visited[index] = true;
      const GltfModel::Node& node = document_.model().nodes[index];
      const Transform to_world = step.above.after(pose_of_node(step.node).to_parent());
      to_world_[index] = to_world;
      const auto motion = motions_.find(step.node);
      moves_[index] = (step.parent >= 0 && moves_[static_cast<size_t>(step.parent)]) ||
                      (motion != motions_.end() && motion->second->moves_node());
      parents_[index] = step.parent;
      read_node(step.node, node, to_world);
      for (auto it = node.children.rbegin(); it != node.children.rend(); ++it)
        waiting.push_back({*it, step.node, to_world});
    }
  }

  // As it is at the time that is read.
  NodePose pose_of_node(int index) const {
    const NodePose& rest = document_.model().nodes[static_cast<size_t>(index)].rest;
    const auto motion = motions_.find(index);
    return seconds_ && motion != motions_.end() ? motion->second->at(*seconds_, rest) : rest;
  }

  // What moves, moves a camera, or what light meets.
  void tell_what_moves() {
    Scene& scene = import_.out.scene;
    const auto& nodes = document_.model().nodes;
    std::vector<bool> skin_moves;
    for (const GltfModel::Skin& skin : document_.model().skins)
      skin_moves.push_back(std::ranges::any_of(
          skin.joints, [&](int joint) { return moves_[static_cast<size_t>(joint)]; }));
    bool any = false;
    for (size_t i = 0; i < nodes.size(); ++i) {
      if (!to_world_[i]) continue;
      const GltfModel::Node& node = nodes[i];
      const auto motion = motions_.find(static_cast<int>(i));
      bool surfaces = moves_[i] && (node.mesh >= 0 || is_light(static_cast<int>(i)));
      if (node.mesh >= 0 && motion != motions_.end())
        surfaces = surfaces || !motion->second->weights.seconds.empty();
      if (node.mesh >= 0 && node.skin >= 0)
        surfaces = surfaces || skin_moves[static_cast<size_t>(node.skin)];
      scene.moves_surfaces = scene.moves_surfaces || surfaces;
      any = any || surfaces || (moves_[i] && node.camera >= 0);
    }
    if (!any) return;
    for (const auto& [node, motion] : motions_)
      scene.motion_seconds = std::max(scene.motion_seconds, motion->end());
  }

  bool is_light(int node) const {
    return find_extension(document_.at("nodes", node), "KHR_lights_punctual").has_value();
  }

  // Of a camera whose node moves; else null.
  std::shared_ptr<const CameraPath> path_of(int node, const Camera& lens) {
    if (!moves_[static_cast<size_t>(node)]) return nullptr;
    auto path = std::make_shared<CameraPath>();
    path->lens = lens;
    for (int above = node; above >= 0; above = parents_[static_cast<size_t>(above)]) {
      const auto motion = motions_.find(above);
      path->steps.push_back({document_.model().nodes[static_cast<size_t>(above)].rest,
                             motion == motions_.end() ? nullptr : motion->second});
      if (++path_steps_ > kMaxPathSteps)
        document_.at("nodes", node)
            .fail("expected at most " + std::to_string(kMaxPathSteps) +
                      " nodes above cameras that move",
                  ErrorCode::kTooLarge);
    }
    std::ranges::reverse(path->steps);
    return path;
  }

  // Of the scene; all that are below no other where there is none.
  std::vector<int> find_roots() const {
    const GltfModel& model = document_.model();
    if (!model.scenes.empty()) return model.scenes[static_cast<size_t>(std::max(model.scene, 0))];
    std::vector<bool> below(model.nodes.size());
    for (const GltfModel::Node& node : model.nodes)
      for (const int child : node.children) below[static_cast<size_t>(child)] = true;
    std::vector<int> roots;
    for (size_t i = 0; i < below.size(); ++i)
      if (!below[i]) roots.push_back(static_cast<int>(i));
    return roots;
  }

  void read_node(int index, const GltfModel::Node& node, const Transform& to_world) {
    const JsonNode place = document_.at("nodes", index);
    import_.expect_extensions(place, {"KHR_lights_punctual", "EXT_mesh_gpu_instancing"});
    if (const auto light = find_extension(place, "KHR_lights_punctual")) {
      import_.out.scene.lights.push_back(read_gltf_light(light->get("light"), to_world, import_));
      has_light_ = has_light_ || import_.out.scene.lights.back().emits();
    }
    if (node.camera >= 0) add_camera(index, document_.at("cameras", node.camera), to_world);
    if (node.mesh < 0) return;
    if (const auto instances = find_extension(place, "EXT_mesh_gpu_instancing"))
      add_gpu_instances(*instances, index, node.mesh, to_world);
    else
      add_use(index, node.mesh, to_world);
  }

  // The first is the view, and says what the picture's size is; all can be asked for by name.
  void add_camera(int node, const JsonNode& camera, const Transform& to_world) {
    const JsonNode place = document_.at("nodes", node);
    Scene& scene = import_.out.scene;
    const Camera first = std::exchange(scene.camera, Camera());
    const int width = scene.width, height = scene.height;
    read_gltf_camera(camera, place, to_world, import_);
    const auto name = place.has("name") ? place.find("name") : camera.find("name");
    const auto path = path_of(node, scene.camera);
    scene.add_camera(name && name->is_string() ? name->string() : "", scene.camera, path);
    if (!std::exchange(has_camera_, true)) {
      scene.camera_path = path;
      return;
    }
    scene.camera = first;
    scene.width = width;
    scene.height = height;
  }

  void add_use(int node, int mesh, const Transform& to_world) {
    const double volume = std::abs(to_world.determinant());
    if (!(volume > kLeastVolume && std::isfinite(volume)))
      return import_.warn(document_.at("nodes", node), "a mesh flattened to nothing is left out");
    const GltfModel::Node& n = document_.model().nodes[static_cast<size_t>(node)];
    const bool posed = n.skin >= 0 || !pose_of_node(node).weights.empty();
    uses_[{mesh, posed ? node : -1}].push_back({node, to_world});
    if (++use_count_ > import_.limits.max_instances) {
      document_.root().get("nodes").fail("expected at most " +
                                             std::to_string(import_.limits.max_instances) +
                                             " meshes in their places",
                                         ErrorCode::kTooLarge);
    }
  }

  void add_gpu_instances(const JsonNode& extension, int node, int mesh, const Transform& to_world) {
    const JsonNode attributes = extension.get("attributes");
    std::optional<size_t> count;
    const auto read = [&](const char* key, int components) -> std::optional<GltfAccessor> {
      const auto index = attributes.find(key);
      if (!index) return {};
      const int last = static_cast<int>(document_.model().accessors.size()) - 1;
      if (last < 0) index->fail("expected no index, there are no accessors");
      GltfAccessor accessor(import_, index->integer(0, last), components,
                            import_.limits.max_instances);
      if (count && *count != accessor.count())
        index->fail("expected " + std::to_string(*count) + " elements, as the others have");
      count = accessor.count();
      return accessor;
    };
    const auto translation = read("TRANSLATION", 3), turn = read("ROTATION", 4),
               scale = read("SCALE", 3);
    if (!count) attributes.fail("expected TRANSLATION, ROTATION or SCALE");
    using Quaternion = std::array<float, 4>;
    const auto moves = translation ? translation->read<Vec3>() : std::vector<Vec3>{};
    const auto turns = turn ? turn->read<Quaternion>() : std::vector<Quaternion>{};
    const auto scales = scale ? scale->read<Vec3>() : std::vector<Vec3>{};
    for (size_t i = 0; i < *count; ++i) {
      std::array<double, 4> q{0, 0, 0, 1};
      if (turn) std::copy_n(turns[i].begin(), 4, q.begin());
      add_use(node, mesh,
              to_world.after(
                  placed(translation ? moves[i] : Vec3{}, q, scale ? scales[i] : Vec3{1, 1, 1})));
    }
  }

  // A mesh in one place is put there, one in more is instanced.
  void add_meshes() {
    Scene& scene = import_.out.scene;
    double read = 0;
    for (const auto& [posed, uses] : uses_) {
      told_read(import_.watch, read++ / static_cast<double>(uses_.size()));
      const int index = posed.first;
      const GltfPose pose = pose_of(posed);
      const auto& primitives = document_.model().meshes[static_cast<size_t>(index)].primitives;
      for (size_t p = 0; p < primitives.size(); ++p) {
        const GltfMaterials::Converted& material = materials_.convert(primitives[p].material);
        Mesh mesh = meshes_.read(index, static_cast<int>(p), material, pose);
        if (mesh.triangles.empty()) continue;
        // One that only a picture shapes may be nearly dark, and unlit ones light nothing in glTF.
        const ColorParam& emission = scene.materials[material.id.value].emission;
        has_light_ = has_light_ || (!material.unlit && max_component(emission.value) > 0 &&
                                    !emission.texture.valid());
        const MeshId id(static_cast<uint32_t>(scene.meshes.size()));
        if (uses.size() == 1 && pose.joints.empty()) uses[0].to_world.apply(mesh);
        scene.meshes.push_back(std::move(mesh));
        import_.out.mesh_pointers.push_back("/meshes/" + std::to_string(index) + "/primitives/" +
                                            std::to_string(p));
        if (uses.size() > 1 && pose.joints.empty()) add_instances(id, uses);
      }
    }
  }

  GltfPose pose_of(PosedMesh posed) {
    GltfPose pose;
    pose.weights = document_.model().meshes[static_cast<size_t>(posed.first)].weights;
    if (posed.second < 0) return pose;
    const GltfModel::Node& node = document_.model().nodes[static_cast<size_t>(posed.second)];
    if (auto weights = pose_of_node(posed.second).weights; !weights.empty())
      pose.weights = std::move(weights);
    if (node.skin < 0) return pose;
    if (auto joints = read_gltf_joints(import_, node.skin, to_world_))
      pose.joints = std::move(*joints);
    return pose;
  }

  void add_instances(MeshId mesh, const std::vector<Use>& uses) {
    Scene& scene = import_.out.scene;
    if (scene.instances.size() + uses.size() > import_.limits.max_instances) {
      document_.root().get("nodes").fail(
          "expected at most " + std::to_string(import_.limits.max_instances) + " instances",
          ErrorCode::kTooLarge);
    }
    for (const Use& use : uses) {
      scene.instances.push_back({mesh, use.to_world, {}});
      import_.out.instance_pointers.push_back("/nodes/" + std::to_string(use.node));
    }
  }

  GltfImport& import_;
  GltfDocument& document_;
  GltfMaterials materials_;
  GltfMeshes meshes_;
  std::map<PosedMesh, std::vector<Use>> uses_;
  const GltfMotions motions_;                       // by node
  const std::optional<double> seconds_;             // none: at rest
  std::vector<std::optional<Transform>> to_world_;  // of the nodes that the scene has
  std::vector<bool> moves_;                         // of these: it or one above it
  std::vector<int> parents_;                        // of these; -1: none
  size_t use_count_ = 0, path_steps_ = 0;
  bool has_camera_ = false, has_light_ = false;
};

}  // namespace

void GltfImport::warn(const JsonNode& node, const std::string& text) {
  out.warn(node.place(), text);
}

namespace {

// Extensions that are left out, and the member without which, or with 0 of which, they change
// nothing.
constexpr std::pair<std::string_view, std::string_view> kNeutralExtensions[] = {
    {"KHR_materials_dispersion", "dispersion"},
};

bool says_nothing(const std::string& name, const JsonNode& extension) {
  for (const auto& [neutral, member] : kNeutralExtensions) {
    if (name != neutral) continue;
    const auto value = extension.find(member);
    return !value || value->number() == 0;
  }
  return false;
}

}  // namespace

void GltfImport::expect_extensions(const JsonNode& node,
                                   std::initializer_list<std::string_view> known) {
  const std::optional<JsonNode> extensions = node.find("extensions");
  if (!extensions) return;
  for (const std::string& key : extensions->keys())
    if (std::find(known.begin(), known.end(), key) == known.end() &&
        !says_nothing(key, extensions->get(key)))
      warn(extensions->get(key), "the extension " + key + " is left out");
}

std::optional<JsonNode> find_extension(const JsonNode& node, std::string_view name) {
  const std::optional<JsonNode> extensions = node.find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

ImportedScene read_gltf_scene(const std::filesystem::path& path, const SceneLimits& limits,
                              const LoadWatch& watch, std::optional<double> seconds) {
  GltfDocument document(path);
  GltfImport import{document, limits, watch, {}};
  GltfReader(import, seconds).read();
  return std::move(import.out);
}

}  // namespace qray
