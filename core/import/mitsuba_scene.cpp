#include "core/import/mitsuba_scene.h"

#include <algorithm>
#include <utility>

#include "core/import/mitsuba_emitter.h"
#include "core/import/mitsuba_material.h"
#include "core/import/mitsuba_sensor.h"
#include "core/import/mitsuba_shape.h"

namespace qray {
namespace {

constexpr int kMaxShapeDepth = 8;  // of groups in groups
constexpr size_t kMaxInstances = 1'000'000;

// What a <shape> consists of beside its geometry. Shapes of the same parts share a material.
struct ShapeParts {
  const MitsubaNode* bsdf = nullptr;
  const MitsubaNode* emitter = nullptr;
  const MitsubaNode* medium = nullptr;  // inside
  auto operator<=>(const ShapeParts&) const = default;
};

struct ShapeMaterial {
  MaterialId id;
  bool inside_out, vertex_colors;
};

class MitsubaReader {
 public:
  explicit MitsubaReader(MitsubaImport& import)
      : import_(import), shapes_(import), materials_(import) {}

  void read() {
    for (const auto& [where, tag] : import_.document.skipped)
      import_.out.warn(where, "<" + tag + "> is no element of Mitsuba and is left out");
    const MitsubaNode* sensor = nullptr;
    import_.out.scene.max_depth = 128;  // as long as it takes
    const std::vector<MitsubaNode>& parts = import_.document.root.children;
    for (const MitsubaNode& child : parts) {
      told_read(import_.watch,
                static_cast<double>(&child - parts.data()) / static_cast<double>(parts.size()));
      const MitsubaNode& node = import_.document.resolve(child);
      if (node.tag == "shape") {
        read_shape(node);
      } else if (node.tag == "emitter") {
        read_emitter(node, import_);
      } else if (node.tag == "integrator") {
        read_integrator(node, import_);
      } else if (node.tag == "sensor") {
        add_sensor(node, /*first=*/!sensor);
        sensor = &node;
      } else if (node.tag != "bsdf" && node.tag != "texture" && node.tag != "medium" &&
                 node.tag != "film" && node.tag != "sampler" && node.tag != "mode" &&
                 !is_color(node) && node.tag != "string" && node.tag != "boolean" &&
                 node.tag != "integer" && node.tag != "phase") {
        import_.warn(node, "<" + node.tag + "> is left out");
      }
    }
    if (!sensor) import_.document.root.fail("expected a <sensor>");
    if (import_.out.scene.meshes.empty()) import_.document.root.fail("expected a <shape>");
  }

 private:
  // The first is the view, and says what the picture's size is; all can be asked for by name.
  void add_sensor(const MitsubaNode& node, bool first) {
    Scene& scene = import_.out.scene;
    const Camera view = std::exchange(scene.camera, Camera());
    const int width = scene.width, height = scene.height;
    read_sensor(node, import_);
    scene.add_camera(node.id, scene.camera);
    if (first) return;
    scene.camera = view;
    scene.width = width;
    scene.height = height;
  }

  ShapeParts find_parts(const MitsubaNode& shape) {
    ShapeParts parts;
    for (const MitsubaNode& child : shape.children) {
      const MitsubaNode& node = import_.document.resolve(child);
      if (node.tag == "bsdf") {
        parts.bsdf = &node;
      } else if (node.tag == "emitter" || node.tag == "luminaire") {
        if (node.type == "area")
          parts.emitter = &node;
        else
          import_.warn(node, "emitters of type \"" + node.type + "\" on a shape are left out");
      } else if (node.tag == "medium") {
        if (child.name != "exterior")
          parts.medium = &node;
        else
          import_.warn(node, "media outside of shapes are left out");
      } else if (node.tag == "subsurface" || node.tag == "sensor") {
        import_.warn(node, "<" + node.tag + "> is left out");
      }
    }
    return parts;
  }

  void read_shape(const MitsubaNode& shape) {
    if (shape.type == "instance") return add_instance(shape);
    if (shape.type == "merge") return read_nested(shape);
    if (shape.type != "shapegroup") add_shape(shape);
  }
  void read_nested(const MitsubaNode& parent) {
    if (++depth_ > kMaxShapeDepth) parent.fail("expected shapes of at most 8 levels, no cycles");
    for (const MitsubaNode& child : parent.children) {
      const MitsubaNode& node = import_.document.resolve(child);
      if (node.tag == "shape") read_shape(node);
    }
    --depth_;
  }

  void add_shape(const MitsubaNode& shape) {
    std::vector<Mesh> meshes = shapes_.read(shape, instanced_);
    if (meshes.empty()) return;
    const ShapeMaterial material = material_of(find_parts(shape), shape);
    for (Mesh& mesh : meshes) {
      triangles_ += mesh.triangles.size();
      if (triangles_ > import_.limits.max_triangles) {
        shape.fail(
            "expected at most " + std::to_string(import_.limits.max_triangles) + " triangles",
            ErrorCode::kTooLarge);
      }
      if (material.inside_out) flip_winding(mesh);
      if (!material.vertex_colors) mesh.colors.clear();
      mesh.material = material.id;
      mesh.name = shape.id.empty() ? shape.type + " at " + shape.where : shape.id;
      import_.out.scene.meshes.push_back(std::move(mesh));
      import_.out.mesh_pointers.push_back(shape.where.substr(shape.where.find(':') + 1));
    }
  }

  // The group's meshes are read at its first instance.
  void add_instance(const MitsubaNode& shape) {
    const MitsubaNode* group = nullptr;
    for (const MitsubaNode& child : shape.children) {
      const MitsubaNode& node = import_.document.resolve(child);
      if (node.tag == "shape" && node.type == "shapegroup") group = &node;
    }
    if (!group) shape.fail("expected a <ref> to a shapegroup");
    std::vector<Mesh>& meshes = import_.out.scene.meshes;
    auto it = groups_.find(group);
    if (it == groups_.end()) {
      const size_t first = meshes.size();
      const bool outer = std::exchange(instanced_, true);
      read_nested(*group);
      instanced_ = outer;
      it = groups_.emplace(group, std::pair(first, meshes.size())).first;
    }
    const Transform to_world = find_transform(shape, "to_world").value_or(Transform{});
    for (size_t i = it->second.first; i < it->second.second; ++i) {
      if (import_.out.scene.instances.size() >= kMaxInstances)
        shape.fail("expected at most 1000000 instances", ErrorCode::kTooLarge);
      import_.out.scene.instances.push_back({MeshId(static_cast<uint32_t>(i)), to_world, {}});
    }
  }

  ShapeMaterial material_of(const ShapeParts& parts, const MitsubaNode& shape) {
    if (const auto it = shared_.find(parts); it != shared_.end()) return it->second;
    MitsubaMaterials::Converted made;
    if (parts.bsdf) {
      made = materials_.convert(*parts.bsdf);
    } else {
      made.material.name = "grey";
      made.material.two_sided = false;
      if (parts.emitter) made.material.reflectance.value = Rgb{0.0f};
    }
    if (parts.emitter)
      made.material.emission = materials_.textures().find_color(*parts.emitter, "radiance",
                                                                Rgb{1.0f}, ColorUse::kEmission);
    if (parts.medium) fill(*parts.medium, made.material, shape);
    const ShapeMaterial material{materials_.add(std::move(made.material)), made.inside_out,
                                 made.vertex_colors};
    return shared_.emplace(parts, material).first->second;
  }

  // A medium that only absorbs is what our glass may be filled with.
  void fill(const MitsubaNode& medium, Material& material, const MitsubaNode& shape) {
    if (medium.type != "homogeneous" || material.kind != MaterialKind::kDielectric ||
        find_parameter(medium, "material"))
      return import_.warn(shape, "the medium inside is left out");
    const auto color = [&](const char* name, Rgb fallback) {
      return find_color(medium, name, fallback, ColorUse::kEmission, import_);
    };
    const float scale = static_cast<float>(find_number(medium, "scale").value_or(1));
    Rgb absorbed = color("sigma_a", Rgb{0.0f}), scattered = color("sigma_s", Rgb{0.0f});
    if (find_parameter(medium, "sigma_t")) {
      const Rgb total = color("sigma_t", Rgb{1.0f}), albedo = color("albedo", Rgb{0.75f});
      scattered = total * albedo;
      for (int i = 0; i < 3; ++i) absorbed[i] = std::max(0.0f, total[i] - scattered[i]);
    }
    if (!scattered.is_black())
      import_.warn(shape, "the medium inside only absorbs; what it scatters is left out");
    material.absorption = absorbed * scale;
  }

  MitsubaImport& import_;
  MitsubaShapes shapes_;
  MitsubaMaterials materials_;
  std::map<ShapeParts, ShapeMaterial> shared_;
  std::map<const MitsubaNode*, std::pair<size_t, size_t>> groups_;  // their meshes: from, to
  size_t triangles_ = 0;
  int depth_ = 0;
  bool instanced_ = false;  // the shapes under way are an instance's
};

}  // namespace

void MitsubaImport::warn(const MitsubaNode& node, const std::string& text) {
  out.warn(node.where, text);
}

namespace {

// Parameters that are left out, and the values with which they would change nothing.
struct Neutral {
  std::string_view name;
  double value;
  std::string_view tints = {};  // it says nothing either where this one does not
};
constexpr Neutral kNeutral[] = {
    {"flatness", 0},  {"diff_trans", 0},          {"sheen", 0},   {"shift", 0},
    {"spec_tint", 0}, {"specular_tint", 0},       {"stretch", 1}, {"subsurface", 0},
    {"emission", 0},  {"sheen_tint", 0, "sheen"},
};

bool says_nothing(const MitsubaNode& plugin, std::string_view name) {
  const auto* const known =
      std::find_if(std::begin(kNeutral), std::end(kNeutral),
                   [name](const Neutral& neutral) { return neutral.name == name; });
  if (known == std::end(kNeutral)) return false;
  if (!known->tints.empty() &&
      (!find_parameter(plugin, known->tints) || says_nothing(plugin, known->tints)))
    return true;
  const MitsubaNode* parameter = find_parameter(plugin, name);
  const std::string* text = parameter ? parameter->attribute("value") : nullptr;
  if (!text) return false;
  const std::vector<double> numbers = parse_numbers(*parameter, *text);
  return !numbers.empty() && std::all_of(numbers.begin(), numbers.end(),
                                         [known](double v) { return v == known->value; });
}

}  // namespace

void MitsubaImport::expect_only(const MitsubaNode& plugin,
                                std::initializer_list<std::string_view> known) {
  for (const MitsubaNode& child : plugin.children) {
    const bool is_value = child.tag == "float" || child.tag == "integer" ||
                          child.tag == "boolean" || child.tag == "string" ||
                          child.tag == "texture" || is_color(child);
    if (is_value && std::find(known.begin(), known.end(), child.name) == known.end() &&
        !says_nothing(plugin, child.name))
      warn(child, "\"" + child.name + "\" of " + plugin.type + " is left out");
  }
}

ImportedScene read_mitsuba_scene(const std::filesystem::path& path, const SceneLimits& limits,
                                 const LoadWatch& watch) {
  const MitsubaDocument document = read_mitsuba_tree(path);
  MitsubaImport import{document, limits, watch, {}};
  MitsubaReader(import).read();
  return std::move(import.out);
}

}  // namespace qray
