#include "core/render/surface_passes.h"

#include <algorithm>
#include <array>

#include "core/render/cryptomatte.h"
#include "core/render/pixel_sampler.h"
#include "core/render/surface_motion.h"

namespace qray {
namespace {

constexpr float kSameSurface = 0.9f;  // least cosine of its normals

// What a ray meets first.
struct Look {
  int mesh = -1;  // Hit::mesh; -1: nothing
  int material = -1;
  Rgb albedo;
  Vec3 p, ng, ns;  // the normals toward the eye
  Vec2 uv;
  Hit hit;
};

bool differ(const Look& a, const Look& b) {
  return a.mesh != b.mesh || (a.mesh >= 0 && dot(a.ns, b.ns) < kSameSurface);
}

class SurfaceLooks {
 public:
  SurfaceLooks(const PreparedScene& scene, const RenderSettings& settings)
      : scene_(scene),
        seed_(settings.seed),
        camera_(settings.camera.value_or(scene.scene.camera), settings.width, settings.height) {
    for (const Placement& placement : scene.scene.placements())
      materials_.push_back(static_cast<int>(placement.material.value));
  }
  const CameraRays& camera() const { return camera_; }

  // Through the pixel's middle.
  Look middle(int x, int y) const {
    constexpr float kHalf = 0.5f;
    return look(
        camera_.ray({static_cast<float>(x) + kHalf, static_cast<float>(y) + kHalf}, {kHalf, kHalf}),
        kHalf);
  }
  // Of the render's first samples; the last of them alone where all before see one surface.
  std::span<const Look> many(int x, int y, std::array<Look, kManyPassRays>& looks) const {
    Sampler sampler(seed_);
    int count = 0;
    bool edge = false;
    for (; count < kManyPassRays; ++count) {
      if (count == kFewPassRays && !edge) break;
      sampler.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                    static_cast<uint32_t>(count));
      const Ray ray = pixel_ray(camera_, x, y, sampler);
      Look& one = looks[static_cast<size_t>(count)] = look(ray, sampler.next_2d().x);
      edge |= differ(one, looks[0]);
    }
    return std::span(looks).first(static_cast<size_t>(count));
  }

 private:
  Look look(const Ray& ray, float u_blend) const {
    Look out;
    Hit& hit = out.hit;
    if (!scene_.accel->intersect(ray, hit)) return out;
    const MeshShading& mesh = scene_.meshes[hit.mesh.value];
    const SurfacePoint at = scene_.surface_at(ray, hit, camera_.cone().at(hit.t));
    const MaterialShading& material = scene_.resolve(mesh, at.uv, u_blend);
    const bool from_behind = dot(at.ng, ray.d) > 0;
    const Vec3 ns = from_behind ? -at.ns : at.ns;
    const Frame frame = scene_.frame_at(material, hit, at.ns, at.uv);
    ShadingPoint room;
    const BsdfPoint bsdf_at =
        material.bsdf->at(scene_.shading_point(material, at, room), frame.to_local(-ray.d));
    out.mesh = static_cast<int>(hit.mesh.value);
    out.material = materials_[hit.mesh.value];
    out.albedo = material.bsdf->albedo(bsdf_at);
    out.p = at.p;
    out.ng = from_behind ? -at.ng : at.ng;
    out.ns = ns;
    SurfacePoint vertices;
    interpolate_vertices(*mesh.mesh, hit.triangle, hit.barycentric, vertices);
    out.uv = vertices.uv.uv;
    return out;
  }

  const PreparedScene& scene_;
  const uint64_t seed_;
  const CameraRays camera_;
  std::vector<int> materials_;  // by Hit::mesh
};

// The layers that are asked for, and how a pixel's looks fill them.
class Layers {
 public:
  Layers(const PreparedScene& scene, const RenderSettings& settings,
         const NeighbourFrames& neighbours)
      : scene_(scene),
        settings_(settings),
        after_(neighbours.after, settings),
        before_(neighbours.before, settings) {
    albedo_ = add(PicturePass::kAlbedo, "albedo", "RGB");
    normal_ = add(PicturePass::kNormal, "normal", "XYZ");
    geometric_ = add(PicturePass::kGeometricNormal, "geometric_normal", "XYZ");
    depth_ = add(PicturePass::kDepth, "depth", "Z");
    position_ = add(PicturePass::kPosition, "position", "XYZ");
    uv_ = add(PicturePass::kUv, "uv", "UV");
    mesh_ = add(PicturePass::kMeshId, "mesh_id", "X");
    material_ = add(PicturePass::kMaterialId, "material_id", "X");
    forward_ = add(PicturePass::kMotion, "forward", "uv");
    backward_ = add(PicturePass::kMotion, "backward", "uv");
    if (wants(PicturePass::kCryptomatteObject))
      objects_.emplace(settings.width, settings.height, "CryptoObject", object_names(scene.scene));
    if (wants(PicturePass::kCryptomatteMaterial))
      of_materials_.emplace(settings.width, settings.height, "CryptoMaterial",
                            material_names(scene.scene));
  }

  // Those that are averaged over a pixel.
  bool any_mean() const { return albedo_ || normal_ || geometric_ || objects_ || of_materials_; }
  bool any_of_middle() const {
    return depth_ || position_ || uv_ || mesh_ || material_ || forward_;
  }

  void put_mean(int x, int y, std::span<const Look> looks) {
    Rgb albedo;
    Vec3 ns, ng;
    std::array<int, kManyPassRays> meshes, materials;
    for (size_t i = 0; i < looks.size(); ++i) {
      albedo += looks[i].albedo;
      ns = ns + looks[i].ns;
      ng = ng + looks[i].ng;
      meshes[i] = looks[i].mesh;
      materials[i] = looks[i].material;
    }
    const float share = 1 / static_cast<float>(looks.size());
    if (albedo_) image(albedo_).set_rgb(x, y, albedo * share);
    if (normal_) put(normal_, x, y, ns * share);
    if (geometric_) put(geometric_, x, y, ng * share);
    if (objects_) objects_->set(x, y, std::span(meshes).first(looks.size()));
    if (of_materials_) of_materials_->set(x, y, std::span(materials).first(looks.size()));
  }

  void put_middle(int x, int y, const Look& look, const CameraRays& camera) {
    const bool met = look.mesh >= 0;
    if (depth_) image(depth_).at(x, y, 0) = met ? camera.depth(look.p) : kNoDepth;
    if (position_) put(position_, x, y, met ? look.p : Vec3{kNoDepth, kNoDepth, kNoDepth});
    if (uv_) put(uv_, x, y, look.uv);
    if (mesh_) image(mesh_).at(x, y, 0) = static_cast<float>(look.mesh + 1);
    if (material_) image(material_).at(x, y, 0) = static_cast<float>(look.material + 1);
    if (!forward_ || !met) return;
    put(forward_, x, y, moved(camera, after_, look));
    put(backward_, x, y, moved(camera, before_, look));
  }

  SurfacePasses take() {
    SurfacePasses out{std::move(layers_), {}};
    for (std::optional<Cryptomatte>* matte : {&objects_, &of_materials_}) {
      if (!*matte) continue;
      out.metadata.merge((*matte)->metadata());
      for (PictureLayer& layer : (*matte)->take_layers()) out.layers.push_back(std::move(layer));
    }
    return out;
  }

 private:
  using Index = std::optional<size_t>;

  bool wants(PicturePass pass) const { return settings_.picture_passes.has(pass); }
  Index add(PicturePass pass, const char* name, const char* channels) {
    if (!wants(pass)) return {};
    PictureLayer layer{name, channels, {}};
    layer.image = Image(settings_.width, settings_.height, static_cast<int>(layer.channels.size()));
    layers_.push_back(std::move(layer));
    return layers_.size() - 1;
  }
  Image& image(Index layer) { return layers_[*layer].image; }
  void put(Index layer, int x, int y, Vec3 v) {
    for (int c = 0; c < 3; ++c) image(layer).at(x, y, c) = v[c];
  }
  void put(Index layer, int x, int y, Vec2 v) {
    image(layer).at(x, y, 0) = v.x;
    image(layer).at(x, y, 1) = v.y;
  }
  struct Other {
    Other(const NeighbourFrame& frame, const RenderSettings& settings) : scene(frame.scene) {
      if (frame.camera) camera.emplace(*frame.camera, settings.width, settings.height);
    }
    std::optional<CameraRays> camera;
    const PreparedScene* scene;
  };
  // Pixels to the right and upward from where the point is to where the other frame shows it.
  Vec2 moved(const CameraRays& camera, const Other& other, const Look& look) const {
    if (!other.camera) return {};
    Vec3 then = look.p;
    if (other.scene)
      then += surface_motion(scene_, look.hit, look.p, *other.scene).value_or(Vec3{});
    const std::optional<Vec2> here = camera.project(look.p), there = other.camera->project(then);
    if (!here || !there) return {};
    return {there->x - here->x, here->y - there->y};
  }

  const PreparedScene& scene_;
  const RenderSettings& settings_;
  std::vector<PictureLayer> layers_;
  Index albedo_, normal_, geometric_, depth_, position_, uv_, mesh_, material_, forward_, backward_;
  Other after_, before_;
  std::optional<Cryptomatte> objects_, of_materials_;
};

std::string or_numbered(const std::string& name, const char* kind, size_t number) {
  return name.empty() ? kind + std::string(" ") + std::to_string(number) : name;
}

}  // namespace

// An instance is called as its mesh, with its number among the instances.
std::vector<std::string> object_names(const Scene& scene) {
  std::vector<std::string> names;
  for (size_t i = 0; i < scene.meshes.size(); ++i)
    names.push_back(or_numbered(scene.meshes[i].name, "mesh", i));
  for (size_t i = 0; i < scene.instances.size(); ++i)
    names.push_back(names[scene.instances[i].mesh.value] + "/" + std::to_string(i));
  return names;
}

std::vector<std::string> material_names(const Scene& scene) {
  std::vector<std::string> names;
  for (size_t i = 0; i < scene.materials.size(); ++i)
    names.push_back(or_numbered(scene.materials[i].name, "material", i));
  return names;
}

Result<SurfacePasses> render_surface_passes(const PreparedScene& scene,
                                            const RenderSettings& settings,
                                            const NeighbourFrames& neighbours, TaskPool& pool,
                                            std::stop_token stop) {
  const SurfaceLooks looks(scene, settings);
  Layers layers(scene, settings, neighbours);
  pool.run(static_cast<size_t>(settings.height), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    std::array<Look, kManyPassRays> seen;
    for (int x = 0; x < settings.width && !stop.stop_requested(); ++x) {
      if (layers.any_mean()) layers.put_mean(x, y, looks.many(x, y, seen));
      if (layers.any_of_middle()) layers.put_middle(x, y, looks.middle(x, y), looks.camera());
    }
  });
  if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
  return layers.take();
}

}  // namespace qray
