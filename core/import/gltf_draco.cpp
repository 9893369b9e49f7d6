#include "core/import/gltf_draco.h"

#include <draco/compression/decode.h>

namespace qray {
namespace {

Bytes as_bytes(const auto& values) {
  Bytes out(values.size() * sizeof(values[0]));
  if (!out.empty()) std::memcpy(out.data(), values.data(), out.size());
  return out;
}

float greatest(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 127;
    case draco::DT_UINT8:
      return 255;
    case draco::DT_INT16:
      return 32767;
    case draco::DT_UINT16:
      return 65535;
    default:
      return 1;
  }
}

// All points' values as floats: the accessor says what they mean, Draco how they are stored.
std::vector<float> values_of(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                             const GltfModel::Accessor& accessor) {
  const auto components = static_cast<size_t>(accessor.components);
  std::vector<float> out(components * mesh.num_points());
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    attribute.ConvertValue<float>(attribute.mapped_index(draco::PointIndex(i)),
                                  static_cast<int8_t>(components), &out[i * components]);
  }
  if (accessor.normalized && !attribute.normalized())
    for (float& v : out) v = std::max(v / greatest(attribute.data_type()), -1.0f);
  return out;
}

}  // namespace

GltfUnpacked unpack_draco(const JsonNode& extension, const GltfModel::Primitive& primitive,
                          GltfDocument& document) {
  const GltfModel& model = document.model();
  const JsonNode view = extension.get("bufferView");
  if (model.views.empty()) view.fail("expected no index, there are no bufferViews");
  const std::span<const uint8_t> packed =
      document.view_bytes(view.integer(0, static_cast<int>(model.views.size()) - 1));
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(packed.data()), packed.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    extension.fail(std::string("Draco's bytes are damaged: ") + decoded.status().error_msg());
  }
  const draco::Mesh& mesh = *decoded.value();

  GltfUnpacked out;
  std::vector<uint32_t> indices;
  indices.reserve(3 * static_cast<size_t>(mesh.num_faces()));
  for (uint32_t f = 0; f < mesh.num_faces(); ++f)
    for (const draco::PointIndex& point : mesh.face(draco::FaceIndex(f)))
      indices.push_back(point.value());
  if (indices.empty()) extension.fail("expected triangles in Draco's bytes");
  out.indices = {{document.add_view(extension, as_bytes(indices)), 0, kGltfUnsignedInt},
                 1,
                 indices.size(),
                 false,
                 0,
                 {},
                 {}};

  const JsonNode attributes = extension.get("attributes");
  for (const std::string& key : attributes.keys()) {
    const auto declared = primitive.attributes.find(key);
    const JsonNode id = attributes.get(key);
    if (declared == primitive.attributes.end())
      id.fail("expected an attribute that the primitive has too");
    const draco::PointAttribute* attribute =
        mesh.GetAttributeByUniqueId(static_cast<uint32_t>(id.integer(0, 1 << 30)));
    if (!attribute) id.fail("there is no such attribute in Draco's bytes");
    GltfModel::Accessor accessor = model.accessors[static_cast<size_t>(declared->second)];
    if (accessor.components != attribute->num_components())
      id.fail("expected " + std::to_string(accessor.components) +
              " components, as the accessor "
              "has, got " +
              std::to_string(attribute->num_components()) + " in Draco's bytes");
    if (accessor.components < 1 || accessor.components > 4) continue;
    const std::vector<float> values = values_of(mesh, *attribute, accessor);
    accessor.elements = {document.add_view(extension, as_bytes(values)), 0, kGltfFloat};
    accessor.count = mesh.num_points();
    accessor.normalized = false;
    accessor.sparse_count = 0;
    out.attributes.emplace(key, accessor);
  }
  return out;
}

}  // namespace qray
