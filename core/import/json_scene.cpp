#include "core/import/json_scene.h"

#include "core/base/file.h"
#include "core/image/image_io.h"
#include "core/import/json_motion.h"
#include "core/import/obj.h"
#include "core/import/ply.h"
#include "core/import/scene_folder.h"

namespace qray {
namespace {

constexpr uint64_t kMaxSceneFileBytes = uint64_t{16} << 20;  // its tree takes twenty times that

template <class Id>
using Names = std::map<std::string, Id, std::less<>>;

class JsonReader {
 public:
  JsonReader(const std::filesystem::path& path, const SceneLimits& limits, const LoadWatch& watch,
             std::optional<double> seconds)
      : folder_(scene_folder(path)), limits_(limits), watch_(watch), seconds_(seconds) {}

  ImportedScene read(const JsonNode& root) {
    root.only({"name", "size", "max_depth", "camera", "cameras", "textures", "materials",
               "environment", "lights", "meshes", "instances"});
    Scene& scene = out_.scene;
    if (const auto name = root.find("name")) scene.name = name->string();
    if (const auto size = root.find("size")) {
      if (!size->is_array() || size->size() != 2) size->fail_expected("[width, height]");
      scene.width = size->at(0).integer(1, limits_.max_dimension_px);
      scene.height = size->at(1).integer(1, limits_.max_dimension_px);
    }
    if (const auto depth = root.find("max_depth")) scene.max_depth = depth->integer(1, 128);
    const JsonNode camera = root.get("camera");
    scene.camera = read_camera(camera);
    scene.camera_path = read_path(camera, scene.camera);
    if (const auto cameras = root.find("cameras"))
      for (const std::string& own : cameras->keys()) add_camera(own, cameras->get(own));
    if (const auto textures = root.find("textures")) read_textures(*textures);
    read_materials(root.get("materials"));
    if (const auto environment = root.find("environment")) read_environment(*environment);
    if (const auto lights = root.find("lights")) {
      for (size_t i = 0; i < lights->size(); ++i) add_light(lights->at(i));
    }
    read_meshes(root.get("meshes"));
    if (const auto instances = root.find("instances")) read_instances(*instances);
    return std::move(out_);
  }

 private:
  void add_camera(const std::string& name, const JsonNode& node) {
    if (name.empty()) node.fail("expected a name, got an empty string");
    const Camera camera = read_camera(node);
    out_.scene.add_camera(name, camera, read_path(node, camera));
  }

  // Null: it never moves.
  std::shared_ptr<const CameraPath> read_path(const JsonNode& node, const Camera& camera) {
    const std::optional<JsonMotion> motion = JsonMotion::read(node);
    if (!motion) return nullptr;
    moves_until(motion->end());
    return motion->path_of(camera);
  }

  // By what the node's mesh, instance or light is moved; none: it is as at rest.
  std::optional<Transform> read_moved(const JsonNode& node) {
    const std::optional<JsonMotion> motion = JsonMotion::read(node);
    if (!motion) return std::nullopt;
    moves_until(motion->end());
    out_.scene.moves_surfaces = true;
    if (!seconds_) return std::nullopt;
    return motion->at(*seconds_);
  }
  void moves_until(double end) {
    out_.scene.motion_seconds = std::max(out_.scene.motion_seconds, end);
  }

  void add_light(const JsonNode& node) {
    PunctualLight light = read_light(node);
    if (const auto moved = read_moved(node)) place_light(*moved, light);
    out_.scene.lights.push_back(std::move(light));
  }

  static Camera read_camera(const JsonNode& node) {
    Camera camera;
    if (const auto v = node.find("projection")) {
      const std::optional<Projection> named = projection_named(v->string());
      if (!named) v->fail_expected("perspective, orthographic or equirectangular");
      camera.projection = *named;
    }
    std::vector<std::string_view> members = {"projection", "position", "target",
                                             "up",         "mirrored", "motion"};
    if (camera.projection != Projection::kEquirectangular) {
      members.push_back("aperture_radius");
      members.push_back("focus_distance");
      members.push_back("shift");
    }
    if (camera.projection == Projection::kPerspective) {
      members.push_back("vertical_fov_deg");
      camera.vertical_fov_deg = node.get("vertical_fov_deg").number();
    }
    if (camera.projection == Projection::kOrthographic) {
      members.push_back("height");
      camera.height = node.get("height").number();
      if (!(camera.height > 0)) node.get("height").fail_expected("a length over 0");
    }
    node.only(members);
    camera.position = node.get("position").vec3();
    camera.target = node.get("target").vec3();
    if (const auto v = node.find("up")) camera.up = v->vec3();
    if (const auto v = node.find("aperture_radius")) camera.aperture_radius = v->number();
    if (const auto v = node.find("focus_distance")) camera.focus_distance = v->number();
    if (const auto v = node.find("mirrored")) camera.mirrored = v->boolean();
    if (const auto v = node.find("shift")) {
      const std::vector<float> shift = v->numbers(2);
      camera.shift = {shift[0], shift[1]};
    }
    return camera;
  }

  // A file beside the scene's; it must be there.
  std::filesystem::path resolve(const JsonNode& node) const {
    const Result<std::filesystem::path> path = find_within(folder_, folder_, node.string());
    if (!path.ok()) node.fail(path.error().message, path.error().code);
    return path.value();
  }

  template <class Id>
  void add_name(const JsonNode& node, Names<Id>& names, size_t index) {
    if (node.string().empty()) node.fail("expected a name, got an empty string");
    if (!names.emplace(node.string(), Id(static_cast<uint32_t>(index))).second)
      node.fail("\"" + node.string() + "\" is taken, expected a name of its own");
  }

  static TextureWrap wrap(const JsonNode& node) {
    if (node.is_string()) {
      const std::string& name = node.string();
      if (name == "repeat") return TextureWrap::kRepeat;
      if (name == "clamp") return TextureWrap::kClamp;
      if (name == "mirror") return TextureWrap::kMirror;
    }
    node.fail_expected("one of repeat, clamp, mirror");
  }
  // One for both axes, or one of each.
  static void read_wrap(const JsonNode& node, Texture& texture) {
    const bool two = node.is_array() && node.size() == 2;
    texture.wrap_u = wrap(two ? node.at(0) : node);
    texture.wrap_v = wrap(two ? node.at(1) : node);
  }

  void read_textures(const JsonNode& list) {
    for (size_t i = 0; i < list.size(); ++i) {
      const JsonNode node = list.at(i);
      node.only({"name", "path", "srgb", "wrap", "nearest", "uv_transform"});
      add_name(node.get("name"), textures_, i);
      Texture texture;
      texture.path = std::filesystem::absolute(resolve(node.get("path")));
      if (const auto v = node.find("srgb")) texture.srgb = v->boolean();
      if (const auto v = node.find("nearest")) texture.nearest = v->boolean();
      if (const auto v = node.find("wrap")) read_wrap(*v, texture);
      if (const auto v = node.find("uv_transform")) {
        const std::vector<float> m = v->numbers(6);
        texture.uv_transform = {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}};
      }
      out_.scene.textures.push_back(std::move(texture));
    }
  }

  void read_materials(const JsonNode& list) {
    for (size_t i = 0; i < list.size(); ++i) {
      const JsonNode node = list.at(i);
      out_.scene.materials.push_back(read_material(node, textures_, materials_));
      add_name(node.get("name"), materials_, i);
    }
  }

  void read_environment(const JsonNode& node) {
    node.only({"radiance", "image", "rotation_deg", "light_group"});
    Environment& environment = out_.scene.environment;
    environment.light_group = read_light_group(node);
    const auto image = node.find("image");
    if (!image && !node.has("radiance")) node.fail("expected \"radiance\" or \"image\"");
    environment.radiance = Rgb{1.0f};
    if (const auto v = node.find("radiance")) environment.radiance = v->number_or_rgb();
    if (const auto v = node.find("rotation_deg"))
      environment.to_world = Mat3::rotation_y(v->number(-360, 360));
    if (!image) return;
    const std::string extension = std::filesystem::path(image->string()).extension();
    if (extension != ".exr" && extension != ".hdr") image->fail_expected("an .exr or .hdr file");
    environment.image_path = std::filesystem::absolute(resolve(*image));
    const auto max_pixels = static_cast<uint64_t>(limits_.max_pixels);
    Result<Image> pixels = read_image(environment.image_path, max_pixels);
    if (!pixels.ok()) image->fail(pixels.error().message, pixels.error().code);
    environment.image = three_channels(std::move(pixels).value());
  }

  static Image three_channels(Image image) {
    if (image.channels() == 3) return image;
    Image out(image.width(), image.height(), 3);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) out.set_rgb(x, y, image.rgb(x, y));
    return out;
  }

  void read_meshes(const JsonNode& list) {
    for (size_t i = 0; i < list.size(); ++i) {
      told_read(watch_, static_cast<double>(i) / static_cast<double>(list.size()));
      const JsonNode node = list.at(i);
      node.only({"name", "material", "positions", "triangles", "quads", "normals", "uvs", "colors",
                 "file", "quad", "box", "sphere", "cylinder", "disk", "transform", "motion",
                 "flip"});
      const size_t first = out_.scene.meshes.size();
      Mesh mesh = read_shape(node, limits_);
      if (const auto name = node.find("name")) mesh.name = name->string();
      const std::string pointer = "/meshes/" + std::to_string(i);
      if (const auto file = node.find("file"))
        read_file_mesh(node, *file, mesh.name, pointer);
      else
        add_mesh(std::move(mesh), material_id(node.get("material")), pointer, node);
      if (const auto moved = read_moved(node))
        for (size_t m = first; m < out_.scene.meshes.size(); ++m)
          moved->apply(out_.scene.meshes[m]);
      if (const auto name = node.find("name")) {
        MeshRange& named = named_meshes_[name->string()];
        named = {first, out_.scene.meshes.size(), named.used + 1};
      }
    }
  }

  // A mesh of the document is several of the scene's where its file holds several.
  void read_instances(const JsonNode& list) {
    for (size_t i = 0; i < list.size(); ++i) {
      const JsonNode node = list.at(i);
      node.only({"mesh", "material", "transform", "motion"});
      const JsonNode name = node.get("mesh");
      const auto named = named_meshes_.find(name.string());
      if (named == named_meshes_.end() || named->second.used != 1)
        name.fail_expected("the name of one mesh");
      Instance instance;
      instance.to_world = read_placement(node);
      if (const auto moved = read_moved(node)) instance.to_world = moved->after(instance.to_world);
      if (const auto material = node.find("material")) instance.material = material_id(*material);
      for (size_t m = named->second.begin; m < named->second.end; ++m) {
        instance.mesh = MeshId(static_cast<uint32_t>(m));
        out_.scene.instances.push_back(instance);
        out_.instance_pointers.push_back("/instances/" + std::to_string(i));
      }
      if (out_.scene.instances.size() > limits_.max_instances) {
        list.fail("expected at most " + std::to_string(limits_.max_instances) + " instances",
                  ErrorCode::kTooLarge);
      }
    }
  }

  MaterialId material_id(const JsonNode& name) const {
    const auto it = materials_.find(name.string());
    if (it == materials_.end()) name.fail_expected("the name of a material");
    return it->second;
  }

  void add_mesh(Mesh mesh, MaterialId material, const std::string& pointer, const JsonNode& node) {
    triangle_count_ += mesh.triangles.size();
    if (triangle_count_ > limits_.max_triangles) {
      node.fail("expected at most " + std::to_string(limits_.max_triangles) + " triangles",
                ErrorCode::kTooLarge);
    }
    mesh.material = material;
    out_.scene.meshes.push_back(std::move(mesh));
    out_.mesh_pointers.push_back(pointer);
  }

  void read_file_mesh(const JsonNode& node, const JsonNode& file, const std::string& name,
                      const std::string& pointer) {
    const std::string extension = std::filesystem::path(file.string()).extension();
    if (extension != ".obj" && extension != ".ply") file.fail_expected("an .obj or .ply file");
    const std::filesystem::path path = resolve(file);
    const auto material = node.find("material");
    if (extension == ".ply") {
      Mesh mesh = read_ply(path, limits_);
      mesh.name = name;
      apply_placement(node, mesh);
      return add_mesh(std::move(mesh), material_id(node.get("material")), pointer, node);
    }
    ObjContents contents = read_obj(path, limits_);
    Scene& scene = out_.scene;
    const auto first_material = static_cast<uint32_t>(scene.materials.size());
    const auto first_texture = static_cast<uint32_t>(scene.textures.size());
    const MaterialId one = material ? material_id(*material) : MaterialId{};
    for (Mesh& mesh : contents.meshes) {
      mesh.name = name + "/" + mesh.name;
      apply_placement(node, mesh);
      const MaterialId own(first_material + mesh.material.value);
      add_mesh(std::move(mesh), material ? one : own, pointer, node);
    }
    out_.warnings.insert(out_.warnings.end(), contents.warnings.begin(), contents.warnings.end());
    if (material) return;  // one of the document's, for all of it
    for (Material& m : contents.materials) {
      if (m.reflectance.texture.valid()) m.reflectance.texture.value += first_texture;
      scene.materials.push_back(std::move(m));
    }
    for (Texture& texture : contents.textures) scene.textures.push_back(std::move(texture));
  }

  std::filesystem::path folder_;
  const SceneLimits& limits_;
  const LoadWatch& watch_;
  const std::optional<double> seconds_;  // none: at rest
  ImportedScene out_;
  Names<TextureId> textures_;
  Names<MaterialId> materials_;
  struct MeshRange {
    size_t begin = 0, end = 0;  // in scene.meshes
    int used = 0;               // so many meshes have the name
  };
  std::map<std::string, MeshRange, std::less<>> named_meshes_;
  size_t triangle_count_ = 0;
};

}  // namespace

ImportedScene read_json_scene(const std::filesystem::path& path, const SceneLimits& limits,
                              const LoadWatch& watch, std::optional<double> seconds) {
  const Result<Bytes> text = read_file(path, kMaxSceneFileBytes);
  if (!text.ok()) throw ImportFailure{text.error()};
  const std::string file = path.filename();
  const JsonValue tree = parse_json(text.value(), file);
  return JsonReader(path, limits, watch, seconds).read(JsonNode(tree, file + ":"));
}

}  // namespace qray
