#include "core/render/surface_passes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/math/murmur.h"
#include "core/render/cryptomatte.h"
#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr int kWidth = 48, kHeight = 32;

RenderSettings asking_for(std::initializer_list<const char*> names) {
  RenderSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  for (const char* name : names) EXPECT_TRUE(settings.picture_passes.add(name)) << name;
  return settings;
}

SurfacePasses made(const PreparedScene& scene, const RenderSettings& settings,
                   const NeighbourFrames& neighbours = {}, int threads = 2) {
  TaskPool pool(threads);
  Result<SurfacePasses> passes = render_surface_passes(scene, settings, neighbours, pool, {});
  EXPECT_TRUE(passes.ok());
  return std::move(passes).value();
}

const PictureLayer& layer(const SurfacePasses& passes, const std::string& name) {
  for (const PictureLayer& one : passes.layers)
    if (one.name == name) return one;
  ADD_FAILURE() << "no layer " << name;
  return passes.layers.front();
}

Vec3 xyz(const PictureLayer& layer, int x, int y) {
  return {layer.image.at(x, y, 0), layer.image.at(x, y, 1), layer.image.at(x, y, 2)};
}

// The nearest triangle of the scene, one after the other (Moeller and Trumbore), in double
// precision; the ray from what a camera is, not from the renderer's.
struct Met {
  double t = INFINITY;
  size_t mesh = 0;
  Vec3 n;  // toward the eye
};
using Double3 = std::array<double, 3>;
Double3 wide(Vec3 v) { return {double{v.x}, double{v.y}, double{v.z}}; }
Double3 minus(Double3 a, Double3 b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot3(Double3 a, Double3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Double3 cross3(Double3 a, Double3 b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Double3 unit3(Double3 v) {
  const double size = std::sqrt(dot3(v, v));
  return {v[0] / size, v[1] / size, v[2] / size};
}

Met cast(const Scene& scene, Double3 o, Double3 d) {
  Met met;
  for (size_t m = 0; m < scene.meshes.size(); ++m)
    for (const auto& tri : scene.meshes[m].triangles) {
      const Double3 p0 = wide(scene.meshes[m].positions[tri[0]]);
      const Double3 e1 = minus(wide(scene.meshes[m].positions[tri[1]]), p0);
      const Double3 e2 = minus(wide(scene.meshes[m].positions[tri[2]]), p0);
      const Double3 n = cross3(e1, e2), away = minus(o, p0), q = cross3(away, d);
      const double det = -dot3(n, d);
      if (det == 0) continue;
      const double u = dot3(e2, q) / det, v = -dot3(e1, q) / det, t = dot3(n, away) / det;
      if (u < 0 || v < 0 || u + v > 1 || !(t > 1e-6) || t >= met.t) continue;
      const Double3 facing = unit3(n);
      const float sign = det > 0 ? 1.0f : -1.0f;
      met = {t, m,
             Vec3{static_cast<float>(facing[0]), static_cast<float>(facing[1]),
                  static_cast<float>(facing[2])} *
                 sign};
    }
  return met;
}

// Of a pinhole, through a pixel's middle; of depth 1 along its axis.
Double3 through(const Camera& camera, int x, int y) {
  const Double3 forward = unit3(minus(wide(camera.target), wide(camera.position)));
  const Double3 right = unit3(cross3(forward, wide(camera.up))), up = cross3(right, forward);
  const double half = std::tan(double{camera.vertical_fov_deg} * M_PI / 360);
  const double sx = (2 * (x + 0.5) / kWidth - 1) * half * kWidth / kHeight;
  const double sy = (1 - 2 * (y + 0.5) / kHeight) * half;
  return {forward[0] + sx * right[0] + sy * up[0], forward[1] + sx * right[1] + sy * up[1],
          forward[2] + sx * right[2] + sy * up[2]};
}

TEST(SurfacePasses, DepthAndNormalsAreThoseOfAnotherRayCaster) {
  Scene room = test::room();
  room.camera.up = {0.1f, 1, 0};
  const auto scene = test::prepare(room);
  const SurfacePasses passes = made(
      *scene,
      asking_for({"depth", "position", "normal", "geometric-normal", "mesh-id", "material-id"}));
  int edges = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Double3 o = wide(room.camera.position), d = through(room.camera, x, y);
      const Met met = cast(room, o, d);
      ASSERT_TRUE(std::isfinite(met.t));
      EXPECT_NEAR(layer(passes, "depth").image.at(x, y, 0), met.t, 2e-5 * met.t) << x << "," << y;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(xyz(layer(passes, "position"), x, y)[c],
                    o[static_cast<size_t>(c)] + met.t * d[static_cast<size_t>(c)], 2e-5);
      EXPECT_EQ(layer(passes, "mesh_id").image.at(x, y, 0), static_cast<float>(met.mesh + 1));
      EXPECT_EQ(layer(passes, "material_id").image.at(x, y, 0),
                static_cast<float>(room.meshes[met.mesh].material.value + 1));
      for (const char* name : {"normal", "geometric_normal"}) {
        const Vec3 n = xyz(layer(passes, name), x, y);
        if (length(n) < 0.9999f) {
          ++edges;  // a mean over several surfaces
          continue;
        }
        EXPECT_GT(dot(n, met.n), 0.9999f) << name << " " << x << "," << y;
      }
    }
  EXPECT_GT(edges, 20);
  EXPECT_LT(edges, kWidth * kHeight / 2);
}

TEST(SurfacePasses, WhereNothingIsTheySaySo) {
  Scene sky;
  const MaterialId grey = test::add_material(sky, Rgb{0.4f});
  test::add_quad(sky, grey, {-9, -1, -9}, {0, 0, 18}, {18, 0, 0});
  sky.environment.radiance = Rgb{1.0f};
  sky.camera.position = {0, 0, 5};
  const auto scene = test::prepare(sky);
  const SurfacePasses passes =
      made(*scene, asking_for({"albedo", "depth", "normal", "mesh-id", "cryptomatte-object"}));
  EXPECT_EQ(layer(passes, "depth").image.at(5, 0, 0), kNoDepth);
  EXPECT_EQ(layer(passes, "mesh_id").image.at(5, 0, 0), 0);
  EXPECT_EQ(layer(passes, "albedo").image.rgb(5, 0), Rgb{});
  EXPECT_EQ(layer(passes, "CryptoObject00").image.at(5, 0, 1), 0);
  EXPECT_NEAR(layer(passes, "albedo").image.rgb(5, kHeight - 1).r, 0.4f, 1e-6f);
  EXPECT_GT(xyz(layer(passes, "normal"), 5, kHeight - 1).y, 0.999f);
}

// The hashes of the specification's own table of names.
TEST(Cryptomatte, NamesHaveTheSpecificationsHashes) {
  EXPECT_EQ(murmur3_32(""), 0u);
  EXPECT_EQ(murmur3_32("hello"), 0x248bfa47u);
  EXPECT_EQ(murmur3_32("hello, world"), 0x149bbb7fu);
  EXPECT_EQ(murmur3_32("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
  EXPECT_EQ(cryptomatte_id("bunny"), 0x13851a76u);
}

TEST(Cryptomatte, CoverageSumsToOneAndTheManifestNamesEveryHash) {
  Scene room = test::room();
  for (size_t i = 0; i < room.meshes.size(); ++i)
    room.meshes[i].name = "side \"" + std::to_string(i) + "\"";
  const auto scene = test::prepare(room);
  const SurfacePasses passes =
      made(*scene, asking_for({"cryptomatte-object", "cryptomatte-material"}));
  for (const std::string kind : {"CryptoObject", "CryptoMaterial"}) {
    std::map<uint32_t, std::string> names;
    const std::string key = [&] {
      for (const auto& [name, value] : passes.metadata)
        if (name.ends_with("/name") && value == kind) return name.substr(0, name.rfind('/'));
      return std::string();
    }();
    EXPECT_EQ(passes.metadata.at(key + "/hash"), "MurmurHash3_32");
    EXPECT_EQ(passes.metadata.at(key + "/conversion"), "uint32_to_float32");
    const auto manifest = nlohmann::json::parse(passes.metadata.at(key + "/manifest"));
    for (const auto& [name, hash] : manifest.items()) {
      names[static_cast<uint32_t>(std::stoul(hash.get<std::string>(), nullptr, 16))] = name;
      EXPECT_EQ(cryptomatte_id(name), std::stoul(hash.get<std::string>(), nullptr, 16));
    }
    double several = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        float sum = 0, before = 1;
        for (int rank = 0; rank < Cryptomatte::kRanks; ++rank) {
          const PictureLayer& of = layer(passes, kind + "0" + std::to_string(rank / 2));
          const float id = of.image.at(x, y, rank % 2 * 2);
          const float covered = of.image.at(x, y, rank % 2 * 2 + 1);
          EXPECT_LE(covered, before);
          before = covered;
          sum += covered;
          EXPECT_TRUE(covered == 0 || names.contains(std::bit_cast<uint32_t>(id)));
          if (rank == 1 && covered > 0) ++several;
        }
        EXPECT_NEAR(sum, 1, 1e-6f) << kind << " " << x << "," << y;
      }
    EXPECT_GT(several, 10) << kind;
  }
}

TEST(SurfacePasses, MotionIsHowFarAPointGoesUntilTheNextFrame) {
  const Scene room = test::room();
  Camera next = room.camera;
  next.position.x += 0.1f;
  next.target.x += 0.1f;
  const auto scene = test::prepare(room);
  const SurfacePasses passes = made(*scene, asking_for({"motion", "depth"}), {{}, {&next}});
  const float pixels_at_1m = kHeight / (2 * std::tan(room.camera.vertical_fov_deg * kPi / 360));
  for (int x = 0; x < kWidth; x += 5) {
    const float depth = layer(passes, "depth").image.at(x, 9, 0);
    EXPECT_NEAR(layer(passes, "forward").image.at(x, 9, 0), -0.1f * pixels_at_1m / depth, 1e-3f);
    EXPECT_NEAR(layer(passes, "forward").image.at(x, 9, 1), 0, 1e-3f);
    EXPECT_EQ(layer(passes, "backward").image.at(x, 9, 0), 0) << "there is no frame before";
  }
}

// A box that moves before a camera that stands, and a ball that rolls.
TEST(SurfacePasses, MotionIsOfSurfacesToo) {
  constexpr size_t kBox = 6, kLamp = 12, kBall = 13;  // the first of the box' six sides
  const Vec3 step{0.05f, 0.02f, -0.01f}, middle{-0.4f, 0.5f, 0.2f};
  Scene before = test::room();
  Mesh& ball = before.meshes.emplace_back();
  ball.material = MaterialId(0);
  ball.sphere.emplace();
  ball.sphere->center = middle;
  ball.sphere->radius = 0.3f;
  ASSERT_EQ(before.meshes.size(), kBall + 1);
  Scene after = before;
  const Transform rolls = Transform::translation(middle)
                              .after(Transform::rotation({0, 0, 1}, 10))
                              .after(Transform::translation(-middle));
  for (size_t side = kBox; side < kLamp; ++side)
    Transform::translation(step).apply(after.meshes[side]);
  rolls.apply(after.meshes[kBall]);
  const auto now = test::prepare(before), then = test::prepare(after);
  const SurfacePasses passes = made(*now, asking_for({"motion", "position", "mesh-id"}),
                                    {{}, {&now->scene.camera, then.get()}});
  const CameraRays camera(now->scene.camera, kWidth, kHeight);
  std::map<size_t, int> seen;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Vec3 p = xyz(layer(passes, "position"), x, y);
      const auto mesh = static_cast<size_t>(layer(passes, "mesh_id").image.at(x, y, 0)) - 1;
      const bool box = mesh >= kBox && mesh < kLamp, rolling = mesh == kBall;
      const Vec3 there = box ? p + step : rolling ? rolls.point(p) : p;
      const Vec2 from = *camera.project(p), to = *camera.project(there);
      const Image& forward = layer(passes, "forward").image;
      EXPECT_NEAR(forward.at(x, y, 0), to.x - from.x, 2e-3f) << x << "," << y;
      EXPECT_NEAR(forward.at(x, y, 1), from.y - to.y, 2e-3f) << x << "," << y;
      EXPECT_TRUE(box || rolling || forward.at(x, y, 0) == 0) << x << "," << y;
      ++seen[box ? kBox : rolling ? kBall : 0];
    }
  EXPECT_GT(seen[kBox], 20);
  EXPECT_GT(seen[kBall], 20);
}

TEST(SurfacePasses, SameBitsForAnyNumberOfThreads) {
  const auto scene = test::included_scene("cornell-box");
  RenderSettings settings = asking_for({"all"});
  const SurfacePasses one = made(*scene, settings, {}, 1), three = made(*scene, settings, {}, 3);
  ASSERT_EQ(one.layers.size(), three.layers.size());
  for (size_t i = 0; i < one.layers.size(); ++i)
    EXPECT_TRUE(test::same_bits(one.layers[i].image, three.layers[i].image)) << one.layers[i].name;
  EXPECT_EQ(one.metadata, three.metadata);
}

}  // namespace
}  // namespace qray
