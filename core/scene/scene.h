// A scene as plain data: ids, not pointers. Made by import/, checked by validate(), immutable
// afterwards and shared by threads. Metres, right-handed, +y is up by custom.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/byte_io.h"
#include "core/base/ids.h"
#include "core/base/sha256.h"
#include "core/image/image.h"
#include "core/image/texture_cache.h"
#include "core/math/mat3.h"
#include "core/math/ray.h"
#include "core/scene/camera.h"
#include "core/scene/light.h"
#include "core/scene/material.h"
#include "core/scene/sphere.h"
#include "core/scene/transform.h"

namespace qray {

// Triangles, or a sphere: then there are no vertices.
struct Mesh {
  std::string name;
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;                       // per vertex, unit; empty: flat
  std::vector<Vec2> uvs;                           // per vertex; empty: (0, 0)
  std::vector<Vec2> second_uvs;                    // for textures that ask for them
  std::vector<Rgb> colors;                         // per vertex, times reflectance; empty: white
  std::vector<std::array<uint32_t, 3>> triangles;  // counter-clockwise seen from the front
  std::optional<Sphere> sphere;                    // instead; no instance may name it
  MaterialId material;

  bool empty() const { return triangles.empty() && !sphere; }
};

// A mesh placed once more. A mesh that instances name is seen by these alone, any other where
// its positions are. A mirroring map keeps fronts in front.
struct Instance {
  MeshId mesh;
  Transform to_world;
  MaterialId material;  // instead of the mesh's; none: the mesh's
};

// A mesh in the scene's space.
struct Placement {
  const Mesh* mesh;           // null: the mesh is seen by its instances alone
  const Transform* to_world;  // null: as it is
  MaterialId material;

  Vec3 at(Vec3 p) const { return to_world ? to_world->point(p) : p; }
};

// Light from infinitely far. The image is latitude-longitude: its top row is +y, its centre is -z,
// turned by `to_world`.
struct Environment {
  Rgb radiance;  // constant, or the image's factor
  Image image;   // 3 channels, linear; empty: constant
  std::filesystem::path image_path;
  Mat3 to_world;            // of the image's directions: a rotation, perhaps with a mirroring
  std::string light_group;  // empty: none

  bool present() const { return max_component(radiance) > 0; }
};

// Separate so that a table can say what changed (design: reuse by kind of change).
struct SceneHash {
  Digest geometry, materials, lights;
  Digest whole() const;  // of the three
  bool operator==(const SceneHash&) const = default;
};

struct Scene {
  std::string name;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<Instance> instances;
  std::vector<PunctualLight> lights;
  Environment environment;
  Camera camera;
  std::vector<NamedCamera> cameras;  // all that its file names, each name once
  int width = 512, height = 512;     // the scene's customary picture size, pixels
  int max_depth = 16;                // surfaces on a path, at most
  // The scene is as it is at rest; its file may say how it moves (core/scene/motion.h).
  double motion_seconds = 0;                      // for so long; 0: nothing does
  bool moves_surfaces = false;                    // or lights: load_scene() has them at a time
  std::shared_ptr<const CameraPath> camera_path;  // of `camera`; null: it never moves

  // Named so, or so with a number where another has that name; by its number without a name.
  void add_camera(std::string name, const Camera& view,
                  std::shared_ptr<const CameraPath> path = nullptr);
  const NamedCamera* find_camera(std::string_view name) const;  // null: there is none

  // By the index that hits tell: the meshes, then the instances.
  std::vector<Placement> placements() const;
  size_t sphere_count() const;
  size_t triangle_count() const;         // as stored
  size_t placed_triangle_count() const;  // as seen
  Bounds3 bounds() const;                // an instance's: of its mesh's box
};

}  // namespace qray
