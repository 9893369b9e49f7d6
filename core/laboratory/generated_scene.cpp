#include "core/laboratory/generated_scene.h"

#include <array>
#include <cmath>

#include "core/math/hash.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr int kWallCells = 64;  // a side of a wall's pattern
constexpr int kSphereRings = 24, kSphereSides = 48;
constexpr int kLatheRings = 20;
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

// A colour for each corner of each cell of a wall.
class Pattern {
 public:
  explicit Pattern(Draws& n)
      : kind_(n.below(8)),
        period_(1 << n.below(5)),
        seed_(static_cast<uint64_t>(n.below(1 << 20))),
        a_(n.colour(0.05f, 0.9f)),
        b_(n.colour(0.05f, 0.9f)) {
    if (kind_ < kPaint) a_ = n.colour(0.5f, 0.9f);
  }
  // Of the cell (x, y), the corner (i, k) of 0 and 1.
  Rgb at(int x, int y, int i, int k) const {
    const int column = x / period_, row = y / period_;
    switch (std::max(kind_, kPaint)) {
      case kPaint:
        return a_;
      case kPaint + 1:
        return (column + row) % 2 ? a_ : b_;
      case kPaint + 2:
        return column % 2 ? a_ : b_;
      case kPaint + 3:
        return lerp(random(column, row), a_, b_);
      default: {  // clouds, or grain along one direction
        const bool grain = period_ > 4;
        float sum = 0, share = 0.5f;
        for (int size = 16; size >= 1; size /= 2, share /= 2)
          sum += share * smooth(grain ? static_cast<float>(x + i) / (8 * kWallCells)
                                      : static_cast<float>(x + i) / static_cast<float>(size),
                                static_cast<float>(y + k) / static_cast<float>(size));
        return lerp(sum, a_, b_);
      }
    }
  }

 private:
  static constexpr int kPaint = 3;  // and what is less: one colour
  float random(int x, int y) const {
    return to_unit_float(
        static_cast<uint32_t>(mix64(seed_ + static_cast<uint64_t>(x * 4096 + y)) >> 32));
  }
  // Between random values at whole numbers.
  float smooth(float x, float y) const {
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const float u = x - static_cast<float>(column), v = y - static_cast<float>(row);
    return lerp(v, lerp(u, random(column, row), random(column + 1, row)),
                lerp(u, random(column, row + 1), random(column + 1, row + 1)));
  }

  int kind_, period_;
  uint64_t seed_;
  Rgb a_, b_;
};

class RoomMaker {
 public:
  explicit RoomMaker(uint64_t seed) : n_(seed) {
    scene_.name = "generated " + std::to_string(seed);
    size_ = {n_.between(2.5f, 6), n_.between(2.2f, 3.5f), n_.between(2.5f, 6)};
    plain_ = n_.below(4) == 0;
    add_walls_and_light();
    const int things = 10 + n_.below(40);
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
  // Of furniture: what is more common in rooms is more common here. Clear glass is for closed
  // shapes.
  MaterialId any(bool closed = true) {
    Material m;
    m.reflectance.value = n_.colour(0.05f, 0.9f);
    switch (plain_ ? kMatt : n_.below(10)) {
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
        if (!closed) break;
        m.kind = MaterialKind::kDielectric;
        m.ior = n_.between(1.3f, 1.7f);
        m.transmittance.value = n_.colour(0.7f, 1);
        break;
      case 5:
      case 6:  // as most glTF files have them
        m.kind = MaterialKind::kPrincipled;
        m.roughness.value = n_.between(0.1f, 1);
        m.metallic.value = n_.below(4) ? 0.0f : 1.0f;
        m.clearcoat.value = n_.below(4) ? 0.0f : 1.0f;
        m.clearcoat_roughness.value = 0.05f;
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
          if (pattern) mesh.colors.push_back(pattern->at(x, y, i, k));
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

  // A surface of revolution about the vertical: a vase, a tub, a lamp's foot.
  void add_lathe(MaterialId material, Vec3 foot, float height, float radius) {
    const float bulge = n_.between(0.1f, 0.45f), waves = n_.between(0.5f, 2),
                turn = n_.between(0, 6);
    Mesh mesh;
    mesh.material = material;
    for (int ring = 0; ring <= kLatheRings; ++ring)
      for (int side = 0; side <= kSphereSides; ++side) {
        const float up = static_cast<float>(ring) / kLatheRings;
        const float angle = 2 * kPi * static_cast<float>(side) / kSphereSides;
        const float phase = turn + 2 * kPi * waves * up;
        const float r = radius * (1 - bulge + bulge * std::sin(phase));
        const float slope = radius * bulge * 2 * kPi * waves * std::cos(phase) / height;
        mesh.positions.push_back(foot +
                                 Vec3{r * std::cos(angle), height * up, -r * std::sin(angle)});
        mesh.normals.push_back(normalize(Vec3{std::cos(angle), -slope, -std::sin(angle)}));
      }
    for (uint32_t ring = 0; ring < kLatheRings; ++ring)
      for (uint32_t side = 0; side < kSphereSides; ++side) {
        const uint32_t a = ring * (kSphereSides + 1) + side, b = a + kSphereSides + 1;
        mesh.triangles.push_back({a, a + 1, b + 1});
        mesh.triangles.push_back({a, b + 1, b});
      }
    scene_.meshes.push_back(std::move(mesh));
  }

  // A top on four legs.
  void add_table(Vec3 at) {
    const MaterialId material = any();
    const Vec3 half{n_.between(0.2f, 0.8f), n_.between(0.01f, 0.03f), n_.between(0.2f, 0.5f)};
    const float height = n_.between(0.3f, 0.9f), leg = n_.between(0.01f, 0.04f);
    add_box(material, {at.x, height, at.z}, half, 0);
    for (const float x : {-1.0f, 1.0f})
      for (const float z : {-1.0f, 1.0f})
        add_box(material,
                {at.x + x * (half.x - leg), 0.5f * (height - half.y), at.z + z * (half.z - leg)},
                {leg, 0.5f * (height - half.y) - 0.001f, leg}, 0);
    for (int i = n_.below(5); i > 0; --i)
      add_lathe(any(false),
                {at.x + n_.between(-0.8f, 0.8f) * half.x, height + half.y + 0.001f,
                 at.z + n_.between(-0.8f, 0.8f) * half.z},
                n_.between(0.05f, 0.3f), n_.between(0.03f, 0.1f));
  }

  // Boards with books on them.
  void add_shelf(Vec3 at) {
    const MaterialId wood = any(false);
    const float wide = n_.between(0.3f, 0.8f), deep = 0.15f, step = n_.between(0.25f, 0.4f);
    const int boards = 2 + n_.below(4);
    for (const float side : {-1.0f, 1.0f})
      add_box(wood, {at.x + side * wide, 0.5f * step * static_cast<float>(boards), at.z},
              {0.012f, 0.5f * step * static_cast<float>(boards), deep}, 0);
    for (int board = 0; board < boards; ++board) {
      const float y = 0.05f + step * static_cast<float>(board);
      add_box(wood, {at.x, y, at.z}, {wide - 0.013f, 0.01f, deep}, 0);
      for (float x = at.x - wide + 0.03f; x < at.x + wide - 0.08f;) {
        const float thick = n_.between(0.01f, 0.03f), tall = n_.between(0.3f, 0.42f) * step;
        if (n_.below(5))
          add_box(matt(n_.colour(0.05f, 0.8f)), {x + thick, y + 0.011f + tall, at.z},
                  {thick - 0.001f, tall, n_.between(0.06f, 0.12f)}, 0);
        x += 2 * thick;
      }
    }
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
    // Where light is rare there is most to learn.
    constexpr int kLights[] = {0, 1, 2, 3, 3, 4, 4, 5, 6, 7};
    const int light = kLights[n_.below(10)];
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
      if (light > 5 && i == 5) {
        add_wall_with_window(white, pattern);
        continue;
      }
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

  // The wall at the largest z, and what is in its window.
  void add_wall_with_window(MaterialId white, const Pattern& pattern) {
    const float x0 = n_.between(0.05f, 0.4f) * size_.x, x1 = n_.between(0.6f, 0.95f) * size_.x;
    const float y0 = n_.between(0.02f, 0.4f) * size_.y, y1 = n_.between(0.6f, 0.95f) * size_.y;
    const auto part = [&](float left, float right, float low, float high) {
      add_wall(white, {left, low, size_.z}, {0, high - low, 0}, {right - left, 0, 0}, &pattern);
    };
    part(0, x0, 0, size_.y);
    part(x1, size_.x, 0, size_.y);
    part(x0, x1, 0, y0);
    part(x0, x1, y1, size_.y);
    const float x = 0.5f * (x0 + x1), y = 0.5f * (y0 + y1), wide = 0.5f * (x1 - x0),
                tall = 0.5f * (y1 - y0);
    const MaterialId frame = any(false);
    if (n_.below(2)) add_box(frame, {x, y, size_.z}, {0.02f, tall, 0.02f}, 0);
    if (n_.below(2)) add_box(frame, {x, y, size_.z + 0.05f}, {wide, 0.02f, 0.02f}, 0);
    if (n_.below(4) == 0)  // a blind
      for (float at = y0 + 0.03f; at < y1; at += 0.06f)
        add_box(frame, {x, at, size_.z - 0.1f}, {wide, 0.004f, 0.02f}, 0);
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
    switch (n_.below(8)) {
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
      case 4:
        add_table(place(0.9f));
        break;
      case 5:
        add_shelf(place(0.9f));
        break;
      case 6: {
        const Vec3 at = place(0.7f);
        add_lathe(any(false), {at.x, 0.001f, at.z}, n_.between(0.2f, 1.2f), n_.between(0.1f, 0.4f));
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

  static constexpr int kMatt = 9;
  Draws n_;
  Scene scene_;
  Vec3 size_;
  bool plain_ = false;  // nothing shines or mirrors
};

}  // namespace

Scene generated_scene(uint64_t seed) { return RoomMaker(seed).take(); }

}  // namespace qray
