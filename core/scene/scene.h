// A scene as plain data: ids, not pointers. Made by import/, checked by validate(), immutable
// afterwards and shared by threads. Metres, right-handed, +y is up by custom.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/sha256.h"
#include "core/image/image.h"
#include "core/image/texture_cache.h"
#include "core/math/ray.h"
#include "core/scene/camera.h"
#include "core/scene/material.h"

namespace qray {

struct Mesh {
  std::string name;
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;                       // per vertex, unit; empty: flat
  std::vector<Vec2> uvs;                           // per vertex; empty: (0, 0)
  std::vector<std::array<uint32_t, 3>> triangles;  // counter-clockwise seen from the front
  MaterialId material;
};

struct Texture {
  std::filesystem::path path;  // absolute once loaded
  bool srgb = true;            // display-encoded, as 8-bit colour pictures are
  TextureWrap wrap = TextureWrap::kRepeat;
};

// Light from infinitely far. The image is latitude-longitude: its top row is +y, its centre is -z
// turned by `rotation_deg` about +y (counter-clockwise seen from above).
struct Environment {
  Rgb radiance;  // constant, or the image's factor
  Image image;   // 3 channels, linear; empty: constant
  std::filesystem::path image_path;
  float rotation_deg = 0;

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
  Environment environment;
  Camera camera;
  int width = 512, height = 512;  // the scene's customary picture size, pixels
  int max_depth = 16;             // surfaces on a path, at most

  size_t triangle_count() const {
    size_t count = 0;
    for (const Mesh& mesh : meshes) count += mesh.triangles.size();
    return count;
  }
  Bounds3 bounds() const {
    Bounds3 box;
    for (const Mesh& mesh : meshes)
      for (const auto& tri : mesh.triangles)
        for (uint32_t v : tri) box.add(mesh.positions[v]);
    return box;
  }
};

}  // namespace qray
