#include "core/render/prepared_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "core/math/hash.h"
#include "core/render/caustic_map.h"

namespace qray {

namespace {

float largest_coordinate(const Bounds3& box) {
  float largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(box.lo[axis]), std::abs(box.hi[axis])});
  return largest;
}

// A few units in the last place of the largest coordinate: what a hit on the largest triangle can
// be off by. An instance is hit in its mesh's space, whose coordinates may be larger.
float ray_epsilon(const PreparedScene& prepared) {
  float largest = largest_coordinate(prepared.bounds);
  const Scene& scene = prepared.scene;
  std::vector<float> of_mesh(scene.instances.empty() ? 0 : scene.meshes.size(), 0.0f);
  for (size_t m = 0; m < of_mesh.size(); ++m) {
    Bounds3 box;
    for (const Vec3 p : scene.meshes[m].positions) box.add(p);
    of_mesh[m] = largest_coordinate(box);
  }
  for (const Instance& instance : scene.instances) {
    double stretch = 0;
    for (const auto& row : instance.to_world.rows)
      stretch = std::max(stretch, std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]));
    largest = std::max(largest, of_mesh[instance.mesh.value] * static_cast<float>(stretch));
  }
  return largest * 0x1p-21f;
}

// Where on it, and its colour there; nothing of directions.
SurfacePoint place_on(const MeshShading& mesh, const Hit& hit) {
  SurfacePoint surface;
  if (mesh.sphere) surface.uv = mesh.sphere->uv(normalize(hit.ng));
  if (mesh.interpolated) interpolate_vertices(*mesh.mesh, hit.triangle, hit.barycentric, surface);
  return surface;
}

MeshShading mesh_shading(const PreparedScene& prepared, const Placement& placed) {
  if (!placed.mesh) return {};
  const Mesh& mesh = *placed.mesh;
  MeshShading m{prepared.materials[placed.material.value], &mesh, placed.to_world, {}, false};
  m.sphere = mesh.sphere ? &*mesh.sphere : nullptr;
  m.bends = m.bends && m.has_uv();
  m.interpolated = !mesh.normals.empty() || !mesh.colors.empty() ||
                   (m.needs_uv() && !(mesh.uvs.empty() && mesh.second_uvs.empty()));
  m.plain = m.kind == BsdfKind::kDiffuse && m.opaque && !m.interpolated && !m.sphere &&
            !m.needs_uv() && !m.emits && !m.one_sided && !m.seen_whole && !m.pane;
  if (placed.to_world) m.normals_to_world = placed.to_world->normals();
  return m;
}

Result<std::shared_ptr<const EmbreeScene>> build_tree(const PreparedScene& prepared,
                                                      int build_threads, const BuildWatch& watch) {
  HitFilters filters;
  filters.intersect.passes = [&prepared](const Ray& ray, const Hit& hit) {
    return prepared.passes(ray, hit);
  };
  filters.occluded.passed = [&prepared](const Ray& ray, const Hit& hit) {
    return prepared.light_passed(ray, hit);
  };
  for (const MeshShading& mesh : prepared.meshes) {
    filters.intersect.meshes.push_back(mesh.masked);
    filters.occluded.meshes.push_back(mesh.masked || mesh.pane);
  }
  Result<std::unique_ptr<EmbreeScene>> tree =
      EmbreeScene::build(prepared.scene, build_threads, filters,
                         [&watch](double fraction) { return !watch || watch(fraction); });
  if (!tree.ok()) return tree.error();
  return std::shared_ptr<const EmbreeScene>(std::move(tree).value());
}

// All but the tree.
std::shared_ptr<PreparedScene> prepare(Scene given, SceneHash hash,
                                       std::shared_ptr<const MaterialTextures> textures) {
  auto prepared = std::make_shared<PreparedScene>();
  prepared->scene = std::move(given);
  prepared->hash = hash;
  const Scene& scene = prepared->scene;
  prepared->bounds = scene.bounds();
  prepared->ray_epsilon = ray_epsilon(*prepared);
  for (const Material& material : scene.materials) {
    prepared->bsdfs.push_back(make_bsdf(material));
    prepared->materials.push_back(
        material_shading(material, prepared->bsdfs.back().get(), prepared->materials));
  }
  prepared->textures = std::move(textures);
  for (const Placement& placed : scene.placements())
    prepared->meshes.push_back(mesh_shading(*prepared, placed));
  prepared->lights.build(scene, prepared->bounds, *prepared->textures);
  return prepared;
}

}  // namespace

PreparedScene::PreparedScene() = default;
PreparedScene::~PreparedScene() = default;

const CausticMap* PreparedScene::caustics(TaskPool& pool) const {
  std::call_once(caustics_once_, [&] {
    CausticPhotons photons = send_photons(*this, pool);
    if (CausticMap(photons).empty()) return;
    send_nearby(photons, *this, pool);
    auto map = std::make_unique<const CausticMap>(photons);
    if (map->empty()) return;
    caustics_bytes_ = map->size_bytes();
    caustics_ = std::move(map);
  });
  return caustics_.get();
}

void PreparedScene::put_on_sphere(const MeshShading& mesh, SurfacePoint& surface) {
  const Sphere& sphere = *mesh.sphere;
  const Vec3 outward = normalize(surface.p - sphere.center);
  surface.p = sphere.center + outward * sphere.radius;
  surface.ng = surface.ns = sphere.inward ? -outward : outward;
  if (mesh.needs_uv()) surface.uv = sphere.uv(outward);
}

TriangleEdges PreparedScene::edges_at(const MeshShading& mesh, const Hit& hit) {
  if (!mesh.sphere) return triangle_edges(*mesh.mesh, mesh.to_world, hit.triangle);
  const auto [du, dv] = mesh.sphere->tangents(normalize(hit.ng));
  return {du, dv, {1, 0}, {0, 1}};
}

void PreparedScene::bend(const MaterialShading& material, const Hit& hit, Vec3 wo,
                         SurfacePoint& surface) const {
  const MeshShading& m = meshes[hit.mesh.value];
  if (!m.has_uv()) return;
  surface.ns = bent_normal(*textures, *material.material, edges_at(m, hit), surface, wo);
}

Vec3 PreparedScene::coat_normal(const MaterialShading& material, const Hit& hit, Vec3 wo,
                                const SurfacePoint& surface) const {
  const MeshShading& m = meshes[hit.mesh.value];
  SurfacePoint own = surface;
  own.ns = surface.ng;
  if (!m.sphere)
    interpolate_vertices(*m.mesh, hit.triangle, hit.barycentric, own,
                         m.normals_to_world ? &*m.normals_to_world : nullptr);
  own.uv = surface.uv;
  const Material& coated = *material.material;
  if (coated.coat_normal_map.valid() && m.has_uv())
    own.ns = mapped_normal(*textures, coated.coat_normal_map, coated.coat_normal_scale,
                           edges_at(m, hit), own);
  return seen_normal(own.ns, surface.ng, wo);
}

Frame PreparedScene::turned_frame(const MaterialShading& material, const Hit& hit, Vec3 n,
                                  TexturePoint uv) const {
  const MeshShading& m = meshes[hit.mesh.value];
  if (!m.has_uv()) return Frame(n);
  const Material& brushed = *material.material;
  float turn = brushed.anisotropy_rad;
  if (brushed.anisotropy_directions && brushed.anisotropy.texture.valid()) {
    const Rgb along = textures->rgb(brushed.anisotropy.texture, uv);
    turn += std::atan2(2 * along.g - 1, 2 * along.r - 1);
  }
  return uv_frame(edges_at(m, hit), n, turn);
}

float PreparedScene::opacity(const MaterialShading& material, TexturePoint uv) const {
  if (!material.masked) return 1;
  const Material& m = *material.material;
  const float own = textures->opacity(m, uv);
  if (!material.blends) return own;
  return own * lerp(std::clamp(textures->number(m.blend_weight, uv), 0.0f, 1.0f),
                    opacity(materials[m.first.value], uv), opacity(materials[m.second.value], uv));
}

const MaterialShading& PreparedScene::resolve(const MaterialShading& material, TexturePoint uv,
                                              float u) const {
  const MaterialShading* at = &material;
  while (at->blends) {
    const Material& m = *at->material;
    const MaterialShading& first = materials[m.first.value];
    const MaterialShading& second = materials[m.second.value];
    float weight = std::clamp(textures->number(m.blend_weight, uv), 0.0f, 1.0f);
    if (at->masked) {  // what lets more rays pass is met less often
      const float b = weight * opacity(second, uv), a = (1 - weight) * opacity(first, uv);
      weight = a + b > 0 ? b / (a + b) : weight;
    }
    const bool takes_second = u < weight;
    u = takes_second ? u / weight : (u - weight) / (1 - weight);
    at = takes_second ? &second : &first;
  }
  return *at;
}

Rgb PreparedScene::emission_at(MeshId mesh, uint32_t triangle, Vec2 barycentric) const {
  const MeshShading& m = meshes[mesh.value];
  SurfacePoint surface;
  if (m.sphere) surface.uv = barycentric;
  if (m.interpolated) interpolate_vertices(*m.mesh, triangle, barycentric, surface);
  return textures->color(m.material->emission, surface.uv) * opacity(m, surface.uv);
}

float PreparedScene::uv_per_metre(const MeshShading& mesh, uint32_t triangle,
                                  const std::vector<Vec2>& uvs) {
  if (mesh.sphere) return 0.5f / (kPi * mesh.sphere->radius);
  if (uvs.empty()) return 0;
  const TriangleEdges e = triangle_edges(*mesh.mesh, mesh.to_world, triangle, uvs);
  const auto ratio2 = [](Vec2 uv, Vec3 edge) {
    return (uv.x * uv.x + uv.y * uv.y) / std::max(dot(edge, edge), 1e-30f);
  };
  return std::sqrt(
      std::min({ratio2(e.uv1, e.e1), ratio2(e.uv2, e.e2), ratio2(e.uv2 - e.uv1, e.e2 - e.e1)}));
}

bool PreparedScene::passes(const Ray& ray, const Hit& hit) const {
  const MeshShading& m = meshes[hit.mesh.value];
  const float opacity = this->opacity(m, place_on(m, hit).uv);
  if (opacity <= 0 || opacity >= 1) return opacity <= 0;
  uint64_t key = static_cast<uint64_t>(hit.mesh.value) << 32 | hit.triangle;
  for (int i = 0; i < 3; ++i)
    key = hash_combine(key, static_cast<uint64_t>(std::bit_cast<uint32_t>(ray.o[i])) << 32 |
                                std::bit_cast<uint32_t>(ray.d[i]));
  return to_unit_float(static_cast<uint32_t>(key >> 32)) >= opacity;
}

Rgb PreparedScene::light_passed(const Ray& ray, const Hit& hit) const {
  const MeshShading& m = meshes[hit.mesh.value];
  if (m.masked && passes(ray, hit)) return Rgb{1.0f};
  if (!m.pane) return {};
  // An instance's ray is in its mesh's space.
  Vec3 d = ray.d, ng = hit.ng;
  if (const Transform* t = m.to_world) {
    d = normalize(t->column(0) * d.x + t->column(1) * d.y + t->column(2) * d.z);
    ng = *m.normals_to_world * ng;
  }
  return straight(d, ng, hit);
}

Rgb PreparedScene::straight(Vec3 d, Vec3 ng, const Hit& hit) const {
  const MeshShading& m = meshes[hit.mesh.value];
  const float cos = std::min(std::abs(dot(d, ng)) / length(ng), 1.0f);
  const SurfacePoint surface = place_on(m, hit);
  ShadingPoint room;
  const BsdfPoint at =
      m.bsdf->at(shading_point(m, surface, room), {std::sqrt(1 - cos * cos), 0, cos});
  return m.bsdf->straight(at);
}

size_t PreparedScene::size_bytes() const {
  const auto bytes = [](const auto& values) { return std::span(values).size_bytes(); };
  size_t sum = accel->size_bytes() + textures->size_bytes() + bytes(meshes) + bytes(materials) +
               bytes(scene.instances) + bytes(scene.environment.image.data()) + caustics_bytes_;
  for (const Mesh& mesh : scene.meshes)
    sum += bytes(mesh.positions) + bytes(mesh.normals) + bytes(mesh.uvs) + bytes(mesh.second_uvs) +
           bytes(mesh.colors) + bytes(mesh.triangles);
  for (const Texture& texture : scene.textures)
    if (texture.bytes) sum += texture.bytes->size();
  return sum;
}

GuideSetup PreparedScene::guide_setup(const RenderSettings& settings) const {
  GuideSetup setup{bounds, lights.brightest(), settings.max_table_bytes, settings.huang,
                   settings.adaptive};
  if (settings.adaptive.lights) setup.lights = lights.clusters();
  return setup;
}

Result<std::shared_ptr<PreparedScene>> prepare_scene(Scene scene, SceneHash hash, int build_threads,
                                                     const BuildWatch& watch) {
  auto textures = std::make_shared<MaterialTextures>();
  if (Status s = textures->open(scene.textures, build_threads); !s.ok()) return s.error();
  std::shared_ptr<PreparedScene> prepared = prepare(std::move(scene), hash, std::move(textures));
  Result<std::shared_ptr<const EmbreeScene>> tree = build_tree(*prepared, build_threads, watch);
  if (!tree.ok()) return tree.error();
  prepared->accel = std::move(tree).value();
  return prepared;
}

std::shared_ptr<const PreparedScene> prepare_same_surfaces(
    Scene scene, SceneHash hash, const std::shared_ptr<const PreparedScene>& same) {
  std::shared_ptr<PreparedScene> prepared = prepare(std::move(scene), hash, same->textures);
  prepared->accel = {same, same->accel.get()};  // asks `same` which hits pass
  return prepared;
}

}  // namespace qray
