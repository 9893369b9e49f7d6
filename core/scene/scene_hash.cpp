#include "core/scene/scene_hash.h"

#include <map>

#include "core/base/byte_io.h"
#include "core/base/file.h"

namespace qray {
namespace {

constexpr uint64_t kMaxTextureBytes = uint64_t{1} << 30;

// Explicit little-endian bytes into a digest, a chunk at a time.
class HashWriter {
 public:
  explicit HashWriter(std::string_view domain) { chunk_.string(domain); }

  void u8(uint8_t v) {
    chunk_.u8(v);
    flush_if_full();
  }
  void u32(uint32_t v) {
    chunk_.u32(v);
    flush_if_full();
  }
  void u64(uint64_t v) {
    chunk_.u64(v);
    flush_if_full();
  }
  void f32(float v) {
    chunk_.f32(v == 0 ? 0.0f : v);  // -0 and 0 are the same scene
    flush_if_full();
  }
  void f64(double v) {
    chunk_.f64(v == 0 ? 0.0 : v);
    flush_if_full();
  }
  void rgb(Rgb v) {
    for (int i = 0; i < 3; ++i) f32(v[i]);
  }
  void vec3(Vec3 v) {
    for (int i = 0; i < 3; ++i) f32(v[i]);
  }
  void digest(const Digest& v) { chunk_.bytes(v.bytes); }

  Digest finish() {
    hash_.add(chunk_.data());
    return hash_.finish();
  }

 private:
  void flush_if_full() {
    if (chunk_.size() < (1u << 16)) return;
    hash_.add(chunk_.data());
    chunk_ = {};
  }
  ByteWriter chunk_;
  Sha256 hash_;
};

Digest hash_geometry(const Scene& scene) {
  HashWriter out("qray geometry 2");
  out.u64(scene.meshes.size());
  for (const Mesh& mesh : scene.meshes) {
    out.u32(mesh.material.value);
    out.u64(mesh.positions.size());
    for (const Vec3 p : mesh.positions) out.vec3(p);
    out.u64(mesh.normals.size());
    for (const Vec3 n : mesh.normals) out.vec3(n);
    out.u64(mesh.uvs.size());
    for (const Vec2 uv : mesh.uvs) {
      out.f32(uv.x);
      out.f32(uv.y);
    }
    out.u64(mesh.triangles.size());
    for (const auto& tri : mesh.triangles)
      for (const uint32_t v : tri) out.u32(v);
    for (const Vec2 uv : mesh.second_uvs) {
      out.f32(uv.x);
      out.f32(uv.y);
    }
    if (const auto& sphere = mesh.sphere) {  // others keep the hashes that they had before
      out.vec3(sphere->center);
      out.f32(sphere->radius);
      out.u8(sphere->inward ? 1 : 0);
      for (const Vec3 row : sphere->to_local.rows) out.vec3(row);
    }
  }
  out.u64(scene.instances.size());
  for (const Instance& instance : scene.instances) {
    out.u32(instance.mesh.value);
    out.u32(instance.material.value);
    for (const auto& row : instance.to_world.rows)
      for (const double v : row) out.f64(v);
  }
  return out.finish();
}

// A texture counts by its content and its meaning, whatever its path or index. Many may show one
// picture.
Result<std::vector<Digest>> hash_textures(const Scene& scene) {
  std::vector<Digest> digests;
  std::map<std::pair<std::filesystem::path, const Bytes*>, Digest> pictures;
  for (const Texture& texture : scene.textures) {
    HashWriter out("qray texture 2");
    const auto [picture, is_new] = pictures.try_emplace({texture.path, texture.bytes.get()});
    if (is_new && texture.bytes) {
      picture->second = sha256(*texture.bytes);
    } else if (is_new) {
      const Result<Bytes> bytes = read_file(texture.path, kMaxTextureBytes);
      if (!bytes.ok()) return bytes.error();
      picture->second = sha256(bytes.value());
    }
    out.digest(picture->second);
    out.u8(texture.srgb ? 1 : 0);
    out.u8(static_cast<uint8_t>(texture.wrap_u));
    out.u8(static_cast<uint8_t>(texture.wrap_v));
    out.u8(texture.nearest ? 1 : 0);
    for (const auto& row : {texture.uv_transform.u, texture.uv_transform.v})
      for (const float v : row) out.f32(v);
    if (texture.second_uvs) out.u8(1);
    digests.push_back(out.finish());
  }
  return digests;
}

// Parameters of materials; textures by what they show.
class MaterialHash {
 public:
  MaterialHash(HashWriter& out, const std::vector<Digest>& textures)
      : out_(out), textures_(textures) {}

  void texture(TextureId id) {
    out_.u8(id.valid() ? 1 : 0);
    if (id.valid()) out_.digest(textures_[id.value]);
  }
  void color(const ColorParam& param) {
    out_.rgb(param.value);
    texture(param.texture);
  }
  void number(const FloatParam& param) {
    out_.f32(param.value);
    texture(param.texture);
    out_.u8(static_cast<uint8_t>(param.channel));
  }

 private:
  HashWriter& out_;
  const std::vector<Digest>& textures_;
};

Digest hash_materials(const Scene& scene, const std::vector<Digest>& textures) {
  HashWriter out("qray materials 3");
  MaterialHash add(out, textures);
  out.u64(scene.materials.size());
  for (const Material& m : scene.materials) {
    out.u8(static_cast<uint8_t>(m.kind));
    add.color(m.reflectance);
    add.number(m.roughness);
    out.u8(static_cast<uint8_t>(m.microfacets));
    out.rgb(m.eta);
    out.rgb(m.k);
    out.f32(m.ior);
    add.color(m.specular);
    add.color(m.transmittance);
    add.color(m.sheen);
    out.rgb(m.absorption);
    for (const FloatParam& param :
         {m.metallic, m.transmission, m.clearcoat, m.clearcoat_roughness, m.sheen_roughness,
          m.specular_weight, m.blend_weight, m.opacity, m.bump_map})
      add.number(param);
    out.u32(m.first.value);
    out.u32(m.second.value);
    out.f32(m.alpha_cutoff);
    add.texture(m.normal_map);
    out.f32(m.normal_scale);
    if (m.anisotropic()) {  // others keep the hashes that they had before
      add.number(m.anisotropy);
      out.f32(m.anisotropy_rad);
      if (m.anisotropy_directions) out.u8(1);
    }
    if (m.diffuse_transmission.value > 0) {
      add.number(m.diffuse_transmission);
      add.color(m.diffuse_transmission_color);
    }
    if (m.iridescence.value > 0) {
      add.number(m.iridescence);
      add.number(m.film_nm);
      out.f32(m.film_least_nm);
      out.f32(m.film_ior);
    }
    if (m.own_coat_normal) {
      add.texture(m.coat_normal_map);
      out.f32(m.coat_normal_scale);
    }
    if (m.disney) out.u8(2);
    for (const bool flag : {m.nonlinear, m.thin, m.two_sided}) out.u8(flag ? 1 : 0);
  }
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    if (scene.meshes[m].colors.empty()) continue;
    out.u64(m);
    out.u64(scene.meshes[m].colors.size());
    for (const Rgb color : scene.meshes[m].colors) out.rgb(color);
  }
  return out.finish();
}

Digest hash_lights(const Scene& scene, const std::vector<Digest>& textures) {
  HashWriter out("qray lights 2");
  MaterialHash add(out, textures);
  out.u64(scene.materials.size());
  for (const Material& m : scene.materials) {
    add.color(m.emission);
    out.u8(m.emission_two_sided ? 1 : 0);
  }
  const Environment& environment = scene.environment;
  out.rgb(environment.radiance);
  for (const Vec3 row : environment.to_world.rows) out.vec3(row);
  out.u32(static_cast<uint32_t>(environment.image.width()));
  out.u32(static_cast<uint32_t>(environment.image.height()));
  for (const float v : environment.image.data()) out.f32(v);
  out.u64(scene.lights.size());
  for (const PunctualLight& light : scene.lights) {
    out.u8(static_cast<uint8_t>(light.kind));
    out.rgb(light.intensity);
    out.vec3(light.position);
    out.vec3(light.direction);
    out.f32(light.inner_rad);
    out.f32(light.outer_rad);
    out.u8(static_cast<uint8_t>(light.falloff));
  }
  return out.finish();
}

}  // namespace

Digest SceneHash::whole() const {
  HashWriter out("qray scene 1");
  for (const Digest* part : {&geometry, &materials, &lights}) out.digest(*part);
  return out.finish();
}

Result<SceneHash> hash_scene(const Scene& scene) {
  const Result<std::vector<Digest>> textures = hash_textures(scene);
  if (!textures.ok()) return textures.error();
  return SceneHash{hash_geometry(scene), hash_materials(scene, textures.value()),
                   hash_lights(scene, textures.value())};
}

Result<SceneHash> hash_other_lights(const Scene& scene, SceneHash hash) {
  const Result<std::vector<Digest>> textures = hash_textures(scene);
  if (!textures.ok()) return textures.error();
  hash.lights = hash_lights(scene, textures.value());
  return hash;
}

}  // namespace qray
