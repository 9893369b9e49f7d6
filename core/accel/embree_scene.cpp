#include "core/accel/embree_scene.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace qray {
namespace {

// AVX2 beat the AVX-512 default by 8-17 % a ray where it was measured.
std::string device_config(int threads) { return "max_isa=avx2,threads=" + std::to_string(threads); }

Error embree_error(RTCDevice device, const char* doing) {
  const RTCError code = rtcGetDeviceError(device);
  return {code == RTC_ERROR_OUT_OF_MEMORY ? ErrorCode::kTooLarge : ErrorCode::kIo,
          std::string(doing) + " failed (Embree error " + std::to_string(code) + ")", "Embree"};
}

RTCRay to_rtc(const Ray& ray) {
  RTCRay r;
  r.org_x = ray.o.x;
  r.org_y = ray.o.y;
  r.org_z = ray.o.z;
  r.tnear = 0;
  r.dir_x = ray.d.x;
  r.dir_y = ray.d.y;
  r.dir_z = ray.d.z;
  r.time = 0;
  r.tfar = ray.t_max;
  r.mask = ~0u;
  r.id = 0;
  r.flags = 0;
  return r;
}

// Of one occlusion query: what its rays pass. Embree hands the address of its own part on.
struct LightContext {
#if RTC_VERSION_MAJOR >= 4
  RTCRayQueryContext embree;
#else
  RTCIntersectContext embree;
#endif
  Rgb* passed;
};

// Embree asks of one ray or of a few at once. Calls passes(ray, hit, number of the ray).
template <class Passes>
void filter_hits(const RTCFilterFunctionNArguments* args, Passes passes) {
  const unsigned n = args->N;
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] != -1) continue;
    const Ray ray{{RTCRayN_org_x(args->ray, n, i), RTCRayN_org_y(args->ray, n, i),
                   RTCRayN_org_z(args->ray, n, i)},
                  {RTCRayN_dir_x(args->ray, n, i), RTCRayN_dir_y(args->ray, n, i),
                   RTCRayN_dir_z(args->ray, n, i)}};
    Hit hit;
    hit.t = RTCRayN_tfar(args->ray, n, i);
    hit.barycentric = {RTCHitN_u(args->hit, n, i), RTCHitN_v(args->hit, n, i)};
    hit.ng = {RTCHitN_Ng_x(args->hit, n, i), RTCHitN_Ng_y(args->hit, n, i),
              RTCHitN_Ng_z(args->hit, n, i)};
    const unsigned instance = RTCHitN_instID(args->hit, n, i, 0);
    hit.mesh =
        MeshId(instance == RTC_INVALID_GEOMETRY_ID ? RTCHitN_geomID(args->hit, n, i) : instance);
    hit.triangle = RTCHitN_primID(args->hit, n, i);
    if (passes(ray, hit, RTCRayN_id(args->ray, n, i))) args->valid[i] = 0;
  }
}

void filter_intersect(const RTCFilterFunctionNArguments* args) {
  const HitFilter& filter = static_cast<const HitFilters*>(args->geometryUserPtr)->intersect;
  filter_hits(args,
              [&](const Ray& ray, const Hit& hit, unsigned) { return filter.passes(ray, hit); });
}

void filter_occluded(const RTCFilterFunctionNArguments* args) {
  const LightFilter& filter = static_cast<const HitFilters*>(args->geometryUserPtr)->occluded;
  Rgb* passed = reinterpret_cast<const LightContext*>(args->context)->passed;
  filter_hits(args, [&](const Ray& ray, const Hit& hit, unsigned id) {
    const Rgb share = filter.passed(ray, hit);
    passed[id] *= share;
    return !share.is_black();
  });
}

Result<RTCGeometry> make_triangles(RTCDevice device, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree pads the buffers it allocates, as its vector loads need; a std::vector has no padding.
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(Vec3), mesh.positions.size());
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          3 * sizeof(uint32_t), mesh.triangles.size());
  if (!vertices || !indices) {
    rtcReleaseGeometry(geometry);
    return embree_error(device, "allocating a mesh");
  }
  std::memcpy(vertices, mesh.positions.data(), mesh.positions.size() * sizeof(Vec3));
  std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(uint32_t));
  return geometry;
}

Result<RTCGeometry> make_sphere(RTCDevice device, const Sphere& sphere) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  auto* place = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), 1));
  if (!place) {
    rtcReleaseGeometry(geometry);
    return embree_error(device, "allocating a sphere");
  }
  for (int i = 0; i < 3; ++i) place[i] = sphere.center[i];
  place[3] = sphere.radius;
  return geometry;
}

// `intersect`, `occluded`: whether that filter is asked.
Result<RTCGeometry> make_geometry(RTCDevice device, const Mesh& mesh, HitFilters* filters,
                                  bool intersect, bool occluded) {
  Result<RTCGeometry> made =
      mesh.sphere ? make_sphere(device, *mesh.sphere) : make_triangles(device, mesh);
  if (!made) return made;
  const RTCGeometry geometry = made.value();
  rtcSetGeometryUserData(geometry, filters);
  if (intersect) rtcSetGeometryIntersectFilterFunction(geometry, filter_intersect);
  if (occluded) rtcSetGeometryOccludedFilterFunction(geometry, filter_occluded);
  rtcCommitGeometry(geometry);
  return geometry;
}

RTCScene make_scene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  return scene;
}

void attach(RTCScene scene, RTCGeometry geometry, size_t id) {
  rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(id));
  rtcReleaseGeometry(geometry);
}

void attach_instance(RTCDevice device, RTCScene scene, RTCScene mesh, const Transform& to_world,
                     size_t id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh);
  float rows[12];
  for (size_t i = 0; i < 12; ++i) rows[i] = static_cast<float>(to_world.rows[i / 4][i % 4]);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
  rtcCommitGeometry(geometry);
  attach(scene, geometry, id);
}

}  // namespace

struct EmbreeScene::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<RTCScene> instanced;  // by MeshId; null: not instanced
  size_t mesh_count = 0;
  std::vector<Mat3> normals_to_world;  // by instance
  HitFilters filters;
  std::atomic<int64_t> size_bytes{0};
  ~Impl() {
    for (RTCScene mesh : instanced)
      if (mesh) rtcReleaseScene(mesh);
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

EmbreeScene::EmbreeScene(std::unique_ptr<Impl> impl)
    : impl_(std::move(impl)), scene_(impl_->scene) {}

EmbreeScene::~EmbreeScene() = default;

size_t EmbreeScene::size_bytes() const { return static_cast<size_t>(impl_->size_bytes.load()); }

Result<std::unique_ptr<EmbreeScene>> EmbreeScene::build(const Scene& scene, int build_threads,
                                                        HitFilters filters,
                                                        const Progress& progress) {
  auto impl = std::make_unique<Impl>();
  impl->filters = std::move(filters);
  impl->device = rtcNewDevice(device_config(build_threads).c_str());
  if (!impl->device) return embree_error(nullptr, "making a device");
  rtcSetDeviceMemoryMonitorFunction(
      impl->device,
      [](void* sum, ssize_t bytes, bool) {
        *static_cast<std::atomic<int64_t>*>(sum) += bytes;
        return true;
      },
      &impl->size_bytes);
  impl->scene = make_scene(impl->device);
  impl->mesh_count = scene.meshes.size();
  impl->instanced.resize(scene.meshes.size());
  const auto filtered_by = [&scene](std::vector<bool> meshes) {
    meshes.resize(scene.meshes.size() + scene.instances.size());
    for (size_t i = 0; i < scene.instances.size(); ++i)
      if (meshes[scene.meshes.size() + i]) meshes[scene.instances[i].mesh.value] = true;
    return meshes;
  };
  const std::vector<bool> intersect = filtered_by(impl->filters.intersect.meshes),
                          occluded = filtered_by(impl->filters.occluded.meshes);
  for (const Instance& instance : scene.instances) {
    RTCScene& mesh = impl->instanced[instance.mesh.value];
    if (!mesh) mesh = make_scene(impl->device);
  }
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    if (scene.meshes[m].empty()) continue;
    Result<RTCGeometry> geometry =
        make_geometry(impl->device, scene.meshes[m], &impl->filters, intersect[m], occluded[m]);
    if (!geometry) return geometry.error();
    if (RTCScene mesh = impl->instanced[m]) {
      attach(mesh, geometry.value(), 0);
      rtcCommitScene(mesh);
    } else {
      attach(impl->scene, geometry.value(), m);
    }
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    attach_instance(impl->device, impl->scene, impl->instanced[instance.mesh.value],
                    instance.to_world, impl->mesh_count + i);
    impl->normals_to_world.push_back(instance.to_world.normals());
  }
  if (progress) {
    rtcSetSceneProgressMonitorFunction(
        impl->scene,
        [](void* told, double fraction) { return (*static_cast<const Progress*>(told))(fraction); },
        const_cast<Progress*>(&progress));
  }
  rtcCommitScene(impl->scene);
  rtcSetSceneProgressMonitorFunction(impl->scene, nullptr, nullptr);
  if (const RTCError code = rtcGetDeviceError(impl->device); code != RTC_ERROR_NONE) {
    if (code == RTC_ERROR_CANCELLED) return Error{ErrorCode::kCanceled, "canceled", ""};
    return Error{code == RTC_ERROR_OUT_OF_MEMORY ? ErrorCode::kTooLarge : ErrorCode::kIo,
                 "building the tree failed (Embree error " + std::to_string(code) + ")", "Embree"};
  }
  return std::unique_ptr<EmbreeScene>(new EmbreeScene(std::move(impl)));
}

bool EmbreeScene::intersect(const Ray& ray, Hit& hit) const {
  RTCRayHit query;
  query.ray = to_rtc(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(static_cast<RTCScene>(scene_), &query, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(static_cast<RTCScene>(scene_), &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit.t = query.ray.tfar;
  hit.barycentric = {query.hit.u, query.hit.v};
  hit.ng = {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z};
  hit.mesh = MeshId(query.hit.geomID);
  if (const unsigned instance = query.hit.instID[0]; instance != RTC_INVALID_GEOMETRY_ID) {
    hit.mesh = MeshId(instance);
    hit.ng = impl_->normals_to_world[instance - impl_->mesh_count] * hit.ng;
  }
  hit.triangle = query.hit.primID;
  return true;
}

uint32_t EmbreeScene::intersect(const Vec3Lanes& o, const Vec3Lanes& d, uint32_t lanes,
                                HitLanes& hits) const {
  static_assert(kWidth == 8);
  RTCRayHit8 query;
  const auto copy = [](float* to, const FloatLanes& from) {
    std::memcpy(to, from.v, sizeof from.v);
  };
  copy(query.ray.org_x, o.x), copy(query.ray.org_y, o.y), copy(query.ray.org_z, o.z);
  copy(query.ray.dir_x, d.x), copy(query.ray.dir_y, d.y), copy(query.ray.dir_z, d.z);
  std::fill_n(query.ray.tnear, kWidth, 0.0f);
  std::fill_n(query.ray.tfar, kWidth, std::numeric_limits<float>::infinity());
  std::fill_n(query.ray.time, kWidth, 0.0f);
  std::fill_n(query.ray.mask, kWidth, ~0u);
  std::fill_n(query.ray.id, kWidth, 0u);
  std::fill_n(query.ray.flags, kWidth, 0u);
  std::fill_n(query.hit.geomID, kWidth, RTC_INVALID_GEOMETRY_ID);
  std::fill_n(query.hit.instID[0], kWidth, RTC_INVALID_GEOMETRY_ID);
  const WideInt valid = mask_of(lanes);
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect8(reinterpret_cast<const int*>(&valid), static_cast<RTCScene>(scene_), &query,
                nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect8(reinterpret_cast<const int*>(&valid), static_cast<RTCScene>(scene_), &context,
                &query);
#endif
  std::memcpy(hits.t.v, query.ray.tfar, sizeof hits.t.v);
  std::memcpy(hits.second.v, query.hit.u, sizeof hits.t.v);
  std::memcpy(hits.third.v, query.hit.v, sizeof hits.t.v);
  std::memcpy(hits.ng.x.v, query.hit.Ng_x, sizeof hits.t.v);
  std::memcpy(hits.ng.y.v, query.hit.Ng_y, sizeof hits.t.v);
  std::memcpy(hits.ng.z.v, query.hit.Ng_z, sizeof hits.t.v);
  std::memcpy(hits.mesh.data(), query.hit.geomID, sizeof hits.mesh);
  std::memcpy(hits.triangle.data(), query.hit.primID, sizeof hits.triangle);
  uint32_t found = 0;
  for_each_lane(lanes, [&](int i) {
    if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) return;
    found |= 1u << i;
    const unsigned instance = query.hit.instID[0][i];
    if (instance == RTC_INVALID_GEOMETRY_ID) return;
    hits.mesh[static_cast<size_t>(i)] = instance;
    hits.ng.set(i, impl_->normals_to_world[instance - impl_->mesh_count] * hits.ng[i]);
  });
  return found;
}

void EmbreeScene::occluded(std::span<OcclusionRay> rays, std::span<Rgb> passed) const {
  static_assert(sizeof(OcclusionRay) == sizeof(RTCRay) &&
                alignof(OcclusionRay) == alignof(RTCRay) &&
                offsetof(OcclusionRay, d) == offsetof(RTCRay, dir_x) &&
                offsetof(OcclusionRay, t_max) == offsetof(RTCRay, tfar) &&
                offsetof(OcclusionRay, flags) == offsetof(RTCRay, flags));
  RTCRay* first = reinterpret_cast<RTCRay*>(rays.data());
  LightContext context;
  context.passed = passed.data();
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&context.embree);
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context.embree;
  for (RTCRay* ray = first; ray != first + rays.size(); ++ray)
    rtcOccluded1(static_cast<RTCScene>(scene_), ray, &arguments);
#else
  rtcInitIntersectContext(&context.embree);
  rtcOccluded1M(static_cast<RTCScene>(scene_), &context.embree, first,
                static_cast<unsigned>(rays.size()), sizeof(RTCRay));
#endif
}

}  // namespace qray
