#include "core/render/direction_cube.h"

#include <algorithm>
#include <vector>

namespace qray {
namespace {

struct Stroke {
  Vec2 a, b;                 // pixels
  float radius_a, radius_b;  // pixels, at either end: unequal ones make an arrow's head
  float depth;               // larger is nearer
  Rgb color;
};

// An orthographic view of the cube [-1.5, 1.5]^3 from the front, the right and above.
struct View {
  Vec3 right, up, toward;  // unit
  Vec2 center;             // pixels
  float scale;             // pixels a unit

  View(int width, int height) {
    toward = normalize({0.45f, 0.38f, 1.0f});
    right = normalize(cross({0, 1, 0}, toward));
    up = cross(toward, right);
    center = {static_cast<float>(width) / 2, static_cast<float>(height) / 2};
    scale = static_cast<float>(std::min(width, height)) / 4.6f;
  }
  Vec2 project(Vec3 p) const {
    return {center.x + dot(p, right) * scale, center.y - dot(p, up) * scale};
  }
};

float distance_to_cone(const Stroke& s, Vec2 p, float& along) {
  const Vec2 d = s.b - s.a, q = p - s.a;
  const float squared = d.x * d.x + d.y * d.y;
  along = squared > 0 ? std::clamp((q.x * d.x + q.y * d.y) / squared, 0.0f, 1.0f) : 0;
  return std::hypot(q.x - along * d.x, q.y - along * d.y) - lerp(along, s.radius_a, s.radius_b);
}

void paint(Image& image, const Stroke& s) {
  const float reach = std::max(s.radius_a, s.radius_b) + 1;
  const auto range = [&](float a, float b, int size) {
    return std::pair{std::max(0, static_cast<int>(std::min(a, b) - reach)),
                     std::min(size - 1, static_cast<int>(std::max(a, b) + reach))};
  };
  const auto [x0, x1] = range(s.a.x, s.b.x, image.width());
  const auto [y0, y1] = range(s.a.y, s.b.y, image.height());
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      float along = 0;
      const Vec2 p{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
      const float coverage = std::clamp(0.5f - distance_to_cone(s, p, along), 0.0f, 1.0f);
      if (coverage > 0) image.set_rgb(x, y, lerp(coverage, image.rgb(x, y), s.color));
    }
}

// The lines between the 27 cubes, in short pieces so that each is sorted by its own depth.
void add_grid(const View& view, std::vector<Stroke>& strokes) {
  constexpr int kPieces = 12;
  const float radius = view.scale * 0.008f;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const bool outside = i % 3 == 0 || j % 3 == 0;
        if (!outside) continue;
        Vec3 from, step;
        from[axis] = -1.5f;
        from[(axis + 1) % 3] = static_cast<float>(i) - 1.5f;
        from[(axis + 2) % 3] = static_cast<float>(j) - 1.5f;
        step[axis] = 3.0f / kPieces;
        for (int k = 0; k < kPieces; ++k) {
          const Vec3 a = from + step * static_cast<float>(k), b = a + step;
          const float depth = dot((a + b) * 0.5f, view.toward);
          const float haze = std::clamp(0.62f - 0.16f * depth, 0.25f, 0.9f);
          strokes.push_back({view.project(a), view.project(b), radius, radius, depth, Rgb{haze}});
        }
      }
}

// Arrows that point away from the eye may pale.
void add_arrow(const View& view, Vec3 direction, Rgb color, bool pales,
               std::vector<Stroke>& strokes) {
  constexpr int kPieces = 10;
  const float shaft = view.scale * 0.022f, head = view.scale * 0.075f;
  const Vec3 head_start = direction * (1 - 0.2f / length(direction));
  const float toward_eye = dot(direction, view.toward);
  const float pale = pales ? std::clamp(0.3f - 0.3f * toward_eye, 0.0f, 0.75f) : 0;
  const Rgb shade = lerp(pale, color, Rgb{0.85f});
  for (int k = 0; k < kPieces; ++k) {
    const Vec3 a = head_start * (static_cast<float>(k) / kPieces);
    const Vec3 b = head_start * (static_cast<float>(k + 1) / kPieces);
    strokes.push_back(
        {view.project(a), view.project(b), shaft, shaft, dot((a + b) * 0.5f, view.toward), shade});
  }
  strokes.push_back({view.project(head_start), view.project(direction), head, 0,
                     dot(direction, view.toward), shade});
}

Image draw(int width, int height, const std::array<Rgb, kDirections26>& colors, bool pale,
           Rgb background) {
  const View view(width, height);
  std::vector<Stroke> strokes;
  add_grid(view, strokes);
  size_t i = 0;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3 direction{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        add_arrow(view, direction, colors[i++], pale, strokes);
      }
  std::stable_sort(strokes.begin(), strokes.end(),
                   [](const Stroke& a, const Stroke& b) { return a.depth < b.depth; });
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.set_rgb(x, y, background);
  for (const Stroke& stroke : strokes) paint(image, stroke);
  return image;
}

}  // namespace

Image draw_direction_cube(int width, int height) {
  const Rgb through[3] = {{0.75f, 0.05f, 0.04f}, {0.03f, 0.42f, 0.08f}, {0.04f, 0.12f, 0.7f}};
  std::array<Rgb, kDirections26> colors;
  for (size_t i = 0; i < colors.size(); ++i) {
    const Vec3 d = directions26()[i];
    const int axes = (d.x != 0) + (d.y != 0) + (d.z != 0);
    colors[i] = through[axes - 1];
  }
  return draw(width, height, colors, /*pale=*/true, Rgb{1.0f});
}

Image draw_direction_cube(int width, int height, const std::array<Rgb, kDirections26>& colors) {
  return draw(width, height, colors, /*pale=*/false, Rgb{});
}

}  // namespace qray
