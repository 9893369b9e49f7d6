#include "core/accel/embree_scene.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cstddef>
#include <cstring>
#include <string>

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

// Embree asks of one ray or of a few at once.
void filter_hits(const RTCFilterFunctionNArguments* args) {
  const HitFilter& filter = *static_cast<const HitFilter*>(args->geometryUserPtr);
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
    hit.mesh = MeshId(RTCHitN_geomID(args->hit, n, i));
    hit.triangle = RTCHitN_primID(args->hit, n, i);
    if (filter.passes(ray, hit)) args->valid[i] = 0;
  }
}

}  // namespace

struct EmbreeScene::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  HitFilter filter;
  ~Impl() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

EmbreeScene::EmbreeScene(std::unique_ptr<Impl> impl)
    : impl_(std::move(impl)), scene_(impl_->scene) {}

EmbreeScene::~EmbreeScene() = default;

Result<std::unique_ptr<EmbreeScene>> EmbreeScene::build(const Scene& scene, int build_threads,
                                                        HitFilter filter) {
  auto impl = std::make_unique<Impl>();
  impl->filter = std::move(filter);
  impl->device = rtcNewDevice(device_config(build_threads).c_str());
  if (!impl->device) return embree_error(nullptr, "making a device");
  impl->scene = rtcNewScene(impl->device);
  rtcSetSceneBuildQuality(impl->scene, RTC_BUILD_QUALITY_MEDIUM);
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    if (mesh.triangles.empty()) continue;
    RTCGeometry geometry = rtcNewGeometry(impl->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree pads the buffers it allocates, as its vector loads need; a std::vector has no padding.
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             sizeof(Vec3), mesh.positions.size());
    void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(uint32_t), mesh.triangles.size());
    if (!vertices || !indices) {
      rtcReleaseGeometry(geometry);
      return embree_error(impl->device, "allocating a mesh");
    }
    std::memcpy(vertices, mesh.positions.data(), mesh.positions.size() * sizeof(Vec3));
    std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(uint32_t));
    if (m < impl->filter.meshes.size() && impl->filter.meshes[m]) {
      rtcSetGeometryUserData(geometry, &impl->filter);
      rtcSetGeometryIntersectFilterFunction(geometry, filter_hits);
      rtcSetGeometryOccludedFilterFunction(geometry, filter_hits);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(impl->scene, geometry, static_cast<unsigned>(m));
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(impl->scene);
  if (const RTCError code = rtcGetDeviceError(impl->device); code != RTC_ERROR_NONE) {
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
  hit.triangle = query.hit.primID;
  return true;
}

void EmbreeScene::occluded(std::span<OcclusionRay> rays) const {
  static_assert(sizeof(OcclusionRay) == sizeof(RTCRay) &&
                alignof(OcclusionRay) == alignof(RTCRay) &&
                offsetof(OcclusionRay, d) == offsetof(RTCRay, dir_x) &&
                offsetof(OcclusionRay, t_max) == offsetof(RTCRay, tfar) &&
                offsetof(OcclusionRay, flags) == offsetof(RTCRay, flags));
  RTCRay* first = reinterpret_cast<RTCRay*>(rays.data());
#if RTC_VERSION_MAJOR >= 4
  for (RTCRay* ray = first; ray != first + rays.size(); ++ray)
    rtcOccluded1(static_cast<RTCScene>(scene_), ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1M(static_cast<RTCScene>(scene_), &context, first, static_cast<unsigned>(rays.size()),
                sizeof(RTCRay));
#endif
}

}  // namespace qray
