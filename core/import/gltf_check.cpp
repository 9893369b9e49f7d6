#include <algorithm>
#include <climits>

#include "core/import/gltf_document.h"

namespace qray {
namespace {

// A file may require these. The others are read where they are, or warned of.
constexpr std::string_view kKnownExtensions[] = {
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
};

constexpr size_t kMaxItems = 250'000;  // of a list, and primitives of all meshes: 600 bytes each

class Checker {
 public:
  explicit Checker(const JsonNode& root) : root_(root) {}

  void check() {
    const JsonNode version = root_.get("asset").get("version");
    if (!version.string().starts_with("2.")) version.fail_expected("a version 2.x");
    check_required();
    for (const char* list :
         {"accessors", "bufferViews", "buffers", "cameras", "images", "materials", "meshes",
          "nodes", "samplers", "scenes", "skins", "textures"}) {
      if (count(list) > kMaxItems) fail_too_many(list);
    }
    check_index(root_, "scene", "scenes");
    each(root_, "bufferViews", [this](const JsonNode& node) { check_view(node); });
    each(root_, "accessors", [this](const JsonNode& node) { check_accessor(node); });
    each(root_, "meshes", [this](const JsonNode& mesh) {
      check_text(mesh);
      if (mesh.get("primitives").size() == 0) mesh.fail("expected primitives");
      primitive_count_ += mesh.get("primitives").size();
      if (primitive_count_ > kMaxItems) fail_too_many("meshes");
      each(mesh, "primitives", [this](const JsonNode& node) { check_primitive(node); });
    });
    each(root_, "nodes", [this](const JsonNode& node) { check_node(node); });
    each(root_, "scenes", [this](const JsonNode& node) {
      check_text(node);
      check_indices(node, "nodes", "nodes");
    });
    each(root_, "images",
         [this](const JsonNode& node) { check_index(node, "bufferView", "bufferViews"); });
    each(root_, "textures", [this](const JsonNode& node) {
      check_text(node);
      check_index(node, "source", "images");
      check_index(node, "sampler", "samplers");
    });
    each(root_, "samplers", [](const JsonNode& node) {
      check_text(node);
      for (const char* key : {"magFilter", "minFilter"})
        if (const auto v = node.find(key)) v->integer(0, INT_MAX);
      for (const char* key : {"wrapS", "wrapT"})
        if (const auto v = node.find(key)) expect_one_of(*v, {10497, 33071, 33648});
    });
  }

 private:
  template <class F>
  static void each(const JsonNode& parent, const char* list, const F& check) {
    const std::optional<JsonNode> items = parent.find(list);
    for (size_t i = 0; items && i < items->size(); ++i) check(items->at(i));
  }
  size_t count(const char* list) const {
    const std::optional<JsonNode> items = root_.find(list);
    return items ? items->size() : 0;
  }
  static void check_text(const JsonNode& node) {
    if (const auto name = node.find("name")) (void)name->string();
  }
  static void expect_one_of(const JsonNode& node, std::initializer_list<int> known) {
    const int value = node.integer(0, INT_MAX);
    if (std::find(known.begin(), known.end(), value) != known.end()) return;
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

  void check_index_value(const JsonNode& index, const char* list) const {
    const size_t size = count(list);
    if (size == 0) index.fail(std::string("expected no index, there are no ") + list);
    index.integer(0, static_cast<int>(size) - 1);
  }
  void check_index(const JsonNode& node, const char* key, const char* list) const {
    if (const auto index = node.find(key)) check_index_value(*index, list);
  }
  void check_indices(const JsonNode& node, const char* key, const char* list) const {
    each(node, key, [this, list](const JsonNode& index) { check_index_value(index, list); });
  }

  static void check_offset(const JsonNode& node) {
    if (const auto offset = node.find("byteOffset")) offset->integer(0, INT_MAX);
  }

  void check_view(const JsonNode& node) const {
    check_text(node);
    check_index_value(node.get("buffer"), "buffers");
    check_offset(node);
    node.get("byteLength").integer(1, INT_MAX);
    if (const auto stride = node.find("byteStride"))
      if (stride->integer(4, 252) % 4 != 0) stride->fail_expected("a multiple of 4");
    if (const auto target = node.find("target")) target->integer(0, INT_MAX);
  }

  void check_accessor(const JsonNode& node) const {
    check_text(node);
    check_index(node, "bufferView", "bufferViews");
    check_offset(node);
    expect_one_of(node.get("componentType"), {5120, 5121, 5122, 5123, 5125, 5126});
    const int elements = node.get("count").integer(1, INT_MAX);
    const JsonNode type = node.get("type");
    constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                           "MAT2",   "MAT3", "MAT4"};
    if (std::find(std::begin(kTypes), std::end(kTypes), type.string()) == std::end(kTypes))
      type.fail_expected("SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
    if (const auto normalized = node.find("normalized")) normalized->boolean();
    const std::optional<JsonNode> sparse = node.find("sparse");
    if (!sparse) return;
    sparse->get("count").integer(1, elements);
    const JsonNode indices = sparse->get("indices"), values = sparse->get("values");
    check_index_value(indices.get("bufferView"), "bufferViews");
    check_offset(indices);
    expect_one_of(indices.get("componentType"), {5121, 5123, 5125});
    check_index_value(values.get("bufferView"), "bufferViews");
    check_offset(values);
  }

  void check_primitive(const JsonNode& node) const {
    const JsonNode attributes = node.get("attributes");
    for (const std::string& key : attributes.keys())
      check_index_value(attributes.get(key), "accessors");
    check_index(node, "material", "materials");
    if (const auto mode = node.find("mode")) mode->integer(0, 6);
    const std::optional<JsonNode> indices = node.find("indices");
    if (!indices) return;
    check_index_value(*indices, "accessors");
    const auto index = static_cast<size_t>(indices->integer(0, INT_MAX));
    if (!root_.get("accessors").at(index).has("bufferView"))
      indices->fail("expected an accessor with a bufferView");
  }

  void check_node(const JsonNode& node) const {
    check_text(node);
    check_index(node, "mesh", "meshes");
    check_index(node, "camera", "cameras");
    check_index(node, "skin", "skins");
    check_indices(node, "children", "nodes");
    const struct {
      const char* key;
      size_t count;
    } arrays[] = {{"matrix", 16}, {"translation", 3}, {"rotation", 4}, {"scale", 3}};
    for (const auto& array : arrays)
      if (const auto numbers = node.find(array.key)) (void)numbers->numbers(array.count, 1e9f);
  }

  void fail_too_many(const char* list) const {
    root_.get(list).fail("expected at most " + std::to_string(kMaxItems), ErrorCode::kTooLarge);
  }

  const JsonNode& root_;
  size_t primitive_count_ = 0;
};

}  // namespace

void check_gltf(const JsonNode& root) { Checker(root).check(); }

}  // namespace qray
