// Mitsuba's shapes in the world, uvs with v upward. Spheres are exact ones, unless they are
// stretched or instanced; these, disks and cylinders are triangles of the exact area in all, so
// that as lights they have the exact power. Throws ImportFailure.
#pragma once

#include "core/import/mitsuba_import.h"
#include "core/import/serialized.h"

namespace qray {

class MitsubaShapes {
 public:
  explicit MitsubaShapes(MitsubaImport& import);
  // The meshes of a <shape>, materials unset; empty: an unknown plugin, of which was warned.
  // `instanced`: they are made of triangles alone.
  std::vector<Mesh> read(const MitsubaNode& shape, bool instanced);

 private:
  std::vector<Mesh> read_object_space(const MitsubaNode& shape, bool exact);
  std::vector<Mesh> read_file_shape(const MitsubaNode& shape);
  std::vector<Mesh> read_mesh_file(const MitsubaNode& shape, const std::filesystem::path& path);
  SerializedShape read_serialized_shape(const MitsubaNode& shape,
                                        const std::filesystem::path& path);

  MitsubaImport& import_;
  int sphere_rings_ = 0;
  std::map<std::string, int> uses_;  // of each file name, that are still to come
  std::map<std::filesystem::path, std::vector<Mesh>> meshes_;  // of files used again
  std::filesystem::path serialized_path_;
  Bytes serialized_;  // the newest such file: it holds many shapes
};

}  // namespace qray
