#include "core/import/load_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "core/import/fit_camera.h"
#include "core/import/gltf_scene.h"
#include "core/import/json_scene.h"
#include "core/import/mitsuba_scene.h"
#include "core/import/obj.h"
#include "core/import/ply.h"
#include "core/scene/scene_hash.h"
#include "core/scene/surface.h"

namespace qray {
namespace {

ImportedScene from_obj(const std::filesystem::path& path, const LoadOptions& options) {
  ObjContents contents = read_obj(path, options.limits, options.watch);
  ImportedScene out;
  out.scene.meshes = std::move(contents.meshes);
  out.scene.materials = std::move(contents.materials);
  out.scene.textures = std::move(contents.textures);
  out.warnings = std::move(contents.warnings);
  return out;
}

ImportedScene from_ply(const std::filesystem::path& path, const SceneLimits& limits) {
  ImportedScene out;
  out.scene.meshes.push_back(read_ply(path, limits));
  out.scene.meshes.back().material = MaterialId(0);
  out.scene.materials.emplace_back().name = "grey";
  return out;
}

bool has_light(const Scene& scene) {
  if (scene.environment.present()) return true;
  for (const PunctualLight& light : scene.lights)
    if (light.emits()) return true;
  for (const Placement& placed : scene.placements()) {
    if (placed.mesh && placed.material.value < scene.materials.size() &&
        scene.materials[placed.material.value].emits())
      return true;
  }
  return false;
}

// Rays start off their surface by kRayOffset of its distance from the origin: more than a
// thousandth of the scene begins to show.
void warn_of_distance(const Scene& scene, const std::string& file,
                      std::vector<std::string>& warnings) {
  const Bounds3 box = scene.bounds();
  float largest = 0, widest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max({largest, std::abs(box.lo[axis]), std::abs(box.hi[axis])});
    widest = std::max(widest, box.hi[axis] - box.lo[axis]);
  }
  if (largest * kRayOffset <= 1e-3f * widest) return;
  char text[160];
  std::snprintf(text, sizeof text,
                ": %g m wide, but %g m from the origin, where positions are held to %.2g m: "
                "move it nearer",
                double{widest}, double{largest},
                double{std::nextafter(largest, 2 * largest) - largest});
  warnings.push_back(file + text);
}

// A view and a light for formats that have none.
void complete(Scene& scene, const std::filesystem::path& path) {
  scene.name = path.stem();
  scene.camera = fit_camera(scene);
  if (!has_light(scene)) scene.environment.radiance = Rgb{1.0f};
}

// "/meshes/4/positions/7" counts the scene's meshes; the document's may be fewer. Instances alike.
std::string document_pointer(const std::string& pointer, const ImportedScene& read) {
  for (const auto& [prefix, pointers] :
       {std::pair{"/meshes/", &read.mesh_pointers}, {"/instances/", &read.instance_pointers}}) {
    const size_t begin = std::strlen(prefix);
    if (pointers->empty() || !pointer.starts_with(prefix)) continue;
    const size_t end = pointer.find('/', begin);
    const size_t index = std::stoul(pointer.substr(begin, end - begin));
    return (*pointers)[index] + (end == std::string::npos ? "" : pointer.substr(end));
  }
  return pointer;
}

ImportedScene read_any(const std::filesystem::path& path, const LoadOptions& options) {
  const SceneLimits& limits = options.limits;
  const std::string extension = path.extension();
  if (extension == ".json") {
    ImportedScene read = read_json_scene(path, limits, options.watch, options.seconds);
    if (read.scene.name.empty()) read.scene.name = path.parent_path().filename();
    return read;
  }
  if (extension == ".xml") {
    ImportedScene read = read_mitsuba_scene(path, limits, options.watch);
    read.scene.name = std::filesystem::absolute(path).parent_path().filename();
    return read;
  }
  if (extension == ".gltf" || extension == ".glb") {
    ImportedScene read = read_gltf_scene(path, limits, options.watch, options.seconds);
    read.scene.name = path.stem();
    return read;
  }
  ImportedScene read;
  if (extension == ".obj")
    read = from_obj(path, options);
  else if (extension == ".ply")
    read = from_ply(path, limits);
  else
    fail_import(ErrorCode::kUnsupported, "expected a .json, .xml, .gltf, .glb, .obj or .ply file",
                path.filename());
  complete(read.scene, path);
  return read;
}

}  // namespace

Result<LoadedScene> load_scene(const std::filesystem::path& path, const LoadOptions& options) {
  try {
    ImportedScene read = read_any(path, options);
    read.add_counts_to_warnings();
    if (options.strict && !read.warnings.empty())
      return Error{ErrorCode::kUnsupported, read.warnings.front(), ""};
    const std::string file = path.filename();
    const Result<ValidateReport> report = validate(read.scene, options.limits);
    if (!report.ok()) {
      Error error = report.error();
      error.where = file + ":" + document_pointer(error.where, read);
      return error;
    }
    if (!has_light(read.scene)) read.warnings.push_back(file + ": nothing emits light");
    warn_of_distance(read.scene, file, read.warnings);
    Result<SceneHash> hash = hash_scene(read.scene);
    if (!hash.ok()) return hash.error();
    return LoadedScene{std::move(read.scene), hash.value(), report.value().dropped_triangles,
                       std::move(read.warnings)};
  } catch (const ImportFailure& failure) {
    return failure.error;
  } catch (const std::exception&) {
    // A parser's own exception, or memory: nothing of its text goes further.
    return Error{ErrorCode::kInvalid, "cannot be read", path.filename()};
  }
}

}  // namespace qray
