#include "core/import/gltf_model.h"

#include <algorithm>
#include <climits>

namespace qray {
namespace {

// A file may require these. The others are read where they are, or warned of.
constexpr std::string_view kKnownExtensions[] = {
    "EXT_mesh_gpu_instancing",    "EXT_meshopt_compression",
    "EXT_texture_webp",           "KHR_draco_mesh_compression",
    "KHR_lights_punctual",        "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",    "KHR_materials_emissive_strength",
    "KHR_materials_ior",          "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",        "KHR_materials_specular",
    "KHR_materials_transmission", "KHR_materials_unlit",
    "KHR_materials_variants",     "KHR_materials_volume",
    "KHR_mesh_quantization",      "KHR_texture_transform",
};

constexpr size_t kMaxItems = 250'000;  // of a list, and primitives of all meshes

class ModelReader {
 public:
  explicit ModelReader(const JsonNode& root) : root_(root) {}

  GltfModel read() {
    const JsonNode version = root_.get("asset").get("version");
    if (!version.string().starts_with("2.")) version.fail_expected("a version 2.x");
    check_required();
    for (const char* list :
         {"accessors", "animations", "bufferViews", "buffers", "cameras", "images", "materials",
          "meshes", "nodes", "samplers", "scenes", "skins", "textures"}) {
      if (count(list) > kMaxItems) fail_too_many(list);
    }
    GltfModel model;
    model.scene = index(root_, "scene", "scenes");
    each(root_, "bufferViews", [&](const JsonNode& v) { model.views.push_back(view(v)); });
    each(root_, "accessors", [&](const JsonNode& v) { model.accessors.push_back(accessor(v)); });
    each(root_, "meshes", [&](const JsonNode& v) { model.meshes.push_back(mesh(v)); });
    each(root_, "skins", [&](const JsonNode& v) { model.skins.push_back(skin(v)); });
    each(root_, "nodes", [&](const JsonNode& v) { model.nodes.push_back(node(v)); });
    each(root_, "scenes",
         [&](const JsonNode& v) { model.scenes.push_back(indices(v, "nodes", "nodes")); });
    each_or_broken("animations", model.animations, [&](const JsonNode& v) { return channels(v); });
    each_or_broken("images", model.images, [&](const JsonNode& v) {
      return GltfModel::Image{index(v, "bufferView", "bufferViews")};
    });
    each_or_broken("textures", model.textures, [&](const JsonNode& v) {
      return GltfModel::Texture{index(v, "source", "images"), index(v, "sampler", "samplers")};
    });
    each_or_broken("samplers", model.samplers, sampler);
    return model;
  }

 private:
  template <class F>
  static void each(const JsonNode& parent, const char* list, const F& read) {
    const std::optional<JsonNode> items = parent.find(list);
    for (size_t i = 0; items && i < items->size(); ++i) read(items->at(i));
  }
  template <class T, class F>
  void each_or_broken(const char* list, GltfList<T>& out, const F& read) const {
    each(root_, list, [&](const JsonNode& node) {
      try {
        out.push_back(read(node));
      } catch (ImportFailure& failure) {
        out.push_back_broken(std::move(failure.error));
      }
    });
  }
  size_t count(const char* list) const {
    const std::optional<JsonNode> items = root_.find(list);
    return items ? items->size() : 0;
  }
  static int one_of(const JsonNode& node, std::initializer_list<int> known) {
    const int value = node.integer(0, INT_MAX);
    if (std::find(known.begin(), known.end(), value) != known.end()) return value;
    std::string text;
    for (const int v : known) text += (text.empty() ? "one of " : ", ") + std::to_string(v);
    node.fail_expected(text);
  }

  void check_required() const {
    each(root_, "extensionsRequired", [](const JsonNode& name) {
      const auto* end = std::end(kKnownExtensions);
      if (std::find(std::begin(kKnownExtensions), end, name.string()) == end) {
        name.fail("the file requires the extension " + name.string() + ", which is not read",
                  ErrorCode::kUnsupported);
      }
    });
  }

  int index_value(const JsonNode& node, const char* list) const {
    const size_t size = count(list);
    if (size == 0) node.fail(std::string("expected no index, there are no ") + list);
    return node.integer(0, static_cast<int>(size) - 1);
  }
  int index(const JsonNode& parent, const char* key, const char* list) const {
    const std::optional<JsonNode> node = parent.find(key);
    return node ? index_value(*node, list) : -1;
  }
  std::vector<int> indices(const JsonNode& parent, const char* key, const char* list) const {
    std::vector<int> out;
    each(parent, key, [&](const JsonNode& node) { out.push_back(index_value(node, list)); });
    return out;
  }

  static size_t offset(const JsonNode& node) {
    const std::optional<JsonNode> offset = node.find("byteOffset");
    return offset ? static_cast<size_t>(offset->integer(0, INT_MAX)) : 0;
  }

  GltfModel::View view(const JsonNode& node) const {
    GltfModel::View out;
    out.buffer = index_value(node.get("buffer"), "buffers");
    out.byte_offset = offset(node);
    out.byte_length = static_cast<size_t>(node.get("byteLength").integer(1, INT_MAX));
    if (const auto stride = node.find("byteStride")) {
      out.byte_stride = static_cast<size_t>(stride->integer(4, 252));
      if (out.byte_stride % 4 != 0) stride->fail_expected("a multiple of 4");
    }
    return out;
  }

  GltfModel::Accessor accessor(const JsonNode& node) const {
    GltfModel::Accessor out;
    out.elements.view = index(node, "bufferView", "bufferViews");
    out.elements.byte_offset = offset(node);
    out.elements.component_type =
        one_of(node.get("componentType"), {5120, 5121, 5122, 5123, 5125, 5126});
    const int elements = node.get("count").integer(1, INT_MAX);
    out.count = static_cast<size_t>(elements);
    const JsonNode type = node.get("type");
    const std::map<std::string_view, int> types = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3},
                                                   {"VEC4", 4},   {"MAT2", 0}, {"MAT3", 0},
                                                   {"MAT4", 16}};
    const auto known = types.find(type.string());
    if (known == types.end()) type.fail_expected("SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
    out.components = known->second;
    if (const auto normalized = node.find("normalized")) out.normalized = normalized->boolean();
    const std::optional<JsonNode> sparse = node.find("sparse");
    if (!sparse) return out;
    out.sparse_count = static_cast<size_t>(sparse->get("count").integer(1, elements));
    const JsonNode at = sparse->get("indices"), values = sparse->get("values");
    out.sparse_indices = {index_value(at.get("bufferView"), "bufferViews"), offset(at),
                          one_of(at.get("componentType"), {5121, 5123, 5125})};
    out.sparse_values = {index_value(values.get("bufferView"), "bufferViews"), offset(values),
                         out.elements.component_type};
    return out;
  }

  GltfModel::Mesh mesh(const JsonNode& node) {
    GltfModel::Mesh out;
    if (const auto name = node.find("name")) out.name = name->string();
    if (node.get("primitives").size() == 0) node.fail("expected primitives");
    primitive_count_ += node.get("primitives").size();
    if (primitive_count_ > kMaxItems) fail_too_many("meshes");
    each(node, "primitives", [&](const JsonNode& v) { out.primitives.push_back(primitive(v)); });
    if (const auto weights = node.find("weights")) out.weights = weights_of(*weights);
    return out;
  }

  GltfModel::Primitive primitive(const JsonNode& node) const {
    GltfModel::Primitive out;
    const auto accessors = [this](const JsonNode& attributes) {
      std::map<std::string, int> found;
      for (const std::string& key : attributes.keys())
        found[key] = index_value(attributes.get(key), "accessors");
      return found;
    };
    out.attributes = accessors(node.get("attributes"));
    each(node, "targets", [&](const JsonNode& v) { out.targets.push_back(accessors(v)); });
    out.material = index(node, "material", "materials");
    if (const auto mode = node.find("mode")) out.mode = mode->integer(0, 6);
    out.indices = index(node, "indices", "accessors");
    const auto extensions = node.find("extensions");
    const bool packed = extensions && extensions->has("KHR_draco_mesh_compression");
    if (out.indices >= 0 && !packed &&
        !root_.get("accessors").at(static_cast<size_t>(out.indices)).has("bufferView"))
      node.get("indices").fail("expected an accessor with a bufferView");
    return out;
  }

  static std::vector<double> weights_of(const JsonNode& node) {
    return node.doubles(node.size(), 1e9f);
  }

  GltfModel::Skin skin(const JsonNode& node) const {
    GltfModel::Skin out;
    out.joints = indices(node, "joints", "nodes");
    out.inverse_matrices = index(node, "inverseBindMatrices", "accessors");
    if (out.joints.empty()) node.fail("expected joints");
    return out;
  }

  GltfModel::Node node(const JsonNode& node) const {
    GltfModel::Node out;
    out.mesh = index(node, "mesh", "meshes");
    out.skin = index(node, "skin", "skins");
    NodePose& rest = out.rest;
    if (const auto weights = node.find("weights")) rest.weights = weights_of(*weights);
    out.camera = index(node, "camera", "cameras");
    out.children = indices(node, "children", "nodes");
    const struct {
      const char* key;
      size_t count;
      std::vector<double>& numbers;
    } arrays[] = {{"matrix", 16, rest.matrix},
                  {"translation", 3, rest.translation},
                  {"rotation", 4, rest.rotation},
                  {"scale", 3, rest.scale}};
    for (const auto& array : arrays)
      if (const auto numbers = node.find(array.key))
        array.numbers = numbers->doubles(array.count, 1e9f);
    return out;
  }

  // Those that name a node.
  std::vector<GltfModel::Channel> channels(const JsonNode& animation) {
    using Between = Track::Between;
    const std::map<std::string_view, Between> ways = {
        {"LINEAR", Between::kLinear}, {"STEP", Between::kStep}, {"CUBICSPLINE", Between::kCubic}};
    const JsonNode samplers = animation.get("samplers");
    std::vector<GltfModel::Channel> out;
    each(animation, "channels", [&](const JsonNode& node) {
      if (++channel_count_ > kMaxItems) fail_too_many("animations");
      const JsonNode target = node.get("target");
      GltfModel::Channel channel;
      channel.node = index(target, "node", "nodes");
      channel.path = target.get("path").string();
      const JsonNode which = node.get("sampler");
      if (samplers.size() == 0) which.fail("expected no index, there are no samplers");
      const JsonNode sampler =
          samplers.at(static_cast<size_t>(which.integer(0, static_cast<int>(samplers.size()) - 1)));
      channel.input = index_value(sampler.get("input"), "accessors");
      channel.output = index_value(sampler.get("output"), "accessors");
      if (const auto way = sampler.find("interpolation")) {
        const auto known = ways.find(way->string());
        if (known == ways.end()) way->fail_expected("LINEAR, STEP or CUBICSPLINE");
        channel.between = known->second;
      }
      if (channel.node >= 0) out.push_back(std::move(channel));
    });
    return out;
  }

  static GltfModel::Sampler sampler(const JsonNode& node) {
    GltfModel::Sampler out;
    if (const auto v = node.find("magFilter")) out.mag_filter = v->integer(0, INT_MAX);
    if (const auto v = node.find("wrapS")) out.wrap_s = one_of(*v, {10497, 33071, 33648});
    if (const auto v = node.find("wrapT")) out.wrap_t = one_of(*v, {10497, 33071, 33648});
    return out;
  }

  void fail_too_many(const char* list) const {
    root_.get(list).fail("expected at most " + std::to_string(kMaxItems), ErrorCode::kTooLarge);
  }

  const JsonNode& root_;
  size_t primitive_count_ = 0, channel_count_ = 0;
};

}  // namespace

GltfModel read_gltf_model(const JsonNode& root) { return ModelReader(root).read(); }

}  // namespace qray
