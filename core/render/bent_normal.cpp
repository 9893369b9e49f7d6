#include "core/render/bent_normal.h"

namespace qray {
namespace {

// Where x and y of the image point to on the surface: unit and orthogonal to ns, but for `du` and
// `dv`, which are metres a unit of uv.
struct Tangents {
  Vec3 du, dv;
};
bool tangents(const TriangleEdges& e, Vec3 ns, Tangents& out) {
  const float det = e.uv1.x * e.uv2.y - e.uv1.y * e.uv2.x;
  if (!(std::abs(det) > 1e-20f)) return false;
  const Vec3 du = (e.e1 * e.uv2.y - e.e2 * e.uv1.y) / det;
  const Vec3 dv = (e.e2 * e.uv1.x - e.e1 * e.uv2.x) / det;
  out = {du - ns * dot(ns, du), dv - ns * dot(ns, dv)};
  return length(out.du) > 1e-12f && length(out.dv) > 1e-12f;
}

// Unit, and orthogonal to both.
Vec3 bitangent_of(Vec3 ns, Vec3 tangent, Vec3 dv) {
  const Vec3 bitangent = cross(ns, tangent);
  return dot(bitangent, dv) < 0 ? -bitangent : bitangent;  // a mirrored chart
}

// Heights displace the surface along ns; the slope is taken over one texel, or what is
// seen as one.
Vec3 bumped(const MaterialTextures& textures, const Material& m, TexturePoint at, Vec3 ns,
            const Tangents& t) {
  const Vec2 uv = at.uv, texel = textures.texel(m.bump_map.texture);
  const Vec2 half = Vec2{std::max(texel.x, at.width), std::max(texel.y, at.width)} * 0.5f;
  const auto height = [&](float u, float v) {
    return textures.number(m.bump_map, TexturePoint({u, v}, at.width));
  };
  const float slope_u = (height(uv.x + half.x, uv.y) - height(uv.x - half.x, uv.y)) / (2 * half.x);
  const float slope_v = (height(uv.x, uv.y + half.y) - height(uv.x, uv.y - half.y)) / (2 * half.y);
  Vec3 n = cross(t.du + ns * slope_u, t.dv + ns * slope_v);
  if (dot(n, ns) < 0) n = -n;
  const float size = length(n);
  return size > 0 ? n / size : ns;
}

}  // namespace

TriangleEdges triangle_edges(const Mesh& mesh, const Transform* to_world, uint32_t triangle,
                             const std::vector<Vec2>& uvs) {
  const auto& v = mesh.triangles[triangle];
  Vec3 p[3];
  for (size_t k = 0; k < 3; ++k) {
    p[k] = mesh.positions[v[k]];
    if (to_world) p[k] = to_world->point(p[k]);
  }
  const Vec2 uv = uvs[v[0]];
  return {p[1] - p[0], p[2] - p[0], uvs[v[1]] - uv, uvs[v[2]] - uv};
}

Frame uv_frame(const TriangleEdges& edges, Vec3 n, float turn) {
  Tangents t;
  if (!tangents(edges, n, t)) return Frame(n);
  const Vec3 tangent = normalize(t.du);
  const Vec3 x = tangent * std::cos(turn) + bitangent_of(n, tangent, t.dv) * std::sin(turn);
  return Frame(x, cross(n, x), n);
}

Vec3 seen_normal(Vec3 n, Vec3 ng, Vec3 wo) {
  const float side = dot(wo, ng) < 0 ? -1.0f : 1.0f;
  n = n * side;
  ng = ng * side;
  const float grazing = dot(wo, ng);
  if (grazing < 1e-3f) return ng * side;         // nothing else would be seen for sure
  const float least = std::min(1e-2f, grazing);  // a normal that is not bent stays
  if (const float seen = dot(wo, n); seen < least) n = normalize(n + wo * (least - seen));
  const Vec3 mirrored = n * (2 * dot(wo, n)) - wo;
  if (const float above = dot(mirrored, ng); above < least)
    n = normalize(wo + normalize(mirrored + ng * (least - above)));
  return n * side;
}

Vec3 mapped_normal(const MaterialTextures& textures, TextureId map, float scale,
                   const TriangleEdges& edges, const SurfacePoint& surface) {
  const Vec3 ns = surface.ns;
  Tangents t;
  if (!tangents(edges, ns, t)) return ns;
  const Rgb texel = textures.rgb(map, surface.uv);
  const float x = (2 * texel.r - 1) * scale, y = (2 * texel.g - 1) * scale;
  const float z = std::max(2 * texel.b - 1, 1e-3f);
  const Vec3 tangent = normalize(t.du);
  return normalize(tangent * x + bitangent_of(ns, tangent, t.dv) * y + ns * z);
}

Vec3 bent_normal(const MaterialTextures& textures, const Material& material,
                 const TriangleEdges& edges, const SurfacePoint& surface, Vec3 wo) {
  Vec3 n = surface.ns;
  Tangents t;
  if (material.normal_map.valid())
    n = mapped_normal(textures, material.normal_map, material.normal_scale, edges, surface);
  if (material.bump_map.texture.valid() && tangents(edges, n, t))
    n = bumped(textures, material, surface.uv, n, t);
  return seen_normal(n, surface.ng, wo);
}

}  // namespace qray
