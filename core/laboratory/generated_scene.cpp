#include "core/laboratory/generated_scene.h"

#include <array>
#include <cmath>

#include "core/math/hash.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr int kWallCells = 32;  // a side of a wall's pattern
constexpr int kSphereRings = 24, kSphereSides = 48;
constexpr int kSkyWidth = 64, kSkyHeight = 32;

class Draws {
 public:
  explicit Draws(uint64_t seed) : state_(mix64(seed)) {}
  float between(float low, float high) {
    state_ = mix64(state_ + 0x9e3779b97f4a7c15u);
    return low + (high - low) * to_unit_float(static_cast<uint32_t>(state_ >> 32));
  }
  int below(int n) { return std::min(static_cast<int>(between(0, static_cast<float>(n))), n - 1); }
  Rgb colour(float low, float high) {
    const float grey = between(low, high), mix = between(0, 1);
    Rgb c;
    for (int k = 0; k < 3; ++k) c[k] = grey + mix * (between(low, high) - grey);
    return c;
  }

 private:
  uint64_t state_;
};

// A colour for each vertex of a wall, by its column and row.
class Pattern {
 public:
  explicit Pattern(Draws& n)
      : kind_(n.below(4)),
        period_(1 << n.below(4)),
        seed_(static_cast<uint64_t>(n.below(1 << 20))),
        a_(n.colour(0.05f, 0.9f)),
        b_(n.colour(0.05f, 0.9f)) {}
  Rgb at(int x, int y) const {
    switch (kind_) {
      case 0:
        return a_;
      case 1:
        return (x / period_ + y / period_) % 2 ? a_ : b_;
      case 2:
        return x / period_ % 2 ? a_ : b_;
      default: {
        const uint64_t cell = static_cast<uint64_t>(x / period_ * kWallCells + y / period_);
        return lerp(to_unit_float(static_cast<uint32_t>(mix64(seed_ + cell) >> 32)), a_, b_);
      }
    }
  }

 private:
  int kind_, period_;
  uint64_t seed_;
  Rgb a_, b_;
};

class RoomMaker {
 public:
  explicit RoomMaker(uint64_t seed) : n_(seed) {
    scene_.name = "generated " + std::to_string(seed);
    size_ = {n_.between(3, 8), n_.between(2.4f, 4), n_.between(3, 8)};
    plain_ = n_.below(4) == 0;
    add_walls_and_light();
    const int things = 5 + n_.below(20);
    for (int i = 0; i < things; ++i) add_thing();
    scene_.camera.position = size_ * 0.1f;
    scene_.camera.target = size_ * 0.5f;
    scene_.camera.vertical_fov_deg = n_.between(35, 70);
  }
  Scene take() { return std::move(scene_); }

 private:
  MaterialId add(Material material) {
    material.name = "m" + std::to_string(scene_.materials.size());
    scene_.materials.push_back(std::move(material));
    return MaterialId(static_cast<uint32_t>(scene_.materials.size() - 1));
  }
  MaterialId matt(Rgb colour) {
    Material m;
    m.reflectance.value = colour;
    return add(m);
  }
  MaterialId lamp(Rgb radiance) {
    Material m;
    m.reflectance.value = Rgb{0.5f};
    m.emission.value = radiance;
    return add(m);
  }
  // Takes its colour from a wall's pattern.
  MaterialId glossy() {
    Material m;
    m.reflectance.value = Rgb{1.0f};
    m.kind = n_.below(3) ? MaterialKind::kPlastic : MaterialKind::kConductor;
    m.specular.value = Rgb{n_.between(0.3f, 1)};
    m.roughness.value = n_.between(0.03f, 0.4f);
    return add(m);
  }
  // Of furniture: what is more common in rooms is more common here.
  MaterialId any() {
    Material m;
    m.reflectance.value = n_.colour(0.05f, 0.9f);
    switch (plain_ ? 7 : n_.below(8)) {
      case 0:
      case 1:
        m.kind = MaterialKind::kPlastic;
        m.roughness.value = n_.below(2) ? n_.between(0.05f, 0.5f) : 0.0f;
        break;
      case 2:
        m.kind = MaterialKind::kConductor;
        m.specular.value = n_.colour(0.4f, 1);
        m.roughness.value = n_.between(0.03f, 0.6f);
        break;
      case 3:
        m.kind = MaterialKind::kConductor;
        m.specular.value = n_.colour(0.4f, 1);
        break;
      case 4:
        m.kind = MaterialKind::kDielectric;
        m.ior = n_.between(1.3f, 1.7f);
        m.transmittance.value = n_.colour(0.7f, 1);
        break;
      default:
        break;
    }
    return add(m);
  }

  // Fronts are on the side of cross(a, b); with a pattern, in cells of it.
  void add_wall(MaterialId material, Vec3 origin, Vec3 a, Vec3 b, const Pattern* pattern) {
    Mesh mesh;
    mesh.material = material;
    const int cells = pattern ? kWallCells : 1;
    for (int y = 0; y < cells; ++y)
      for (int x = 0; x < cells; ++x) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (const auto& [i, k] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
          mesh.positions.push_back(origin +
                                   a * (static_cast<float>(x + i) / static_cast<float>(cells)) +
                                   b * (static_cast<float>(y + k) / static_cast<float>(cells)));
          if (pattern) mesh.colors.push_back(pattern->at(x, y));
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
      }
    scene_.meshes.push_back(std::move(mesh));
  }

  // Fronts outside. Turned by `angle` about the middle's vertical.
  void add_box(MaterialId material, Vec3 middle, Vec3 half, float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    const Vec3 x = Vec3{c, 0, -s} * half.x, y{0, half.y, 0}, z = Vec3{s, 0, c} * half.z;
    Mesh mesh;
    mesh.material = material;
    for (const auto& [n, a, b] : {std::array{x, y, z}, {y, z, x}, {z, x, y}})
      for (const float side : {-1.0f, 1.0f}) {
        const Vec3 at = middle + n * side, u = a * side;
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (const Vec3 p : {at - u - b, at + u - b, at + u + b, at - u + b})
          mesh.positions.push_back(p);
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
      }
    scene_.meshes.push_back(std::move(mesh));
  }

  void add_sphere(MaterialId material, Vec3 middle, float radius) {
    Mesh mesh;
    mesh.material = material;
    for (int ring = 0; ring <= kSphereRings; ++ring)
      for (int side = 0; side <= kSphereSides; ++side) {
        const float theta = kPi * static_cast<float>(ring) / kSphereRings;
        const float phi = 2 * kPi * static_cast<float>(side) / kSphereSides;
        const Vec3 d{std::sin(theta) * std::cos(phi), std::cos(theta),
                     -std::sin(theta) * std::sin(phi)};
        mesh.positions.push_back(middle + d * radius);
        mesh.normals.push_back(d);
      }
    for (uint32_t ring = 0; ring < kSphereRings; ++ring)
      for (uint32_t side = 0; side < kSphereSides; ++side) {
        const uint32_t a = ring * (kSphereSides + 1) + side, b = a + kSphereSides + 1;
        if (ring + 1 < kSphereRings) mesh.triangles.push_back({a, b, b + 1});
        if (ring > 0) mesh.triangles.push_back({a, b + 1, a + 1});
      }
    scene_.meshes.push_back(std::move(mesh));
  }

  // A panel that shines down from below the ceiling.
  void add_panel(float half) {
    const Vec3 at{n_.between(half, size_.x - half), size_.y - 0.02f,
                  n_.between(half, size_.z - half)};
    add_lamp(at, half, n_.between(4, 30));
  }
  void add_lamp(Vec3 at, float half, float power) {
    add_wall(lamp(n_.colour(0.5f, 1) * (power / (half * half))), at - Vec3{half, 0, half},
             {2 * half, 0, 0}, {0, 0, 2 * half}, nullptr);
  }

  void add_walls_and_light() {
    const int light = n_.below(6);
    const bool open = light == 5;
    const Vec3 x{size_.x, 0, 0}, y{0, size_.y, 0}, z{0, 0, size_.z};
    struct Side {
      Vec3 origin, a, b;
    };
    const Side sides[] = {{{}, z, x}, {{}, y, z}, {{}, x, y}, {z, y, x}, {x, z, y}, {y, x, z}};
    const MaterialId white = matt(Rgb{1.0f});
    for (int i = 0; i < 6; ++i) {
      const Pattern pattern(n_);
      if (open && i >= 4) continue;  // neither a ceiling nor one wall
      const bool shines = !plain_ && n_.below(i == 0 ? 2 : 8) == 0;  // floors most often
      add_wall(shines ? glossy() : white, sides[i].origin, sides[i].a, sides[i].b, &pattern);
    }
    switch (light) {
      case 0:
        add_panel(n_.between(0.2f, 0.8f));
        break;
      case 1:
        for (int i = 2 + n_.below(4); i > 0; --i) add_panel(n_.between(0.1f, 0.4f));
        break;
      case 2:
        for (int i = 0; i < 24; ++i) {
          const float r = n_.between(0.02f, 0.06f);
          add_sphere(lamp(n_.colour(0.2f, 1) * (n_.between(0.2f, 1) / (r * r))), place(2 * r), r);
        }
        break;
      case 3: {  // all light comes by way of the ceiling
        const Vec3 at = size_ * 0.5f;
        const float height = 0.7f * size_.y;
        add_box(white, {at.x, height - 0.03f, at.z}, {0.5f, 0.02f, 0.5f}, 0);
        add_wall(lamp(Rgb{n_.between(40, 120)}), {at.x - 0.3f, height, at.z - 0.3f}, {0, 0, 0.6f},
                 {0.6f, 0, 0}, nullptr);
        break;
      }
      case 4:
        add_light_through_a_gap(white);
        break;
      default:
        add_sky();
        break;
    }
  }

  // A wall across the room, and all light behind it.
  void add_light_through_a_gap(MaterialId white) {
    const float at = n_.between(0.6f, 0.8f) * size_.z, gap = n_.between(0.05f, 0.6f);
    const float wide = 0.5f * (size_.x - gap);
    add_box(white, {wide, 0.5f * size_.y, at}, {wide, 0.5f * size_.y, 0.05f}, 0);
    const float half = n_.between(0.1f, 0.25f);
    const Vec3 lamp_at{n_.between(half, size_.x - half), size_.y - 0.02f,
                       n_.between(at + half + 0.06f, size_.z - half)};
    add_lamp(lamp_at, half, n_.between(40, 200));
  }

  void add_sky() {
    Environment& sky = scene_.environment;
    sky.radiance = Rgb{n_.between(0.5f, 2)};
    sky.image = Image(kSkyWidth, kSkyHeight, 3);
    const Rgb top = n_.colour(0.3f, 1), horizon = n_.colour(0.5f, 1);
    const int sun_x = n_.below(kSkyWidth), sun_y = 2 + n_.below(kSkyHeight / 2 - 4);
    const float sun = n_.below(2) ? n_.between(100, 800) : 0;
    for (int py = 0; py < kSkyHeight; ++py)
      for (int px = 0; px < kSkyWidth; ++px) {
        const float up = 1 - static_cast<float>(py) / (kSkyHeight / 2);
        Rgb c = up > 0 ? lerp(up, horizon, top) : Rgb{0.2f};
        if (px == sun_x && py == sun_y) c = c + Rgb{1, 0.9f, 0.7f} * sun;
        sky.image.set_rgb(px, py, c);
      }
  }

  Vec3 place(float room) {
    return {n_.between(room, size_.x - room), n_.between(room, size_.y - room),
            n_.between(room, size_.z - room)};
  }

  void add_thing() {
    const float angle = n_.between(0, kPi);
    switch (n_.below(5)) {
      case 0:
      case 1: {
        const Vec3 half{n_.between(0.1f, 0.5f), n_.between(0.1f, 0.7f), n_.between(0.1f, 0.5f)};
        Vec3 at = place(0.7f);
        at.y = half.y + 0.001f;
        add_box(any(), at, half, angle);
        break;
      }
      case 2:
      case 3: {
        const float r = n_.between(0.1f, 0.45f);
        Vec3 at = place(0.5f);
        if (n_.below(2)) at.y = r + 0.001f;
        add_sphere(any(), at, r);
        break;
      }
      default: {  // rails
        const MaterialId material = any();
        const Vec3 at = place(0.6f), step = Vec3{std::cos(angle), 0, -std::sin(angle)};
        const float height = n_.between(0.3f, 0.9f), gap = n_.between(0.03f, 0.12f);
        for (int i = -6; i <= 6; ++i)
          add_box(material, Vec3{at.x, height, at.z} + step * (gap * static_cast<float>(i)),
                  {0.008f, height, 0.008f}, angle);
        break;
      }
    }
  }

  Draws n_;
  Scene scene_;
  Vec3 size_;
  bool plain_ = false;  // nothing shines or mirrors
};

}  // namespace

Scene generated_scene(uint64_t seed) { return RoomMaker(seed).take(); }

}  // namespace qray
