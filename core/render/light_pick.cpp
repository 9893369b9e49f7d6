#include "core/render/light_pick.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/math/frame.h"
#include "core/math/hash.h"
#include "core/math/warp.h"
#include "core/render/light_split.h"
#include "core/scene/surface.h"

namespace qray {
namespace {

constexpr uint32_t kNoTriangle = ~0u;
// Where lights are fewer, weighing them costs more than it brings.
constexpr size_t kFewestForATree = 8;
// Of the scene's radius: lights that are closer together send about the same if they shine the same
// way, such as the triangles of a lamp's disk.
constexpr float kTogether = 0.1f;

// What a material's images leave of its emission, about; never so little that it is not picked.
// uv_at(Vec2): where equal areas of the unit square lie on the images.
template <class UvAt>
float brightness_share(const Material& material, const MaterialTextures& textures, int steps,
                       UvAt uv_at) {
  constexpr float kLeast = 0.05f;
  const float whole = luminance(material.emission.value), n = static_cast<float>(steps);
  float sum = 0;
  for (int i = 0; i < steps * steps; ++i) {
    const TexturePoint uv = uv_at(
        {(static_cast<float>(i / steps) + 0.5f) / n, (static_cast<float>(i % steps) + 0.5f) / n});
    sum += luminance(textures.color(material.emission, uv)) * textures.opacity(material, uv);
  }
  return std::max(kLeast, sum / (n * n) / whole);
}

bool emission_varies(const Material& material) {
  return material.emission.texture.valid() || material.opacity.texture.valid() ||
         material.opacity.value < 1;
}

bool has_place(const PunctualLight& light) { return light.kind != LightKind::kDirectional; }

// Of the unit sphere's cap that a sphere covers, seen from outside: 1 - the cosine at its edge.
float cap_height(float radius, float distance2) {
  const float sin2 = std::min(sqr(radius) / distance2, 1.0f);
  return sin2 / (1 + std::sqrt(1 - sin2));
}

// 24 random bits tell few of a million lights apart: more follow from the point's.
double finer(float u_light, Vec2 u) {
  const uint64_t more = mix64(static_cast<uint64_t>(std::bit_cast<uint32_t>(u.x)) << 32 |
                              std::bit_cast<uint32_t>(u.y));
  return double{u_light} + static_cast<double>(more >> 11) * 0x1p-77;
}

// Of a group whose chances are summed up, from the first on.
float chance_of(const float* sums, uint32_t index) {
  return sums[index] - (index > 0 ? sums[index - 1] : 0);
}

// One of a group, by u in [0, 1); what the pick leaves of u is in [0, 1) again.
AliasTable::Pick pick_by_chances(const float* sums, uint32_t count, float& u) {
  const uint32_t index =
      std::min(static_cast<uint32_t>(std::upper_bound(sums, sums + count, u) - sums), count - 1);
  const float chance = chance_of(sums, index), below = sums[index] - chance;
  u = std::clamp((u - below) / chance, 0.0f, kOneMinusEpsilon);
  return {index, chance};
}

// The row by u.y, the cell in it by u.x: as long as chances are alike, points that are spread over
// the square stay so.
AliasTable::Pick pick_cell(const float* sums, Vec2& u) {
  constexpr uint32_t kRow = EnvironmentLight::kCellColumns;
  uint32_t first = 0;
  while (first + kRow < EnvironmentLight::kCells && !(u.y < sums[first + kRow - 1])) first += kRow;
  const float below = first > 0 ? sums[first - 1] : 0, of_row = sums[first + kRow - 1] - below;
  u.y = std::clamp((u.y - below) / of_row, 0.0f, kOneMinusEpsilon);
  const float at = below + u.x * of_row;
  const float* found = std::upper_bound(sums + first, sums + first + kRow, at);
  if (found == sums + first + kRow) found = std::lower_bound(sums + first, found, found[-1]);
  const auto index = static_cast<uint32_t>(found - sums);
  const float chance = chance_of(sums, index);
  u.x = std::clamp((at - (*found - chance)) / chance, 0.0f, kOneMinusEpsilon);
  return {index, chance};
}

LightBounds punctual_bounds(const PunctualLight& light) {
  LightBounds b;
  b.box.add(light.position);
  b.intensity = luminance(light.intensity);
  b.cos_spread = -1;
  b.cos_emission = 1;
  if (light.kind == LightKind::kSpot && light.outer_rad < kPi) {
    b.axis = light.direction;
    b.cos_spread = std::cos(light.outer_rad);
  }
  return b;
}

}  // namespace

void LightPick::build(const Scene& scene, const Bounds3& bounds, const MaterialTextures& textures) {
  std::vector<float> powers;
  const std::vector<Placement> placements = scene.placements();
  first_of_mesh_.assign(placements.size(), kNoTriangle);
  for (size_t i = 0; i < placements.size(); ++i) {
    const Placement& placed = placements[i];
    const Material& material = scene.materials[placed.material.value];
    if (!placed.mesh || !material.emits() || placed.mesh->sphere) continue;
    first_of_mesh_[i] = static_cast<uint32_t>(triangles_.size());
    const bool mirrored = placed.to_world && placed.to_world->determinant() < 0;
    for (const auto& tri : placed.mesh->triangles) {
      EmittingTriangle t;
      t.p0 = placed.at(placed.mesh->positions[tri[0]]);
      t.e1 = placed.at(placed.mesh->positions[tri[1]]) - t.p0;
      t.e2 = placed.at(placed.mesh->positions[tri[2]]) - t.p0;
      const Vec3 n = mirrored ? cross(t.e2, t.e1) : cross(t.e1, t.e2);
      t.area = 0.5f * length(n);
      t.n = normalize(n);
      t.emission = material.emission.value;
      t.two_sided = material.emission_two_sided;
      t.mesh = MeshId(static_cast<uint32_t>(i));
      t.index = static_cast<uint32_t>(&tri - placed.mesh->triangles.data());
      t.varies = emission_varies(material);
      t.brightness = luminance(t.emission);
      if (t.varies) {
        t.brightness *= brightness_share(material, textures, 4, [&](Vec2 u) {
          SurfacePoint surface;
          interpolate_vertices(*placed.mesh, t.index, square_to_triangle(u), surface);
          return surface.uv;
        });
      }
      powers.push_back(kPi * t.area * t.brightness * (t.two_sided ? 2.0f : 1.0f));
      triangles_.push_back(t);
    }
  }
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    const Material& material = scene.materials[mesh.material.value];
    if (!mesh.sphere || !material.emits()) continue;
    first_of_mesh_[i] = static_cast<uint32_t>(triangles_.size() + spheres_.size());
    EmittingSphere& s = spheres_.emplace_back();
    s.shape = *mesh.sphere;
    s.emission = material.emission.value;
    s.two_sided = material.emission_two_sided;
    s.mesh = MeshId(static_cast<uint32_t>(i));
    s.varies = emission_varies(material);
    s.brightness = luminance(s.emission);
    if (s.varies) {
      s.brightness *= brightness_share(
          material, textures, 16, [&](Vec2 u) { return s.shape.uv(square_to_uniform_sphere(u)); });
    }
    powers.push_back(kPi * s.area() * s.brightness * (s.two_sided ? 2.0f : 1.0f));
  }
  double power_inside = 0;
  for (const bool with_place : {true, false})
    for (size_t i = 0; i < scene.lights.size(); ++i) {
      const PunctualLight& light = scene.lights[i];
      if (!light.emits() || has_place(light) != with_place) continue;
      punctual_.push_back(light);
      punctual_sources_.push_back(source_of_punctual(scene, i));
    }
  environment_source_ = source_of_environment(scene);
  for (const PunctualLight& light : punctual_)
    powers.push_back(light.kind == LightKind::kDirectional ? 0 : luminance(light.power()));
  for (const float p : powers) power_inside += p;
  // Flux through the scene's disk; never more than the lights inside have, of which a closed room
  // sees nothing else.
  const float disk = kPi * sqr(bounds.radius());
  const auto from_outside = [&](float irradiance) {
    const float power = disk * irradiance;
    return power_inside > 0 ? std::min(power, static_cast<float>(power_inside)) : power;
  };
  for (size_t i = 0; i < punctual_.size(); ++i) {
    if (punctual_[i].kind == LightKind::kDirectional)
      powers[triangles_.size() + spheres_.size() + i] =
          from_outside(luminance(punctual_[i].intensity));
  }
  if (scene.environment.present()) {
    environment_ = std::make_shared<EnvironmentLight>(scene.environment);
    if (!environment_->even())
      powers.push_back(from_outside(4 * kPi * environment_->mean_luminance()));
  }
  if (!powers.empty()) set_picker(powers);
  set_brightest(bounds.radius());
  set_tree(powers, kTogether * bounds.radius());
  set_clusters(bounds, powers);
}

void LightPick::set_tree(std::span<const float> powers, float together) {
  const size_t with_extent = triangles_.size() + spheres_.size();
  const size_t in_tree =
      with_extent + static_cast<size_t>(std::ranges::count_if(punctual_, has_place));
  double inside = 0, outside = 0;
  for (size_t i = 0; i < powers.size(); ++i) (i < in_tree ? inside : outside) += double{powers[i]};
  if (in_tree < kFewestForATree || !(inside > 0)) return;
  std::vector<LightBounds> bounds;
  bounds.reserve(in_tree);
  for (const EmittingTriangle& t : triangles_) bounds.push_back(bounds_of(t));
  for (const EmittingSphere& s : spheres_) bounds.push_back(bounds_of(s));
  for (size_t i = with_extent; i < in_tree; ++i)
    bounds.push_back(punctual_bounds(punctual_[i - with_extent]));
  if (in_tree == powers.size() && !differ(bounds, together)) return;
  tree_ = std::make_shared<const LightTree>(bounds);
  tree_probability_ = static_cast<float>(inside / (inside + outside));
  in_tree_ = in_tree;
  outside_ = in_tree < powers.size() ? AliasTable(powers.subspan(in_tree)) : AliasTable();
}

void LightPick::set_picker(std::span<const float> weights) {
  picker_ = AliasTable(weights);
  if (environment_ && !environment_->even())
    environment_probability_ = picker_.probability(picker_.size() - 1);
}

LightPick LightPick::uniform() const {
  LightPick other = *this;
  other.tree_ = nullptr;
  other.clusters_ = {};
  if (connects()) other.set_picker(std::vector<float>(picker_.size(), 1.0f));
  return other;
}

void LightPick::set_brightest(float radius) {
  for (const EmittingTriangle& t : triangles_)
    brightest_ = std::max(brightest_, luminance(t.emission));
  for (const EmittingSphere& s : spheres_) brightest_ = std::max(brightest_, luminance(s.emission));
  for (const PunctualLight& light : punctual_) {
    const float distance = light.kind == LightKind::kDirectional ? 1 : 0.1f * radius;
    brightest_ = std::max(brightest_, luminance(light.intensity) / (kPi * sqr(distance)));
  }
  if (environment_) brightest_ = std::max(brightest_, environment_->brightest());
}

bool LightPick::picks_uniformly() const {
  if (tree_) return false;
  for (uint32_t i = 1; i < picker_.size(); ++i)
    if (std::abs(picker_.probability(i) / picker_.probability(0) - 1) > 1e-3f) return false;
  return true;
}

bool LightPick::sample_punctual(const PunctualLight& light, float probability, Vec3 p,
                                LightSample& out) {
  out.punctual = true;
  out.pdf_w = probability;
  if (light.kind == LightKind::kDirectional) {
    out.wi = -light.direction;
    out.distance = std::numeric_limits<float>::infinity();
    out.radiance = light.intensity;
    return true;
  }
  const Vec3 to_light = light.position - p;
  const float distance2 = dot(to_light, to_light);
  if (!(distance2 > 0)) return false;
  out.distance = std::sqrt(distance2);
  out.wi = to_light / out.distance;
  out.radiance = light.intensity_toward(-out.wi) / distance2;
  return !out.radiance.is_black();
}

bool LightPick::put_environment(const EnvironmentLight::Drawn& drawn, float probability,
                                LightSample& out) const {
  out.drawn = drawn;
  out.distance = std::numeric_limits<float>::infinity();
  out.source = environment_source_;
  out.pdf_w = probability;
  return drawn.exists();
}

bool LightPick::finish_environment(LightSample& out) const {
  const EnvironmentLight::Sample s = environment_->sample_of(out.drawn);
  out.wi = s.wi;
  out.radiance = s.radiance;
  out.pdf_w *= s.pdf_w;
  return s.pdf_w > 0;
}

LightBounds LightPick::bounds_of(const EmittingTriangle& t) {
  LightBounds b;
  for (const Vec3 p : {t.p0, t.p0 + t.e1, t.p0 + t.e2}) b.box.add(p);
  b.axis = t.n;
  b.intensity = t.brightness * t.area;
  b.two_sided = t.two_sided;
  return b;
}

bool LightPick::choose_by_tree(const LightReceiver& at, float u_light, Vec2 u, LightSample& out,
                               LightTree::Search& search) const {
  if (!(u_light < tree_probability_)) {
    const float rest = (u_light - tree_probability_) / (1 - tree_probability_);
    AliasTable::Pick pick = outside_.sample(rest);
    pick.index += static_cast<uint32_t>(in_tree_);
    pick.probability *= 1 - tree_probability_;
    return sample_of(pick, at, u, out);
  }
  search = {.at = at, .u = std::min(finer(u_light, u) / double{tree_probability_}, 1.0)};
  out.in_tree = true;
  out.pdf_w = tree_probability_;
  return true;
}

bool LightPick::finish_search(const LightTree::Search& search, Vec2 u, LightSample& out) const {
  for (uint32_t i = 0; i < search.passed_count; ++i)
    out.add({first_of_tree_ + search.passed[i].cluster, out.pdf_w * search.passed[i].scale});
  if (!(search.pick.probability > 0)) return false;
  return sample_of({search.pick.light, search.pick.probability * out.pdf_w}, search.at, u, out);
}

LightBounds LightPick::bounds_of(const EmittingSphere& s) {
  LightBounds b;
  b.box = s.shape.bounds();
  b.intensity = s.brightness * s.area() / 4;
  b.cos_spread = -1;
  return b;
}

bool LightPick::sample_sphere(const EmittingSphere& s, float probability, Vec3 p, Vec2 u,
                              LightSample& out) {
  const bool inside = s.has_inside(p);
  if (!s.emits_to(inside)) return false;
  const Vec3 to_center = s.shape.center - p;
  const float r = s.shape.radius, d2 = dot(to_center, to_center);
  Vec3 outward;
  if (inside) {
    outward = square_to_uniform_sphere(u);
    const Vec3 to_light = to_center + outward * r;
    const float distance2 = dot(to_light, to_light);
    out.distance = std::sqrt(distance2);
    out.wi = to_light / out.distance;
    const float cos_light = dot(out.wi, outward);
    if (!(cos_light > 0) || !(distance2 > 0)) return false;
    out.pdf_w = probability * distance2 / (cos_light * s.area());
  } else {
    const float cap = cap_height(r, d2), d = std::sqrt(d2);
    const Vec2 disk = square_to_disk(u);
    // 1 - the cosine with the direction of the center.
    const float height = cap * (disk.x * disk.x + disk.y * disk.y);
    const float sin2 = height * (2 - height);
    const float scale = std::sqrt(cap * (2 - height));
    out.wi = Frame(to_center / d).to_world({disk.x * scale, disk.y * scale, 1 - height});
    out.distance = d * (1 - height) - std::sqrt(std::max(sqr(r) - d2 * sin2, 0.0f));
    if (!(out.distance > 0)) return false;
    out.pdf_w = probability / (2 * kPi * cap);
    if (s.varies) outward = normalize(out.wi * out.distance - to_center);
  }
  out.radiance = s.emission;
  out.source = s.mesh.value;
  if (s.varies) out.varies = true, out.mesh = s.mesh, out.barycentric = s.shape.uv(outward);
  return true;
}

float LightPick::pdf_w_of_hit(const LightReceiver& at, const Hit& hit, float cos_light,
                              const float* weights) const {
  const uint32_t light = first_of_mesh_[hit.mesh.value] + hit.triangle;
  const float* factors = tree_ && weights ? weights + first_of_tree_ : nullptr;
  const float probability = tree_
                                ? member_chance(0, weights) * tree_->probability(at, light, factors)
                                : member_chance(light, weights);
  if (light < triangles_.size())
    return probability * sqr(hit.t) / (std::abs(cos_light) * triangles_[light].area);
  const EmittingSphere& s = spheres_[light - triangles_.size()];
  if (s.has_inside(at.p)) return probability * sqr(hit.t) / (std::abs(cos_light) * s.area());
  // From outside, its far side is not drawn.
  const bool far_side = (cos_light > 0) == s.shape.inward;
  const Vec3 to_center = s.shape.center - at.p;
  return far_side ? 0
                  : probability / (2 * kPi * cap_height(s.shape.radius, dot(to_center, to_center)));
}

std::optional<Ray> LightPick::emit(float u_light, float u_side, Vec2 u_point, Vec2 u_direction,
                                   const Bounds3& bounds) const {
  const uint32_t light = picker_.sample(u_light).index;
  const size_t first_punctual = triangles_.size() + spheres_.size();
  Vec3 p, n;
  bool two_sided = false;
  if (light < triangles_.size()) {
    const EmittingTriangle& t = triangles_[light];
    const Vec2 b = square_to_triangle(u_point);
    p = t.p0 + t.e1 * b.x + t.e2 * b.y, n = t.n;
    two_sided = t.two_sided;
  } else if (light < first_punctual) {
    const EmittingSphere& s = spheres_[light - triangles_.size()];
    const Vec3 outward = square_to_uniform_sphere(u_point);
    p = s.shape.center + outward * s.shape.radius, n = s.shape.inward ? -outward : outward;
    two_sided = s.two_sided;
  } else if (light == first_punctual + punctual_.size()) {
    const EnvironmentLight::Sample from = environment_->sample(u_point);
    if (!(from.pdf_w > 0)) return {};
    const Vec2 disk = square_to_disk(u_direction);
    const Vec3 at = Vec3{disk.x, disk.y, 1} * bounds.radius();
    return Ray{bounds.center() + Frame(from.wi).to_world(at), -from.wi};
  } else {
    return {};
  }
  if (two_sided && u_side < 0.5f) n = -n;
  const float largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return Ray{p + n * (largest * kRayOffset),
             Frame(n).to_world(square_to_cosine_hemisphere(u_direction))};
}

// Groups: the members, if it matters which; the tree's clusters; the environment's cells, to which
// a random number must be left over.
void LightPick::set_clusters(const Bounds3& bounds, std::span<const float> powers) {
  constexpr size_t kMostMembers = 16;
  clusters_.bounds = bounds;
  const auto add_group = [&](LightClusters::Group group) {
    const uint32_t first = static_cast<uint32_t>(plain_weights_.size());
    float below = 0;
    for (uint32_t i = 0; i < group.count; ++i)
      plain_weights_.push_back(group.priors.empty() ? 1 : below += group.priors[i]);
    if (!group.priors.empty()) plain_weights_.back() = 1;
    clusters_.groups.push_back(std::move(group));
    return first;
  };
  if (members() > kMostMembers || members() == 0) return;
  const bool one_mesh =
      !tree_ && triangles_.size() == members() && triangles_.front().mesh == triangles_.back().mesh;
  if (one_mesh) return;
  if (members() > 1) {
    LightClusters::Group group;
    group.count = static_cast<uint32_t>(members());
    for (uint32_t i = 0; i < group.count; ++i) group.priors.push_back(member_prior(i));
    first_member_ = add_group(std::move(group));
    double power = 0;
    for (const float p : powers) power += double{p};
    member_scale_ = power > 0 ? static_cast<float>(double{sqr(bounds.radius())} / power) : 0;
  }
  if (tree_) {
    first_of_tree_ = static_cast<uint32_t>(plain_weights_.size());
    for (const uint32_t count : tree_->clusters()) add_group({{}, count});
    clusters_.fingerprint = tree_->fingerprint();
  }
  if (environment_ && !environment_->even()) {
    LightClusters::Group cells;
    cells.count = EnvironmentLight::kCells;
    for (uint32_t i = 0; i < cells.count; ++i) cells.priors.push_back(environment_->cell_chance(i));
    first_cell_ = add_group(std::move(cells));
    cell_scale_ = 1 / (kPi * environment_->mean_luminance());
  }
}

float LightPick::member_prior(uint32_t member) const {
  if (!tree_) return picker_.probability(member);
  if (member == 0) return tree_probability_;
  return (1 - tree_probability_) * outside_.probability(member - 1);
}

float LightPick::member_chance(uint32_t member, const float* weights) const {
  if (!weights || first_member_ == kNone) return member_prior(member);
  return chance_of(weights + first_member_, member);
}

EnvironmentLight::Arriving LightPick::from_environment(Vec3 wi, const float* weights) const {
  if (!weights || first_cell_ == kNone) {
    const EnvironmentLight::Arriving a = environment_->at(wi);
    return {a.radiance, environment_probability_ * a.pdf_w};
  }
  const EnvironmentLight::InCell in = environment_->in_cell(wi);
  const float chance = member_chance(static_cast<uint32_t>(members() - 1), weights) *
                       chance_of(weights + first_cell_, in.cell);
  return {in.radiance, chance * in.pdf_w};
}

bool LightPick::choose_by_clusters(const LightReceiver& at, float u_light, Vec2 u, LightSample& out,
                                   const float* weights, LightTree::Search& search) const {
  AliasTable::Pick pick{0, 1};
  if (first_member_ != kNone) {
    pick = pick_by_chances(weights + first_member_, clusters_.groups[0].count, u_light);
    out.add(
        {first_member_ + pick.index, pick.probability / member_prior(pick.index) * member_scale_});
  }
  if (tree_ && pick.index == 0) {
    search = {.at = at, .u = std::min(finer(u_light, u), 1.0), .factors = weights + first_of_tree_};
    out.in_tree = true;
    out.pdf_w = pick.probability;
    return true;
  }
  if (first_cell_ != kNone && pick.index + 1 == members())
    return sample_cell(pick.probability, at.n, u, out, weights + first_cell_);
  if (tree_) pick.index += static_cast<uint32_t>(in_tree_) - 1;
  return sample_of(pick, at, u, out);
}

bool LightPick::sample_cell(float probability, Vec3 normal, Vec2 u_point, LightSample& out,
                            const float* chances) const {
  const AliasTable::Pick cell = pick_cell(chances, u_point);
  const float prior = chance_of(plain_weights_.data() + first_cell_, cell.index);
  out.add({first_cell_ + cell.index, probability * cell.probability / prior * cell_scale_});
  return put_environment(environment_->draw_in(cell.index, u_point, normal),
                         probability * cell.probability, out);
}

}  // namespace qray
